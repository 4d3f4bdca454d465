// SPDX-License-Identifier: Apache-2.0
// ssl-visionlab with files (simulate, process, score, and a real photo), and ssl-visionctl with a running
// daemon.
#include "base/params_json.h"
#include "e2e/running_daemon.h"
#include "geometry/camera_model.h"
#include "support/paths.h"
#include "support/test_data.h"

#include <cmath>
#include <fstream>
#include <map>
#include <sstream>
#include <utility>

#include <gmock/gmock.h>

namespace sslv::test::tools_test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::UnorderedElementsAre;

class Tools : public ::testing::Test {
 protected:
  /// Demo settings with camera 0 changed by a JSON Merge Patch.
  std::string settings_with(const char* camera_patch) const {
    Json settings = demo_settings(12345);
    settings["cameras"][0].merge_patch(Json::parse(camera_patch));
    return folder_.write("settings.json", settings.dump(2));
  }
  static void must_run(const std::vector<std::string>& words) {
    const auto run = run_to_end(words);
    ASSERT_EQ(run.exit_code, 0) << run.output;
  }
  /// simulate -> process -> score over `frames` frames.
  Json score(const std::string& settings, int frames, const std::vector<std::string>& raw_format = {}) const {
    std::vector<std::string> simulate{
        lab_program(),          "simulate", "--settings", settings,   "--frames",
        std::to_string(frames), "--start",  "1000",       "--output", folder_.file("frames")};
    std::vector<std::string> process{lab_program(), "process",
                                     "--settings",  settings,
                                     "--input",     folder_.file("frames"),
                                     "--output",    folder_.file("detections.jsonl")};
    if (!raw_format.empty()) {
      simulate.push_back("--raw");
      process.insert(process.end(), raw_format.begin(), raw_format.end());
    }
    must_run(simulate);
    must_run(process);
    const auto scored =
        run_to_end({lab_program(), "score", "--json", "--detections", folder_.file("detections.jsonl"),
                    "--truth", folder_.file("frames/truth.jsonl")});
    EXPECT_EQ(scored.exit_code, 0) << scored.output;
    return Json::parse(scored.output);
  }
  static std::string text_of(const std::string& file) {
    std::ostringstream text;
    text << std::ifstream(file, std::ios::binary).rdbuf();
    return text.str();
  }

  TemporaryFolder folder_;
};

TEST_F(Tools, EveryRobotOfAFolderOfPicturesIsFound) {
  const Json score = this->score(settings_with("{}"), 60);
  EXPECT_EQ(score["frames_compared"], 60);
  EXPECT_EQ(score["robots"]["recall"], 1.0);
  EXPECT_EQ(score["robots"]["precision"], 1.0);
  EXPECT_EQ(score["robots"]["wrong_id"], 0);
  EXPECT_EQ(score["balls"]["invented"], 0);
  EXPECT_LT(score["robot_position_mm"]["mean"], 0.2);
  EXPECT_GT(score["robot_position_mm"]["count"], 200);
}

TEST_F(Tools, RawFramesOfEveryFormat) {
  for (const char* format : {"uyvy", "yuyv", "rgb24", "bgr24"}) {
    const std::string settings =
        settings_with((R"({"source": {"pixel_format": ")" + std::string(format) + R"("}})").c_str());
    const Json score = this->score(settings, 10, {"--pixel-format", format, "--size", "780x580"});
    EXPECT_EQ(score["robots"]["recall"], 1.0) << format;
    EXPECT_EQ(score["robots"]["wrong_id"], 0) << format;
    std::filesystem::remove_all(folder_.file("frames"));
  }
}

TEST_F(Tools, BayerOfALargerSensor) {
  for (const char* format : {"bayer_rg8", "bayer_gr8", "bayer_gb8", "bayer_bg8"}) {
    const std::string settings = settings_with((R"({
      "source": {"pixel_format": ")" + std::string(format) +
                                                R"(", "width": 1280, "height": 952},
      "calibration": {"focal_length": 758.15, "principal_point_x": 642.0, "principal_point_y": 472.8,
                      "pixel_image_width": 1280, "pixel_image_height": 952}})")
                                                   .c_str());
    const Json score = this->score(settings, 10, {"--pixel-format", format, "--size", "1280x952"});
    EXPECT_EQ(score["robots"]["recall"], 1.0) << format;
    EXPECT_EQ(score["robots"]["wrong_id"], 0) << format;
    std::filesystem::remove_all(folder_.file("frames"));
  }
}

TEST_F(Tools, ProcessingIsDeterministic) {
  const std::string settings = settings_with("{}");
  must_run({lab_program(), "simulate", "--settings", settings, "--frames", "3", "--output",
            folder_.file("frames")});
  const auto detections = [&](const char* name) {
    must_run({lab_program(), "process", "--settings", settings, "--input", folder_.file("frames"), "--output",
              folder_.file(name)});
    std::vector<Json> lines;
    std::istringstream text(text_of(folder_.file(name)));
    for (std::string line; std::getline(text, line);) {
      lines.push_back(Json::parse(line));
      EXPECT_EQ(lines.back()["timing_us"].size(), 4u);
      lines.back().erase("timing_us");
    }
    return lines;
  };
  const auto first = detections("a.jsonl");
  EXPECT_EQ(first.size(), 3u);
  EXPECT_EQ(first[0]["frame"], "frame_000000");
  EXPECT_EQ(first, detections("b.jsonl"));
}

TEST_F(Tools, UnreadableFilesAreNamedAndSkipped) {
  const std::string settings = settings_with("{}");
  must_run({lab_program(), "simulate", "--settings", settings, "--frames", "2", "--output",
            folder_.file("frames")});
  folder_.write("frames/frame_000000a.png", "this is no picture");
  const auto run =
      run_to_end({lab_program(), "process", "--settings", settings, "--input", folder_.file("frames")});
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_THAT(run.output,
              AllOf(HasSubstr("frame_000000a.png"), HasSubstr("\"frame\":\"frame_000000\""),
                    HasSubstr("\"frame\":\"frame_000001\""), HasSubstr("1 frames could not be read")));
  must_run({lab_program(), "simulate", "--settings", settings, "--frames", "1", "--raw", "--output",
            folder_.file("raw")});
  const auto wrong = run_to_end({lab_program(), "process", "--settings", settings, "--input",
                                 folder_.file("raw"), "--pixel-format", "uyvy", "--size", "640x480"});
  EXPECT_THAT(wrong.output, AllOf(HasSubstr("frame_000000.raw"), HasSubstr("904800"), HasSubstr("614400")));
  EXPECT_THAT(run_to_end({lab_program(), "process", "--settings", settings, "--input", "/no/such"}).output,
              HasSubstr("/no/such"));
  EXPECT_THAT(
      run_to_end({lab_program(), "process", "--settings", settings, "--camera", "7", "--input", "x"}).output,
      HasSubstr("has no camera 7; known: 0, 1"));
}

TEST_F(Tools, BenchTimesEveryStage) {
  const auto run = run_to_end({lab_program(), "bench", "--json", "--frames", "1", "--rounds", "1",
                               "--settings", settings_with("{}")});
  ASSERT_EQ(run.exit_code, 0) << run.output;
  const Json results = Json::parse(run.output);
  EXPECT_EQ(results.size(), 9u);
  for (const Json& result : results) {
    ASSERT_EQ(result["stages"].size(), 5u);
    EXPECT_EQ(result["stages"][4]["stage"], "total");
    EXPECT_GT(result["stages"][4]["min_us"], 0.0);
  }
}

TEST_F(Tools, TheGoldenPictureHoldsWhatItsTruthSays) {
  const std::string golden = source_path("/tests/golden/division_b");
  must_run({lab_program(), "process", "--settings", golden + ".json", "--input", golden + ".jpg", "--output",
            folder_.file("detections.jsonl")});
  const auto scored = run_to_end({lab_program(), "score", "--json", "--detections",
                                  folder_.file("detections.jsonl"), "--truth", golden + ".truth.jsonl"});
  ASSERT_EQ(scored.exit_code, 0) << scored.output;
  const Json score = Json::parse(scored.output);
  EXPECT_EQ(score["frames_compared"], 1);
  for (const char* kind : {"robots", "balls"}) {
    EXPECT_GE(score[kind]["expected"], 1);
    EXPECT_EQ(score[kind]["recall"], 1.0) << kind;
    EXPECT_EQ(score[kind]["precision"], 1.0) << kind;
  }
  EXPECT_LT(score["robot_position_mm"]["max"], 1);
  EXPECT_LT(score["robot_orientation_deg"]["max"], 1);
  EXPECT_LT(score["ball_position_mm"]["max"], 3);
}

/// A user annotates two images of a hall whose contents are known, and scores with that ground truth.
TEST_F(Tools, AHallsOwnPicturesAreAnnotatedAndScored) {
  const std::string settings = settings_with("{}"), truth = folder_.file("truth.jsonl");
  must_run({lab_program(), "simulate", "--settings", settings, "--frames", "2", "--start", "1000", "--output",
            folder_.file("hall")});
  const auto annotate = [&](const std::vector<std::string>& words) {
    std::vector<std::string> all{lab_program(), "annotate",           "--settings", settings,
                                 "--input",     folder_.file("hall"), "--truth",    truth};
    all.insert(all.end(), words.begin(), words.end());
    return run_to_end(all);
  };
  const auto lines_of = [](const std::string& file) {
    std::map<std::string, Json> lines;
    std::istringstream text(text_of(file));
    for (std::string line; std::getline(text, line);) lines[Json::parse(line)["frame"]] = Json::parse(line);
    return lines;
  };
  const auto scored = [&](const std::string& against) {
    const auto run =
        run_to_end({lab_program(), "score", "--json", "--detections", against, "--truth", truth});
    EXPECT_EQ(run.exit_code, 0) << run.output;
    return Json::parse(run.output);
  };

  // The draft: the detections, with a page for each image.
  const auto first = annotate({});
  ASSERT_EQ(first.exit_code, 0) << first.output;
  EXPECT_THAT(first.output,
              AllOf(HasSubstr("2 of 2 images not checked yet"), HasSubstr("truth_pages/frame_000000.html")));
  EXPECT_THAT(text_of(folder_.file("truth_pages/frame_000000.html")),
              AllOf(HasSubstr("data:image/jpeg;base64,"), HasSubstr("\"frame_000001.html\"")));
  const Json draft = lines_of(truth).at("frame_000000");
  ASSERT_GE(draft["robots"].size(), 2U);

  // Corrections: a removed robot, a wrong id and an additional ball.
  const Json lost = draft["robots"][0], renamed = draft["robots"][1];
  EXPECT_EQ(annotate({"--remove", "1"}).exit_code, 78);  // the image is missing
  const auto corrected = annotate({"--frame", "frame_000000", "--remove", lost["number"].dump(), "--id",
                                   renamed["number"].dump(), "15", "--ball", "30", "30"});
  ASSERT_EQ(corrected.exit_code, 0) << corrected.output;
  const std::string hall = folder_.file("detections.jsonl");
  must_run(
      {lab_program(), "process", "--settings", settings, "--input", folder_.file("hall"), "--output", hall});
  Json score = scored(hall);
  EXPECT_EQ(score["robots"]["invented"], 1);
  EXPECT_EQ(score["robots"]["wrong_id"], 1);
  EXPECT_EQ(score["balls"]["expected"].get<int>() - score["balls"]["found"].get<int>(), 1);
  EXPECT_EQ(score["frames_not_checked"], Json::array({"frame_000000", "frame_000001"}));

  // Restored by hand: the lost robot from two pixels, its centre and a point in front of it.
  const Json ball = lines_of(truth).at("frame_000000")["balls"].back();
  const CameraModel camera(
      params_from_json<CameraCalibration>(demo_settings(1)["cameras"][0]["calibration"], ""));
  const double turn = lost["orientation"], reach_mm = 80;
  const auto front = camera.project({lost["x"].get<double>() + reach_mm * std::cos(turn),
                                     lost["y"].get<double>() + reach_mm * std::sin(turn), lost["height"]});
  const auto mended = annotate({"--frame", "frame_000000", "--remove", ball["number"].dump(), "--id",
                                renamed["number"].dump(), renamed["id"].dump(), "--robot", lost["team"],
                                lost["id"].dump(), lost["pixel_x"].dump(), lost["pixel_y"].dump(),
                                std::to_string(front->x()), std::to_string(front->y())});
  ASSERT_EQ(mended.exit_code, 0) << mended.output;
  EXPECT_THAT(mended.output, HasSubstr("by hand"));
  ASSERT_EQ(annotate({"--checked"}).exit_code, 0);
  score = scored(hall);
  for (const char* kind : {"robots", "balls"}) {
    EXPECT_EQ(score[kind]["recall"], 1.0) << kind;
    EXPECT_EQ(score[kind]["precision"], 1.0) << kind;
  }
  EXPECT_EQ(score["frames_not_checked"], Json::array());
  EXPECT_LT(score["robot_position_mm"]["max"], 0.01);
  EXPECT_LT(score["robot_orientation_deg"]["max"], 0.01);

  // Refused commands leave the file unchanged.
  const std::string before = text_of(truth);
  EXPECT_THAT(annotate({"--frame", "frame_000000", "--remove", "99"}).output, HasSubstr("has no mark 99"));
  EXPECT_THAT(annotate({"--frame", "no"}).output, HasSubstr("has no image \"no\""));
  EXPECT_EQ(text_of(truth), before);
  // A ground truth from another program has no marks and is not overwritten.
  const auto simulated = run_to_end({lab_program(), "annotate", "--settings", settings, "--input",
                                     folder_.file("hall"), "--truth", folder_.file("hall/truth.jsonl")});
  EXPECT_EQ(simulated.exit_code, 78);
  EXPECT_THAT(simulated.output, HasSubstr("is not of a file that `annotate` wrote"));
}

TEST_F(Tools, TheAccuracySuiteHoldsWhereItMust) {
  // A part of `./run accuracy`, with the limits defined in the suite.
  const auto run =
      run_to_end({lab_program(), "score", "--suite", source_path("/tests/golden/accuracy.json"), "--frames",
                  "12", "--only", "field A", "field A, Bayer", "field B, RGB", "noise 15", "light 0.3",
                  "gradient to 10 %", "touching at 1 mm", "one dot covered"});
  EXPECT_EQ(run.exit_code, 0) << run.output;
}

class AskingADaemon : public DaemonTest {
 protected:
  Finished ask(std::vector<std::string> words) const {
    words.insert(words.begin(), {ctl_program(), "--daemon", daemon_.address()});
    return run_to_end(words);
  }
  /// Its output; expects exit code 0.
  std::string answer(const std::vector<std::string>& words) const {
    const Finished run = ask(words);
    EXPECT_EQ(run.exit_code, 0) << run.output;
    return run.output;
  }
  Json settings() const { return daemon_.get("/api/settings").at("settings"); }

  RunningDaemon daemon_{settings_file(), state_};
};

TEST_F(AskingADaemon, SettingsAreShownAndSet) {
  EXPECT_EQ(answer({"settings", "get", "/site"}), "Demo field\n");
  EXPECT_EQ(answer({"settings", "get", "/site", "--json"}), "\"Demo field\"\n");
  EXPECT_EQ(Json::parse(answer({"settings", "get"})), settings());
  EXPECT_EQ(answer({"settings", "set", "/site", "get", "/teams/yellow/ids", "[0,1]", "/ball_models/acc_slide",
                    "-3.1"}),
            "/site: \"Demo field\" -> \"get\"\n"
            "/ball_models/acc_slide: -3.4 -> -3.1\n"
            "/teams/yellow/ids/0: nothing -> 0\n"
            "/teams/yellow/ids/1: nothing -> 1\n"
            "saved, revision 2\n");
  EXPECT_EQ(settings()["teams"]["yellow"]["ids"], Json::array({0, 1}));
  const Json appended = Json::parse(answer({"settings", "set", "--json", "/teams/yellow/ids/-", "7"}));
  EXPECT_EQ(appended, Json::parse(R"({"changes": [{"op": "add", "path": "/teams/yellow/ids/2", "after": 7}],
                                      "revision": 3})"));
  EXPECT_THAT(answer({"settings", "remove", "/teams/yellow/ids/0"}),
              HasSubstr("/teams/yellow/ids/2: 7 -> nothing\nsaved, revision 4\n"));
  EXPECT_EQ(settings()["teams"]["yellow"]["ids"], Json::array({1, 7}));
  EXPECT_THAT(answer({"settings", "schema", "/field/line_thickness"}),
              HasSubstr("/field/line_thickness  integer  1 .. 500  mm    width of the painted lines\n"));
}

TEST_F(AskingADaemon, RefusalsAreOneLine) {
  const auto refused = [&](const std::vector<std::string>& words, int exit_code, const char* text) {
    const Finished run = ask(words);
    EXPECT_EQ(run.exit_code, exit_code) << run.output;
    EXPECT_THAT(run.output, AllOf(HasSubstr(text), Not(HasSubstr("{"))));
    if (exit_code == 1) {
      EXPECT_EQ(run.output.find('\n'), run.output.size() - 1) << run.output;
    }
  };
  const Json before = settings();
  refused({"settings", "set", "/field/line_thickness", "0", "/site", "A"}, 1,
          "/field/line_thickness: 0 is not allowed");
  refused({"settings", "set", "site", "A"}, 1, "expected a JSON pointer");
  refused({"settings", "get", "/cameras/5/name"}, 1, "/cameras has a list of 2");
  refused({"settings", "remove", "/sit"}, 1, "the tree has site, field");
  refused({"settings", "set", "/site"}, 64, "a POINTER and a VALUE");
  refused({"settings", "set", "--no-such", "/site", "A"}, 64, "--no-such");
  refused({"field", "set", "division-c"}, 1, "no field \"division-c\"; known: division-a, division-b");
  EXPECT_EQ(settings(), before);
  answer({"settings", "set", "/site", "A"});
  answer({"settings", "set", "/site", "B"});
  refused({"undo", "2"}, 1, "127.0.0.1 made revision 3: /site: \"A\" -> \"B\"");
}

TEST_F(AskingADaemon, ExportedSettingsComeBack) {
  const std::string file = folder_.file("exported.json");
  answer({"settings", "export", file});
  const Json exported = settings();
  Json with_version{{"version", 3}};
  with_version.update(exported);
  EXPECT_EQ(Json::parse(std::ifstream(file)), with_version);
  EXPECT_EQ(Json::parse(answer({"settings", "export"})), with_version);
  EXPECT_THAT(answer({"field", "set", "division-a"}), HasSubstr("/field/field_length: 9000 -> 12000\n"));
  EXPECT_THAT(answer({"field", "presets"}), HasSubstr("division-a    12000 x 9000 mm"));
  answer({"settings", "set", "/site", "Elsewhere"});
  EXPECT_THAT(answer({"settings", "import", file}),
              AllOf(HasSubstr("/site: \"Elsewhere\" -> \"Demo field\"\n"),
                    HasSubstr("/field/field_length: 12000 -> 9000\n"), HasSubstr("saved, revision 4\n")));
  EXPECT_EQ(settings(), exported);
  const Finished broken = ask({"settings", "import", folder_.write("broken.json", "{\"site\": ")});
  EXPECT_EQ(broken.exit_code, 78);
  EXPECT_THAT(broken.output, HasSubstr("broken.json"));
}

TEST_F(AskingADaemon, CamerasAndAlertsAreTables) {
  daemon_.wait_for_status([](const Json& status) {
    return status["cameras"][0]["robots"] > 0 && status["cameras"][1]["robots"] > 0;
  });
  const std::string cameras = answer({"cameras"});
  EXPECT_THAT(cameras, AllOf(HasSubstr("id  name     state "), HasSubstr("\n 0  -x half  running "),
                             HasSubstr("\n 1  +x half  running ")));
  EXPECT_EQ(Json::parse(answer({"cameras", "--json"})).size(), 2u);

  daemon_.set("/cameras/1/source", {{"backend", "files"}, {"path", source_path("/tests/no/such")}});
  daemon_.wait_for_status([](const Json& status) { return status["cameras"][1]["state"] == "lost"; });
  EXPECT_THAT(answer({"cameras", "reopen", "1"}), HasSubstr("\n 1  +x half  lost "));
  EXPECT_THAT(ask({"cameras", "reopen", "0"}).output, HasSubstr("camera 0 is open"));
  const Finished alerts = ask({"alerts"});
  EXPECT_EQ(alerts.exit_code, 1);
  EXPECT_EQ(alerts.output.substr(0, 6), "bad   ") << alerts.output;
  EXPECT_THAT(alerts.output, HasSubstr("/no/such"));
  EXPECT_EQ(Json::parse(ask({"alerts", "--json"}).output)[0]["severity"], "bad");
}

/// Bash's completions for these words, the last of which is incomplete.
std::string completed(const std::string& program, const std::vector<std::string>& words) {
  std::vector<std::string> all{
      "/bin/bash", "-c",
      "source <(\"$0\" completion bash) && name=${0##*/} && COMP_WORDS=($name \"$@\") && COMP_CWORD=$# && "
      "_${name/-/_} && complete -p $name >/dev/null && echo \"${COMPREPLY[*]}\"",
      program};
  all.insert(all.end(), words.begin(), words.end());
  return run_to_end(all).output;
}

TEST(Completion, OffersTheCommandsAndOptionsOfAPlace) {
  EXPECT_EQ(completed(ctl_program(), {"sett"}), "settings\n");
  EXPECT_EQ(completed(ctl_program(), {"settings", "s"}), "set schema\n");
  EXPECT_EQ(completed(ctl_program(), {"settings", "import", "--d"}), "--dry-run\n");
  EXPECT_EQ(completed(lab_program(), {"annotate", "--pa"}), "--pages\n");
  EXPECT_EQ(completed(lab_program(), {"score", "--min"}), "--min-robot-share --min-ball-share\n");
  EXPECT_EQ(completed(ctl_program(), {"ben"}), "");
  EXPECT_EQ(completed(ctl_program(), {"--da"}), "--daemon\n");
  EXPECT_EQ(completed(ctl_program(), {"--daemon", "status", "wat"}),
            "watch\n");  // an option's value is not a command
  EXPECT_EQ(completed(ctl_program(), {"snapshot", "--output", "sta"}), "\n");  // a file: left to the shell
}

TEST(Laboratory, IsReachedByTheNamesOfItsCommandsInSslVisionctl) {
  const Finished direct = run_to_end({lab_program(), "bench", "--help"});
  EXPECT_EQ(direct.exit_code, 0);
  EXPECT_THAT(direct.output, HasSubstr("ssl-visionlab bench [OPTIONS]"));
  for (const auto& words : std::vector<std::vector<std::string>>{
           {"bench", "--help"}, {"--help", "bench"}, {"--daemon", "score", "bench", "--help"}}) {
    std::vector<std::string> all{ctl_program()};
    all.insert(all.end(), words.begin(), words.end());
    const Finished run = run_to_end(all);
    EXPECT_EQ(run.output, direct.output) << words.front();
    EXPECT_EQ(run.exit_code, 0);
  }
  EXPECT_EQ(run_to_end({ctl_program(), "score", "--no-such"}).exit_code, 64);
  EXPECT_EQ(run_to_end({lab_program(), "--version"}).output.substr(0, 14), "ssl-visionlab ");
}

TEST(Laboratory, WhenItIsMissingItIsNamed) {
  const TemporaryFolder folder;
  const std::string alone = folder.file("ssl-visionctl");
  std::filesystem::copy_file(ctl_program(), alone);
  for (const auto& [words, name] : std::vector<std::pair<std::vector<std::string>, std::string>>{
           {{"bench"}, "bench"},
           {{"clip", "info", "x.clip"}, "clip info"},
           {{"learn-colours", "--settings", "x.json", "--input", "x"}, "learn-colours --input"}}) {
    std::vector<std::string> all{alone};
    all.insert(all.end(), words.begin(), words.end());
    const Finished run = run_to_end(all);
    EXPECT_EQ(run.exit_code, 69);
    EXPECT_EQ(run.output, "ssl-visionctl: " + name + " is a command of ssl-visionlab, which does not run: " +
                              folder.file("ssl-visionlab") + ": No such file or directory\n");
  }
}

TEST(RealPhoto, SixRobotsWithTheirIdsAndTwoBalls) {
  const auto photo = test_data_folder() / "real/ssl_blue6_win.jpg";
  if (!std::filesystem::exists(photo))
    GTEST_SKIP() << "no " << photo << ": real photos are not part of the project";
  const auto run = run_to_end({lab_program(), "process", "--settings",
                               source_path("/tests/golden/ssl_blue6.json"), "--input", photo.string()});
  ASSERT_EQ(run.exit_code, 0) << run.output;
  const Json found = Json::parse(run.output);
  const Json annotations = Json::parse(std::ifstream(test_data_folder() / "real/annotations.json"));
  ASSERT_EQ(found["robots"].size(), 6u);
  double squares_px2 = 0;
  for (const Json& picture : annotations["images"]) {
    if (picture["image"] != "ssl_blue6_win.jpg") continue;
    for (const Json& truth : picture["robots"]) {
      const auto robot = std::find_if(found["robots"].begin(), found["robots"].end(), [&](const Json& one) {
        return one["id"] == truth["id"] && one["team"] == truth["team"];
      });
      ASSERT_NE(robot, found["robots"].end()) << truth.dump();
      const double dx = robot->at("pixel_x").get<double>() - truth["center_px"][0].get<double>();
      const double dy = robot->at("pixel_y").get<double>() - truth["center_px"][1].get<double>();
      squares_px2 += (dx * dx + dy * dy) / 6;
      const double turn =
          robot->at("orientation").get<double>() * 180 / M_PI - truth["orientation_deg"].get<double>();
      EXPECT_LT(std::abs(std::remainder(turn, 360)), 1.5) << truth.dump();
    }
    // Two orange balls, one of them at a post; a white and a brown one, a box, a wooden floor.
    EXPECT_EQ(found["balls"].size(), picture["balls"].size()) << found["balls"].dump();
    for (const Json& truth : picture["balls"]) {
      const bool seen = std::any_of(found["balls"].begin(), found["balls"].end(), [&](const Json& ball) {
        return std::hypot(ball["pixel_x"].get<double>() - truth["center_px"][0].get<double>(),
                          ball["pixel_y"].get<double>() - truth["center_px"][1].get<double>()) < 4;
      });
      EXPECT_TRUE(seen) << truth.dump() << found["balls"].dump();
    }
  }
  EXPECT_LT(std::sqrt(squares_px2), 1.0);
}

}  // namespace
}  // namespace sslv::test::tools_test
