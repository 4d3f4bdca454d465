// SPDX-License-Identifier: Apache-2.0
// The daemon with a GigE Vision camera, over the camera's network protocol on loopback.
#include "e2e/gige.h"

#include "support/becomes.h"
#include "support/gvsp_packets.h"

#include <algorithm>
#include <csignal>
#include <stdexcept>

#include <gmock/gmock.h>

namespace sslv::test::gige_test {
namespace {

using ::testing::HasSubstr;

TEST_F(Gige, RobotsAreFoundInBayerPicturesFromTheNetwork) {
  const auto camera = start_camera();
  RunningDaemon daemon(settings_file(), state_);

  FrameCheck seen;
  for (int i = 0; i < 60; ++i) {
    const SSL_DetectionFrame frame = next_frame(0);
    EXPECT_TRUE(frame.has_t_capture_camera());
    seen += scene_->check(frame);
  }
  ASSERT_GT(seen.robots, 180);
  EXPECT_EQ(seen.missed, 0);
  EXPECT_EQ(seen.wrong, 0);
  const int found = seen.robots - seen.missed;
  std::printf("mean error %.2f mm over %d robots\n", seen.error_mm / found, found);
  EXPECT_LT(seen.error_mm / found, 3);
  // A frame is counted after its packet was sent.
  const Json status = daemon.wait_for_status([](const Json& s) { return s["cameras"][0]["frames"] >= 60; });
  EXPECT_EQ(status["cameras"][0]["pixel_format"], "bayer_rg8");
}

TEST_F(Gige, ForgedPacketsShowNothingOfTheServiceAndDoNotEndIt) {
  const auto camera = start_camera();
  RunningDaemon daemon(settings_file(), state_);
  const Json before =
      daemon.wait_for_status([](const Json& s) { return s["cameras"][0]["robots"] > 0; })["cameras"][0];

  // From the camera's own address, from any port: multipart leaders without payload.
  const UdpForger forger;
  const std::uint16_t port = forger.stream_port_of("127.0.0.1");
  std::uint64_t frame = 0x4000;
  for (int round = 0; round < 20; ++round) {
    for (const std::uint32_t side : {2U, 700U, 1000U, 16384U}) {
      const std::string leader = gvsp_multipart_leader({{side, side, std::uint64_t{side} * side}});
      forger.send(port, gvsp_extended_packet(GvspKind::kLeader, ++frame, 0, leader, 1));
      forger.send(port, gvsp_extended_packet(GvspKind::kTrailer, frame, 1));
    }
    forger.send(port, gvsp_extended_packet(GvspKind::kTrailer, ++frame, 0xfffffffe));
  }
  FrameCheck seen;
  for (int i = 0; i < 30; ++i) seen += scene_->check(next_frame(0));
  EXPECT_GT(seen.robots, 90);
  EXPECT_EQ(seen.missed, 0);
  EXPECT_EQ(seen.wrong, 0);
  const Json after = daemon.get("/api/status")["cameras"][0];
  EXPECT_EQ(after["state"], "running");
  EXPECT_EQ(after["reconnects"], before["reconnects"]);
  EXPECT_EQ(after["width"], kWidth);
}

TEST_F(Gige, ACameraThatDiesComesBackAndTheOtherLosesNoFrame) {
  settings_["cameras"][0]["source"]["silence_s"] = 2;
  auto camera = start_camera();
  RunningDaemon daemon(settings_file(), state_);
  const Json before = daemon.wait_for_status(
      [](const Json& s) { return s["cameras"][0]["frames"] > 10 && s["cameras"][1]["frames"] > 10; });

  FrameNumbers other(listener_.port(), 1);
  camera->send_signal(SIGKILL);
  const Json lost = daemon.wait_for_status(state_is("lost"));
  EXPECT_THAT(title_of_alert(lost, "camera_lost"), HasSubstr("Camera 0 is lost"));
  EXPECT_NE(lost["cameras"][0]["error"], "");
  EXPECT_EQ(lost["cameras"][0]["robots"], 0);
  other.wait_for(30);  // unaffected by the lost camera
  const auto frames_before = lost["cameras"][0]["frames"].get<int>();

  camera.reset();
  camera = start_camera();
  const Json back = daemon.wait_for_status([&](const Json& s) {
    return s["cameras"][0]["state"] == "running" && s["cameras"][0]["frames"].get<int>() > frames_before + 10;
  });
  EXPECT_GE(back["cameras"][0]["reconnects"], 1);
  EXPECT_EQ(back["cameras"][0]["robots"], before["cameras"][0]["robots"]);

  expect_nothing_missing(other);
  EXPECT_EQ(back["cameras"][1]["state"], "running");
  EXPECT_EQ(back["cameras"][1]["reconnects"], 0);
}

TEST_F(Gige, ControlsAreSetLiveSavedAndSetAgainAfterALoss) {
  auto camera = start_camera();
  RunningDaemon daemon(settings_file(), state_);
  const auto is_running = [](const Json& s) { return s["cameras"][0]["state"] == "running"; };
  const Json before = daemon.wait_for_status([](const Json& s) { return s["cameras"][0]["frames"] > 0; });

  // Saved and applied at once without reopening the camera.
  const Json patch = {
      {{"op", "add"}, {"path", "/cameras/0/source/controls/ExposureTimeAbs"}, {"value", 4000.0}}};
  daemon.patch(patch);
  EXPECT_EQ(exposure_us(daemon), 4000);
  const Json after = daemon.get("/api/status");
  EXPECT_EQ(after["cameras"][0]["reconnects"], before["cameras"][0]["reconnects"]);

  // A dry run sends no request to the camera.
  daemon.post("/api/settings/check",
              {{{"op", "replace"},
                {"path", "/cameras/0/source/controls"},
                {"value", {{"ExposureTimeAbs", 7000.0}, {"TriggerMode", "On"}, {"TriggerSoftware", true}}}}});
  EXPECT_EQ(exposure_us(daemon), 4000);
  EXPECT_EQ(control(daemon, "TriggerMode")["value"], "Off");

  // Refused with the allowed values: nothing of the patch is saved or set.
  const Json refused = daemon.patch(
      {{{"op", "replace"}, {"path", "/cameras/0/source/controls/ExposureTimeAbs"}, {"value", 5000.0}},
       {{"op", "add"}, {"path", "/cameras/0/source/controls/PixelFormat"}, {"value", "Sepia"}}},
      422);
  EXPECT_THAT(refused["error"].get<std::string>(),
              HasSubstr("/cameras/0/source/controls/PixelFormat: \"Sepia\" is not allowed; expected one of"));
  EXPECT_EQ(exposure_us(daemon), 4000);
  EXPECT_EQ(daemon.get("/api/settings")["settings"]["cameras"][0]["source"]["controls"],
            Json({{"ExposureTimeAbs", 4000.0}}));

  // Set but not saved, which is reported to all clients.
  const Json set = daemon.post("/api/cameras/0/controls/ExposureTimeAbs", {{"value", 6000.0}});
  EXPECT_EQ(set["value"], 6000);
  EXPECT_EQ(set["unsaved"], true);
  EXPECT_EQ(set["saved_value"], 4000);
  EXPECT_EQ(set["revert_to"], 4000);
  daemon.post("/api/cameras/0/controls/ExposureTimeAbs", {{"value", -6000.0}}, 422);
  EXPECT_EQ(exposure_us(daemon), 6000);
  EXPECT_EQ(control(daemon, "ExposureTimeAbs")["unsaved"], true);
  const Json told = daemon.get("/api/status");
  EXPECT_EQ(told["cameras"][0]["controls_unsaved"], 1);
  EXPECT_THAT(told["alerts"].dump(), HasSubstr("Camera 0: 1 control is set and not saved"));

  // A camera that lost power comes back with the saved values.
  camera->send_signal(SIGKILL);
  daemon.wait_for_status([](const Json& s) { return s["cameras"][0]["state"] == "lost"; });
  daemon.get("/api/cameras/0/controls", 409);
  camera.reset();
  camera = start_camera();
  daemon.wait_for_status(is_running);
  EXPECT_EQ(exposure_us(daemon), 4000);
  EXPECT_EQ(control(daemon, "ExposureTimeAbs")["unsaved"], false);
  EXPECT_EQ(daemon.get("/api/status")["cameras"][0]["controls_unsaved"], 0);
}

TEST_F(Gige, UnsavedControlsAndUndoGoBackToWhatTheCameraHad) {
  const auto camera = start_camera();
  RunningDaemon daemon(settings_file(), state_);
  daemon.wait_for_status([](const Json& s) { return s["cameras"][0]["frames"] > 0; });
  const double exposure_before_us = exposure_us(daemon);
  const Json mode_before = control(daemon, "ExposureAuto")["value"];
  const Json other_mode = mode_before == "Off" ? "Continuous" : "Off";
  const double wanted_us = exposure_before_us + 1000;
  const auto set = [&] {
    daemon.post("/api/cameras/0/controls/ExposureTimeAbs", {{"value", wanted_us}});
    daemon.post("/api/cameras/0/controls/ExposureAuto", {{"value", other_mode}});
  };

  // Never saved, so only the camera knew the earlier value.
  set();
  EXPECT_EQ(control(daemon, "ExposureAuto")["unsaved"], true);
  EXPECT_EQ(control(daemon, "ExposureAuto")["saved_value"], nullptr);
  daemon.post("/api/cameras/0/revert_controls", {{"names", {"ExposureAuto"}}});
  EXPECT_EQ(control(daemon, "ExposureAuto")["value"], mode_before);
  EXPECT_EQ(exposure_us(daemon), wanted_us);
  daemon.post("/api/cameras/0/controls/ExposureAuto", {{"value", other_mode}});
  daemon.post("/api/cameras/0/revert_controls");
  EXPECT_EQ(control(daemon, "ExposureAuto")["value"], mode_before);
  EXPECT_EQ(exposure_us(daemon), exposure_before_us);
  EXPECT_EQ(daemon.get("/api/status")["cameras"][0]["controls_unsaved"], 0);
  // Events are collected once a second.
  daemon.wait_for("/api/events", [](const Json& events) {
    return events.dump().find("Camera 0: 2 unsaved controls were reverted") != std::string::npos;
  });
  daemon.post("/api/cameras/0/revert_controls", {{"names", "ExposureAuto"}}, 400);

  // Saved, then undone.
  set();
  daemon.patch({{{"op", "add"},
                 {"path", "/cameras/0/source/controls"},
                 {"value", {{"ExposureTimeAbs", wanted_us}, {"ExposureAuto", other_mode}}}}});
  EXPECT_EQ(control(daemon, "ExposureAuto")["unsaved"], false);
  EXPECT_EQ(control(daemon, "ExposureAuto")["value"], other_mode);
  daemon.patch({{{"op", "replace"}, {"path", "/cameras/0/source/controls"}, {"value", Json::object()}}});
  EXPECT_EQ(control(daemon, "ExposureAuto")["value"], mode_before);
  EXPECT_EQ(exposure_us(daemon), exposure_before_us);
}

TEST_F(Gige, AControlThatTheCameraRefusesAtTheOpeningIsAnAlert) {
  settings_["cameras"][0]["source"]["controls"] = {{"Colour", 1}, {"ExposureTimeAbs", 3000.0}};
  const auto camera = start_camera();
  RunningDaemon daemon(settings_file(), state_);
  const Json status = daemon.wait_for_status([](const Json& s) { return s["cameras"][0]["robots"] > 0; });
  EXPECT_EQ(title_of_alert(status, "control_refused"),
            "Camera 0 refused a control: Colour: the camera has no such control");
  // The camera may answer later than one discovery waits.
  daemon.wait_for("/api/sources", [](const Json& answer) {
    return std::ranges::any_of(answer["sources"], [](const Json& source) {
      return source["backend"] == "aravis" && source["serial"] == "TEST01";
    });
  });
}

TEST_F(Gige, ACameraInUseIsNotOpenedForAnImageByAnyOfItsNames) {
  const auto camera = start_camera();
  RunningDaemon daemon(settings_file(), state_);
  daemon.wait_for_status([](const Json& s) { return s["cameras"][0]["frames"] > 0; });
  for (const char* name : {"TEST01", "127.0.0.1", ""}) {
    const Json refused =
        daemon.post("/api/sources/image", {{"source", {{"backend", "aravis"}, {"camera", name}}}}, 409);
    EXPECT_EQ(refused["error"], "camera 0 of this service is using it") << name;
  }
  const Json mine = daemon.get("/api/settings")["settings"]["cameras"][0];
  daemon.patch({{{"op", "remove"}, {"path", "/cameras/0"}}});
  // The camera is free now; requesting an image from it must not change its controls.
  const Json source{{"backend", "aravis"},
                    {"camera", "127.0.0.1"},
                    {"silence_s", kPatience.count()},
                    {"controls", {{"GainRaw", 7}}}};
  // On a busy machine the image may arrive later than the request waits.
  EXPECT_TRUE(becomes([&] {
    try {
      daemon.post("/api/sources/image", {{"source", source}});
      return true;
    } catch (const std::runtime_error&) {
      return false;
    }
  }));
  daemon.patch({{{"op", "add"}, {"path", "/cameras/0"}, {"value", mine}}});
  daemon.wait_for_status(
      [](const Json& s) { return s["cameras"].size() == 2 && s["cameras"][0]["state"] == "running"; });
  EXPECT_NE(control(daemon, "GainRaw")["value"], 7);
}

TEST_F(Gige, UnsavedControlsOutliveAReopening) {
  const auto camera = start_camera();
  RunningDaemon daemon(settings_file(), state_);
  daemon.wait_for_status([](const Json& s) { return s["cameras"][0]["frames"] > 0; });
  const double before_us = exposure_us(daemon);
  daemon.post("/api/cameras/0/controls/ExposureTimeAbs", {{"value", before_us + 1000}});
  daemon.patch({{{"op", "replace"}, {"path", "/cameras/0/source/buffers"}, {"value", 9}}});
  daemon.wait_for_status([](const Json& s) {
    return s["cameras"][0]["state"] == "running" && s["cameras"][0]["controls_unsaved"] == 1;
  });
  daemon.post("/api/cameras/0/revert_controls");
  EXPECT_EQ(exposure_us(daemon), before_us);
}

TEST_F(Gige, ACameraThatIsSwitchedOnLaterIsFound) {
  RunningDaemon daemon(settings_file(), state_);
  daemon.wait_for_status([](const Json& s) { return s["cameras"][0]["state"] == "lost"; });
  const auto camera = start_camera();
  daemon.wait_for_status([](const Json& s) { return s["cameras"][0]["robots"] > 0; });
}

}  // namespace
}  // namespace sslv::test::gige_test
