// SPDX-License-Identifier: Apache-2.0
// Images of real halls, with only their settings (field, ball, heights, calibration): colours are learnt from
// the images, then all images are processed and compared with a ground truth checked by a person.
#include "base/json.h"
#include "geometry/camera_model.h"
#include "support/child_process.h"
#include "support/paths.h"
#include "support/temporary_folder.h"
#include "support/test_data.h"

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <numbers>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

namespace sslv::test::photos_test {
namespace {

namespace fs = std::filesystem;

void run_or_fail(const std::vector<std::string>& words, std::string* output = nullptr) {
  const Finished run = run_to_end(words);
  ASSERT_EQ(run.exit_code, 0) << run.output;
  if (output != nullptr) *output = run.output;
}

/// Expects all robots with their ids, all balls except `balls_missed`, and nothing else. `hall` contains
/// settings.json, images of its first camera, and truth.jsonl.
void everything_is_found(const fs::path& hall, int balls_missed = 0) {
  const TemporaryFolder folder;
  const std::string settings_file = hall / "settings.json", truth = hall / "truth.jsonl";
  ASSERT_TRUE(fs::exists(truth)) << truth << ": make it with ssl-visionlab annotate";
  const Json settings = Json::parse(std::ifstream(settings_file));
  const std::string camera = std::to_string(settings["cameras"][0].value("id", 0));
  run_or_fail({ctl_program(), "learn-colours", "--settings", settings_file, "--camera", camera, "--input",
               hall, "--output", folder.file("table.lut")});
  if (testing::Test::HasFatalFailure()) return;
  run_or_fail({lab_program(), "process", "--settings", settings_file, "--camera", camera, "--lut",
               folder.file("table.lut"), "--input", hall, "--output", folder.file("found")});
  if (testing::Test::HasFatalFailure()) return;
  std::string text;
  run_or_fail({lab_program(), "score", "--json", "--detections", folder.file("found"), "--truth", truth},
              &text);
  if (testing::Test::HasFatalFailure()) return;

  const Json score = Json::parse(text);
  EXPECT_GE(score["frames_compared"], 1);
  for (const char* list : {"frames_without_detections", "frames_without_truth", "frames_not_checked"})
    EXPECT_EQ(score[list], Json::array()) << list;
  for (const char* kind : {"robots", "balls"}) {
    const Json& counts = score[kind];
    std::cout << hall.filename().string() << ": " << kind << " " << counts["found"] << " of "
              << counts["expected"] << ", wrong id " << counts["wrong_id"] << ", false " << counts["invented"]
              << "\n";
    const int missed = counts["expected"].get<int>() - counts["found"].get<int>();
    const int may_be_missed = kind == std::string_view("balls") ? balls_missed : 0;
    EXPECT_LE(missed, may_be_missed) << kind;
    EXPECT_EQ(counts["wrong_id"], 0) << kind;
    EXPECT_EQ(counts["invented"], 0) << kind;
  }
}

TEST(RealHalls, EverythingIsFoundWithLearntColours) {
  const char* set = std::getenv("SSLV_PHOTOS");
  if (set == nullptr) {
    GTEST_SKIP()
        << "SSLV_PHOTOS is not set: the folder with a folder for each hall (settings.json, pictures, "
           "truth.jsonl; see docs/accuracy.md, \"Your own hall\")";
  }
  int halls = 0;
  for (const auto& entry : fs::directory_iterator(set)) {
    if (!fs::exists(entry.path() / "settings.json")) continue;
    SCOPED_TRACE(entry.path().string());
    everything_is_found(entry.path());
    ++halls;
  }
  EXPECT_GT(halls, 0) << set << " holds no folder with a settings.json";
}

/// A lab's procedure with simulated images, so that it is also tested where there are no photos.
TEST(RealHalls, ADrawnOneIsAnnotatedAndFoundToo) {
  const TemporaryFolder folder;
  const fs::path hall = folder.path() / "drawn";
  const std::string demo = source_path("/config/demo.json");
  run_or_fail(
      {lab_program(), "simulate", "--settings", demo, "--frames", "4", "--start", "1000", "--output", hall});
  run_or_fail({lab_program(), "annotate", "--settings", demo, "--input", hall, "--truth",
               folder.file("truth.jsonl"), "--checked"});
  if (testing::Test::HasFatalFailure()) return;
  fs::copy_file(demo, hall / "settings.json");
  fs::copy_file(folder.path() / "truth.jsonl", hall / "truth.jsonl", fs::copy_options::overwrite_existing);
  everything_is_found(hall);
}

/// The ground truth of a photo annotated in pixels and degrees, for a camera that looks straight down with +x
/// to the right.
Json truth_of(const Json& annotated, const Json& settings) {
  CameraCalibration c;
  const Json& given = settings["cameras"][0]["calibration"];
  c.focal_length = given["focal_length"];
  c.principal_point_x = given["principal_point_x"];
  c.principal_point_y = given["principal_point_y"];
  c.q0 = 1;
  c.q3 = 0;
  c.tz = given["tz"];
  c.pixel_image_width = given["pixel_image_width"];
  c.pixel_image_height = given["pixel_image_height"];
  const CameraModel camera(c);
  const auto place = [&](const Json& px, double height_mm) {
    const Eigen::Vector2d mm = *camera.unproject({px[0].get<double>(), px[1].get<double>()}, height_mm);
    return Json{{"x", mm.x()}, {"y", mm.y()}};
  };
  Json line{{"frame", fs::path(annotated["image"].get<std::string>()).stem().string()},
            {"robots", Json::array()},
            {"balls", Json::array()}};
  for (const Json& robot : annotated["robots"]) {
    Json thing = place(robot["center_px"], settings["teams"]["blue"]["robot_height"]);
    thing.update({{"team", robot["team"]},
                  {"id", robot["id"]},
                  {"orientation", robot["orientation_deg"].get<double>() * std::numbers::pi / 180}});
    line["robots"].push_back(thing);
  }
  const double ball_radius_mm = settings["field"]["ball_radius"];
  for (const Json& ball : annotated["balls"])
    line["balls"].push_back(place(ball["center_px"], ball_radius_mm));
  // A faded ball may be reported or not.
  for (const Json& other : annotated["ignore_or_distractors"]) {
    if (other["kind"].get<std::string>().find("accept either") == std::string::npos) continue;
    Json ball = place(other["center_px"], ball_radius_mm);
    ball["visible_share"] = 0;
    line["balls"].push_back(ball);
  }
  return line;
}

TEST(RealHalls, SixPrintsOnACarpet) {
  const fs::path data = test_data_folder() / "real", photo = data / "ssl_blue6_win.jpg";
  if (!fs::exists(photo)) GTEST_SKIP() << "no " << photo << ": real photos are not part of the project";
  Json settings = Json::parse(std::ifstream(source_path("/tests/golden/ssl_blue6.json")));
  // Nothing tuned for this photo: no colours, default detector parameters.
  settings["cameras"][0].erase("colors");
  settings["cameras"][0].erase("stages");
  const TemporaryFolder hall;
  hall.write("settings.json", settings.dump());
  fs::create_symlink(photo, hall.path() / photo.filename());
  const Json annotations = Json::parse(std::ifstream(data / "annotations.json"));
  for (const Json& picture : annotations["images"]) {
    if (picture["image"] == photo.filename().string())
      hall.write("truth.jsonl", truth_of(picture, settings).dump() + "\n");
  }
  // The lit side of the ball on the carpet is over-exposed, so its confidence is too low.
  everything_is_found(hall.path(), 1);
}

/// Photos from before 2010 and from another league: a guessed table would be worse than none.
TEST(RealHalls, OtherPatternsAreNotLearntFrom) {
  const TemporaryFolder folder;
  Json settings = Json::parse(std::ifstream(source_path("/config/demo.json")));
  settings["cameras"][0].erase("calibration");
  const std::string settings_file = folder.write("settings.json", settings.dump());
  for (const char* name : {"cmu2008_raw_780x580.jpg", "vsss_rodetas_scene1_640x480.png"}) {
    const fs::path photo = test_data_folder() / "real" / name;
    if (!fs::exists(photo)) GTEST_SKIP() << "no " << photo << ": real photos are not part of the project";
    const Finished run =
        run_to_end({ctl_program(), "learn-colours", "--settings", settings_file, "--input", photo});
    EXPECT_EQ(run.exit_code, 1) << name;
    EXPECT_NE(run.output.find("no robot was found"), std::string::npos) << name << ": " << run.output;
  }
}

}  // namespace
}  // namespace sslv::test::photos_test
