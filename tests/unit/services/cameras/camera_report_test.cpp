// SPDX-License-Identifier: Apache-2.0
#include "services/cameras/camera_report.h"

#include <gmock/gmock.h>

namespace sslv::camera_report_test {
namespace {

constexpr std::int64_t kSecond_ns = 1'000'000'000, kNow_ns = 100 * kSecond_ns;

CameraProgress camera(int id, CameraState state, std::int64_t still_s = 0, const std::string& error = {}) {
  return {id, {.state = state, .error = error, .progress_ns = kNow_ns - still_s * kSecond_ns}};
}

TEST(Hanging, IsARunningCameraWithoutProgress) {
  EXPECT_EQ(find_hanging({}, kNow_ns), "");
  EXPECT_EQ(find_hanging({camera(0, CameraState::kRunning, 4)}, kNow_ns), "");
  EXPECT_EQ(find_hanging({camera(0, CameraState::kRunning), camera(3, CameraState::kRunning, 7)}, kNow_ns),
            "camera 3 has hung for 7 s");
  EXPECT_EQ(find_hanging({camera(0, CameraState::kRunning, 5), camera(3, CameraState::kRunning, 7)}, kNow_ns),
            "camera 0 has hung for 5 s, camera 3 has hung for 7 s");
}

TEST(Hanging, NamesTheStageThatTheThreadIsIn) {
  CameraProgress hung = camera(2, CameraState::kRunning, 9);
  hung.stage = Hang{kNow_ns - 8 * kSecond_ns, "find_tags", "april_tags.so"};
  EXPECT_EQ(find_hanging({hung}, kNow_ns),
            "camera 2 has hung for 9 s in the stage 'find_tags' (april_tags.so)");
  hung.health.progress_ns = kNow_ns;
  EXPECT_EQ(find_hanging({hung}, kNow_ns), "") << "it goes on";
}

TEST(Hanging, ExcludesCamerasThatAreNotRunning) {
  for (const CameraState state : {CameraState::kOpening, CameraState::kLost, CameraState::kEnded})
    EXPECT_EQ(find_hanging({camera(0, state, 60)}, kNow_ns), "") << name_of(state);
}

TEST(Hanging, IsACameraWhosePreviousThreadDoesNotEnd) {
  CameraProgress reopened = camera(2, CameraState::kOpening);
  reopened.stage = Hang{kNow_ns - 8 * kSecond_ns, "find_tags", ""};
  EXPECT_EQ(find_hanging({reopened}, kNow_ns), "camera 2 has hung for 8 s in the stage 'find_tags'");
  reopened.stage->since_ns = kNow_ns - 4 * kSecond_ns;
  EXPECT_EQ(find_hanging({reopened}, kNow_ns), "");
}

TEST(Origin, OnlyARealCameraSeesTheField) {
  EXPECT_EQ(origin_of({{"backend", "aravis"}}), ImageOrigin::kCamera);
  EXPECT_EQ(origin_of({{"backend", "files"}}), ImageOrigin::kRecording);
  EXPECT_EQ(origin_of({{"backend", "simulator"}}), ImageOrigin::kSimulation);
  EXPECT_EQ(origin_of({{"backend", "tile"}, {"of", {{"backend", "simulator"}}}}), ImageOrigin::kSimulation);
  EXPECT_EQ(origin_of({{"backend", "tile"}, {"of", {{"backend", "v4l2"}}}}), ImageOrigin::kCamera);

  std::vector<CameraFacts> cameras(2);
  cameras[0].origin = ImageOrigin::kSimulation;
  for (CameraFacts& camera : cameras) camera.health.state = CameraState::kRunning;
  HealthReport report;
  report_cameras(cameras, report);
  EXPECT_EQ(report.checks.at(0).text, "all are running, 1 simulated");
}

TEST(Missing, HasALineForEachCamera) {
  EXPECT_EQ(find_missing({}), "");
  EXPECT_EQ(find_missing({camera(0, CameraState::kRunning)}), "");
  EXPECT_EQ(find_missing({camera(0, CameraState::kLost, 0, "unplugged"), camera(1, CameraState::kRunning),
                          camera(2, CameraState::kOpening), camera(3, CameraState::kEnded)}),
            "camera 0 is lost: unplugged\n"
            "camera 2 is opening\n"
            "camera 3 is ended\n");
}

TEST(CameraReport, MixingRealAndOtherCamerasIsNoGo) {
  const auto alerts_with = [](ImageOrigin first, ImageOrigin second) {
    std::vector<CameraFacts> cameras(2);
    cameras[0].origin = first;
    cameras[1].id = 1;
    cameras[1].origin = second;
    HealthReport report;
    report_cameras(cameras, report);
    std::vector<std::string> titles;
    for (const Alert& alert : report.alerts)
      if (alert.id == "camera_not_real") titles.push_back(alert.title);
    return titles;
  };
  using enum ImageOrigin;
  EXPECT_THAT(alerts_with(kCamera, kSimulation),
              testing::ElementsAre("Camera 1 is simulated beside real cameras"));
  EXPECT_THAT(alerts_with(kRecording, kCamera),
              testing::ElementsAre("Camera 0 is a recording beside real cameras"));
  for (const ImageOrigin all : {kCamera, kRecording, kSimulation})
    EXPECT_THAT(alerts_with(all, all), testing::IsEmpty());
}

}  // namespace
}  // namespace sslv::camera_report_test
