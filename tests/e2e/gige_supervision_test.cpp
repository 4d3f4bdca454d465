// SPDX-License-Identifier: Apache-2.0
// GigE cameras that fail in typical ways.
#include "e2e/gige.h"

#include <csignal>

#include <gmock/gmock.h>

namespace sslv::test::gige_supervision_test {
namespace {

using ::testing::AnyOf;
using ::testing::HasSubstr;

TEST_F(Gige, AMonoCameraRunsAndFindsNothing) {
  scene_->served["source"]["pixel_format"] = "mono8";
  const auto camera = start_camera();
  RunningDaemon daemon(settings_file(), state_);
  const Json status = daemon.wait_for_status([](const Json& s) { return s["cameras"][0]["frames"] > 10; });
  EXPECT_EQ(status["cameras"][0]["pixel_format"], "mono8");
  EXPECT_EQ(status["cameras"][0]["robots"], 0) << "patterns are told apart by colour";
}

/// Aravis' simulated camera ignores resend requests, so lost packets stay lost.
TEST_F(Gige, APictureWithPacketsMissingIsCountedAndNeverTakenForWhole) {
  scene_->served["lost_packets"] = 0.01;
  settings_["cameras"][0]["source"]["packet_size"] = 16000;
  const auto camera = start_camera();
  RunningDaemon daemon(settings_file(), state_);
  FrameCheck seen;
  for (int i = 0; i < 30; ++i) seen += scene_->check(next_frame(0));
  ASSERT_GT(seen.robots, 90);
  EXPECT_EQ(seen.missed, 0);
  EXPECT_EQ(seen.wrong, 0);
  const Json status = daemon.wait_for_status([](const Json& s) {
    const Json& one = s["cameras"][0];
    return one["frames_incomplete"] > 5 && one["packets"]["missing"] > 5;
  })["cameras"][0];
  std::printf("frames %d, damaged %d, packets missing %d, resent %d, reconnects %d\n",
              status["frames"].get<int>(), status["frames_incomplete"].get<int>(),
              status["packets"]["missing"].get<int>(), status["packets"]["resent"].get<int>(),
              status["reconnects"].get<int>());
}

/// Closing a stopped camera waits for its answers, which must not block the other camera.
TEST_F(Gige, ASilentCameraComesBackWithItsControlsAndTheOtherLosesNoFrame) {
  scene_->served["heartbeat_s"] = 3;
  settings_["cameras"][0]["source"].update(
      Json{{"silence_s", 5}, {"controls", {{"ExposureTimeAbs", 4000.0}}}});
  const auto camera = start_camera();
  RunningDaemon daemon(settings_file(), state_);
  daemon.wait_for_status([](const Json& s) { return s["cameras"][0]["robots"] > 0; });
  FrameNumbers other(listener_.port(), 1);

  camera->send_signal(SIGSTOP);
  const Json lost = daemon.wait_for_status(state_is("lost"));
  EXPECT_THAT(lost["cameras"][0]["error"].get<std::string>(),
              AnyOf(HasSubstr("no image for 5 s"), HasSubstr("no longer answers")));
  EXPECT_THAT(title_of_alert(lost, "camera_lost"), HasSubstr("Camera 0 is lost"));
  other.wait_for(30);

  camera->send_signal(SIGCONT);
  daemon.wait_for_status([](const Json& s) { return s["cameras"][0]["robots"] > 0; });
  EXPECT_EQ(exposure_us(daemon), 4000);
  expect_nothing_missing(other);
}

TEST_F(Gige, ACameraThatComesBackWithAnotherSizeRunsAndItsCalibrationIsDoubted) {
  settings_["cameras"][0]["source"]["silence_s"] = 2;
  auto camera = start_camera();
  RunningDaemon daemon(settings_file(), state_);
  daemon.wait_for_status([](const Json& s) { return s["cameras"][0]["robots"] > 0; });
  camera.reset();
  const Json served = scene_->served;
  scene_->served["source"].update(Json{{"width", 640}, {"height", 480}});
  scene_->served["calibration"].update(Json{{"pixel_image_width", 640}, {"pixel_image_height", 480}});
  camera = start_camera();
  const Json status = daemon.wait_for_status([](const Json& s) {
    return s["cameras"][0]["width"] == 640 && s["cameras"][0]["state"] == "running" &&
           has_alert(s, "calibration_other_size");
  });
  EXPECT_EQ(status["cameras"][0]["height"], 480);
  EXPECT_EQ(title_of_alert(status, "calibration_other_size"),
            "Camera 0 sends 640x480 pixels, its calibration was made for 1280x952");

  // And back to the original size.
  camera.reset();
  scene_->served = served;
  camera = start_camera();
  // Alerts about frames of the wrong size remain for a while.
  daemon.wait_for_status([](const Json& s) {
    return s["cameras"][0]["width"] == kWidth && s["cameras"][0]["robots"] > 0 && s["alerts"].empty();
  });
}

}  // namespace
}  // namespace sslv::test::gige_supervision_test
