// SPDX-License-Identifier: Apache-2.0
#include "lab/simulate.h"

#include "lab/score.h"
#include "support/temporary_folder.h"

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include <gmock/gmock.h>

namespace sslv::simulate_test {
namespace {

std::string contents(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::stringstream out;
  out << in.rdbuf();
  return out.str();
}

class SimulateTest : public testing::Test {
 protected:
  SimulateTest() {
    CameraCalibration c;
    c.focal_length = 100;
    c.principal_point_x = 64;
    c.principal_point_y = 48;
    c.q0 = 1;
    c.q3 = 0;
    c.tz = 5000;
    options_.context.scene.camera.emplace(c);
    options_.source = {{"width", 128}, {"height", 96}, {"frame_rate_hz", 10}};
    options_.frames = 3;
    options_.start_s = 1000;
    options_.folder = folder_.string();
  }

  const test::TemporaryFolder temporary_;
  const std::filesystem::path folder_ = temporary_.path() / "simulated";
  SimulateOptions options_;
};

TEST_F(SimulateTest, WritesPicturesAndTheirTruth) {
  simulate(options_);
  const std::string picture = contents(folder_ / "frame_000002.ppm");
  EXPECT_EQ(picture.substr(0, 14), "P6\n128 96\n255\n");
  EXPECT_EQ(picture.size(), 14U + 3 * 128 * 96);
  std::istringstream truth(contents(folder_ / "truth.jsonl"));
  std::string line;
  for (int i = 0; i < 3; ++i) {
    ASSERT_TRUE(std::getline(truth, line));
    const Json json = Json::parse(line);
    EXPECT_EQ(json["frame"], "frame_00000" + std::to_string(i));
    EXPECT_NEAR(json["t"].get<double>(), 1000 + 0.1 * i, 1e-9);
    EXPECT_GT(json["robots"].size(), 5U);
  }
  EXPECT_FALSE(std::getline(truth, line));
}

TEST_F(SimulateTest, TheTruthScoresFullAgainstItself) {
  simulate(options_);
  const Score s = score_files((folder_ / "truth.jsonl").string(), (folder_ / "truth.jsonl").string());
  EXPECT_EQ(s.frames_compared, 3U);
  EXPECT_GT(s.robots.expected, 15U);
  EXPECT_EQ(s.robots.recall(), 1);
  EXPECT_EQ(s.robots.precision(), 1);
  EXPECT_EQ(s.robot_position_mm.max, 0);
}

TEST_F(SimulateTest, RawFramesAreTheCamerasBytes) {
  options_.raw = true;
  simulate(options_);
  const std::string first = contents(folder_ / "frame_000000.raw");
  EXPECT_EQ(first.size(), 2U * 128 * 96);
  const Json index = Json::parse(contents(folder_ / "frames.json"));
  EXPECT_EQ(index["pixel_format"], "uyvy");
  EXPECT_EQ(index["width"], 128);
  EXPECT_EQ(index["frames"][1]["file"], "frame_000001.raw");
  simulate(options_);
  EXPECT_EQ(contents(folder_ / "frame_000000.raw"), first);
}

}  // namespace
}  // namespace sslv::simulate_test
