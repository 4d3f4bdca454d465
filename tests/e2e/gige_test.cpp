// SPDX-License-Identifier: Apache-2.0
// The daemon with a GigE Vision camera, over the camera's network protocol on loopback.
#include "base/params_json.h"
#include "capture/simulator.h"
#include "capture/simulator_world.h"
#include "e2e/running_daemon.h"
#include "geometry/camera_model.h"

#include <cmath>
#include <csignal>
#include <map>
#include <optional>

#include <gmock/gmock.h>

namespace sslv::test {
namespace {

using ::testing::HasSubstr;

/// Camera 0 of the demo as a GigE camera with a larger Bayer sensor; what it sees stands still, so that the
/// truth does not depend on when a picture was drawn.
class Gige : public DaemonTest {
 protected:
  Gige() {
    Json& camera = settings_["cameras"][0];
    camera["calibration"].update(Json{{"focal_length", 758.15},
                                      {"principal_point_x", 642.0},
                                      {"principal_point_y", 472.8},
                                      {"pixel_image_width", 1280},
                                      {"pixel_image_height", 952}});
    served_ = {{"source", camera["source"]}, {"calibration", camera["calibration"]}};
    served_["source"].update(Json{{"width", 1280},
                                  {"height", 952},
                                  {"pixel_format", "bayer_rg8"},
                                  {"frame_rate_hz", 30},
                                  {"speed", 0}});
    camera["source"] = {{"backend", "aravis"}, {"camera", "127.0.0.1"}};
    served_file_ = folder_.write("served.json", served_.dump(2));
  }

  std::unique_ptr<ChildProcess> start_camera() const {
    auto camera = std::make_unique<ChildProcess>(
        std::vector<std::string>{SSLV_FAKE_CAMERA, "127.0.0.1", "TEST01", served_file_});
    camera->wait_for_line("ready");
    return camera;
  }

  Json served_;
  std::string served_file_;
};

TEST_F(Gige, RobotsAreFoundInBayerPicturesFromTheNetwork) {
  const auto camera = start_camera();
  RunningDaemon daemon(settings_file(), state_);

  Json options = served_["source"];
  options.erase("backend");
  const SimulatedWorld world(simulator_options(options, ""), FieldSize{}, {140, 140});
  const CameraModel model(params_from_json<CameraCalibration>(served_["calibration"], ""));
  const auto is_seen = [&](const SimulatedRobot& robot) {
    const auto pixel = model.project({robot.x_mm, robot.y_mm, robot.height_mm});
    return pixel && pixel->x() > 26 && pixel->x() < 1280 - 26 && pixel->y() > 26 && pixel->y() < 952 - 26;
  };

  int frames = 0, robots = 0, missed = 0;
  double error_mm = 0;
  while (frames < 60) {
    const SSL_WrapperPacket packet = receive(listener_);
    if (!packet.has_detection() || packet.detection().camera_id() != 0) continue;
    const SSL_DetectionFrame& frame = packet.detection();
    ++frames;
    EXPECT_TRUE(frame.has_t_capture_camera());
    std::size_t known = 0;
    for (const SimulatedRobot& robot : world.at(0).robots) {
      const auto& seen = robot.team == Team::kBlue ? frame.robots_blue() : frame.robots_yellow();
      const auto found = std::find_if(seen.begin(), seen.end(), [&](const SSL_DetectionRobot& one) {
        return one.robot_id() == static_cast<std::uint32_t>(robot.id);
      });
      if (found != seen.end()) ++known;
      if (!is_seen(robot)) continue;
      ++robots;
      if (found == seen.end()) {
        ++missed;
        continue;
      }
      error_mm += std::hypot(found->x() - robot.x_mm, found->y() - robot.y_mm);
    }
    EXPECT_EQ(known, static_cast<std::size_t>(frame.robots_blue_size() + frame.robots_yellow_size()))
        << "wrong ids";
  }
  ASSERT_GT(robots, 180);
  EXPECT_EQ(missed, 0);
  std::printf("mean error %.2f mm over %d robots\n", error_mm / (robots - missed), robots - missed);
  EXPECT_LT(error_mm / (robots - missed), 3);
  // A frame is counted after its packet has left.
  const Json status = daemon.wait_for_status([](const Json& s) { return s["cameras"][0]["frames"] >= 60; });
  EXPECT_EQ(status["cameras"][0]["pixel_format"], "bayer_rg8");
}

TEST_F(Gige, ACameraThatDiesComesBackAndTheOtherLosesNoFrame) {
  auto camera = start_camera();
  RunningDaemon daemon(settings_file(), state_);
  const auto state_is = [](const char* state) {
    return [state](const Json& s) { return s["cameras"][0]["state"] == state; };
  };
  const Json before = daemon.wait_for_status(
      [](const Json& s) { return s["cameras"][0]["frames"] > 10 && s["cameras"][1]["frames"] > 10; });

  camera->send_signal(SIGKILL);
  const Json lost = daemon.wait_for_status(state_is("lost"));
  EXPECT_THAT(lost["alerts"][0]["title"].get<std::string>(), HasSubstr("Camera 0 is lost"));
  EXPECT_NE(lost["cameras"][0]["error"], "");
  EXPECT_EQ(lost["cameras"][0]["robots"], 0);
  const auto frames_before = lost["cameras"][0]["frames"].get<int>();

  camera.reset();
  camera = start_camera();
  const Json back = daemon.wait_for_status([&](const Json& s) {
    return s["cameras"][0]["state"] == "running" && s["cameras"][0]["frames"].get<int>() > frames_before + 10;
  });
  EXPECT_GE(back["cameras"][0]["reconnects"], 1);
  EXPECT_EQ(back["cameras"][0]["robots"], before["cameras"][0]["robots"]);

  // The simulated camera's frames carry consecutive numbers at an even pace: nothing was left out meanwhile.
  std::optional<SSL_DetectionFrame> last;
  for (int i = 0; i < 30;) {
    const SSL_WrapperPacket packet = receive(listener_);
    if (!packet.has_detection() || packet.detection().camera_id() != 1) continue;
    if (last) {
      EXPECT_EQ(packet.detection().frame_number(), last->frame_number() + 1);
    }
    last = packet.detection();
    ++i;
  }
  EXPECT_EQ(back["cameras"][1]["state"], "running");
  EXPECT_EQ(back["cameras"][1]["reconnects"], 0);
}

TEST_F(Gige, ControlsAreSetLiveSavedAndSetAgainAfterALoss) {
  auto camera = start_camera();
  RunningDaemon daemon(settings_file(), state_);
  const auto is_running = [](const Json& s) { return s["cameras"][0]["state"] == "running"; };
  const auto exposure_us = [&] {
    const Json answer = daemon.get("/api/cameras/0/controls");
    for (const Json& control : answer["controls"]) {
      if (control["name"] == "ExposureTimeAbs") return control["value"].get<double>();
    }
    return 0.0;
  };
  const Json before = daemon.wait_for_status([](const Json& s) { return s["cameras"][0]["frames"] > 0; });

  // Saved, and in force at once without opening the camera anew.
  const Json patch = {
      {{"op", "add"}, {"path", "/cameras/0/source/controls/ExposureTimeAbs"}, {"value", 4000.0}}};
  daemon.patch(patch);
  EXPECT_EQ(exposure_us(), 4000);
  const Json after = daemon.get("/api/status");
  EXPECT_EQ(after["cameras"][0]["reconnects"], before["cameras"][0]["reconnects"]);

  // Refused with what is allowed: neither saved nor set, and what went with it is set back.
  const Json refused = daemon.patch(
      {{{"op", "replace"}, {"path", "/cameras/0/source/controls/ExposureTimeAbs"}, {"value", 5000.0}},
       {{"op", "add"}, {"path", "/cameras/0/source/controls/PixelFormat"}, {"value", "Sepia"}}},
      422);
  EXPECT_THAT(refused["error"].get<std::string>(),
              HasSubstr("/cameras/0/source/controls/PixelFormat: \"Sepia\" is not allowed; expected one of"));
  EXPECT_EQ(exposure_us(), 4000);
  EXPECT_EQ(daemon.get("/api/settings")["settings"]["cameras"][0]["source"]["controls"],
            Json({{"ExposureTimeAbs", 4000.0}}));

  // For a moment only.
  EXPECT_EQ(daemon.post("/api/cameras/0/controls/ExposureTimeAbs", {{"value", 6000.0}})["value"], 6000);
  daemon.post("/api/cameras/0/controls/ExposureTimeAbs", {{"value", -6000.0}}, 422);
  EXPECT_EQ(exposure_us(), 6000);

  // A camera that lost its power comes back as it was saved.
  camera->send_signal(SIGKILL);
  daemon.wait_for_status([](const Json& s) { return s["cameras"][0]["state"] == "lost"; });
  daemon.get("/api/cameras/0/controls", 409);
  camera.reset();
  camera = start_camera();
  daemon.wait_for_status(is_running);
  EXPECT_EQ(exposure_us(), 4000);
}

TEST_F(Gige, AControlThatTheCameraRefusesAtTheOpeningIsAnAlert) {
  settings_["cameras"][0]["source"]["controls"] = {{"Colour", 1}, {"ExposureTimeAbs", 3000.0}};
  const auto camera = start_camera();
  RunningDaemon daemon(settings_file(), state_);
  const Json status = daemon.wait_for_status([](const Json& s) { return s["cameras"][0]["robots"] > 0; });
  EXPECT_EQ(status["alerts"][0]["title"],
            "Camera 0 refused a control: Colour: the camera has no such control");
  bool is_found = false;
  const Json answer = daemon.get("/api/sources");
  for (const Json& source : answer["sources"])
    is_found = is_found || (source["backend"] == "aravis" && source["serial"] == "TEST01");
  EXPECT_TRUE(is_found);
}

TEST_F(Gige, ACameraThatIsSwitchedOnLaterIsFound) {
  RunningDaemon daemon(settings_file(), state_);
  daemon.wait_for_status([](const Json& s) { return s["cameras"][0]["state"] == "lost"; });
  const auto camera = start_camera();
  daemon.wait_for_status([](const Json& s) { return s["cameras"][0]["robots"] > 0; });
}

}  // namespace
}  // namespace sslv::test
