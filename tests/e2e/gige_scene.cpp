// SPDX-License-Identifier: Apache-2.0
#include "e2e/gige_scene.h"

#include "base/params_json.h"
#include "capture/simulator/simulator.h"
#include "capture/simulator/simulator_world.h"
#include "support/paths.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace sslv::test {
namespace {

Json still_camera(const Json& camera) {
  Json out{{"source", camera.at("source")}, {"calibration", camera.at("calibration")}};
  out["source"]["speed"] = 0;
  return out;
}

SimulatedScene scene_of(Json source) {
  source.erase("backend");
  return SimulatedWorld(simulator_options(source, ""), FieldSize{}, {140, 140}).at(0);
}

}  // namespace

FrameCheck& FrameCheck::operator+=(const FrameCheck& other) {
  robots += other.robots;
  missed += other.missed;
  wrong += other.wrong;
  error_mm += other.error_mm;
  return *this;
}

GigeScene::GigeScene(const Json& camera)
    : served(still_camera(camera)),
      truth_(scene_of(served["source"])),
      model_(params_from_json<CameraCalibration>(served["calibration"], "")) {}

FrameCheck GigeScene::check(const SSL_DetectionFrame& frame) const {
  constexpr double kRobotPx = 26;
  const CameraCalibration& picture = model_.calibration();
  FrameCheck out;
  int known = 0;
  for (const SimulatedRobot& robot : truth_.robots) {
    const auto& seen = robot.team == Team::kBlue ? frame.robots_blue() : frame.robots_yellow();
    const auto found = std::find_if(seen.begin(), seen.end(), [&](const SSL_DetectionRobot& one) {
      return one.robot_id() == static_cast<std::uint32_t>(robot.id);
    });
    if (found != seen.end()) ++known;
    const auto pixel = model_.project({robot.x_mm, robot.y_mm, robot.height_mm});
    if (!pixel || pixel->x() < kRobotPx || pixel->x() > picture.pixel_image_width - kRobotPx ||
        pixel->y() < kRobotPx || pixel->y() > picture.pixel_image_height - kRobotPx) {
      continue;
    }
    ++out.robots;
    if (found == seen.end()) {
      ++out.missed;
    } else {
      out.error_mm += std::hypot(found->x() - robot.x_mm, found->y() - robot.y_mm);
    }
  }
  out.wrong = frame.robots_blue_size() + frame.robots_yellow_size() - known;
  return out;
}

std::unique_ptr<ChildProcess> start_gige_camera(const std::string& served_file, const std::string& address) {
  auto camera = std::make_unique<ChildProcess>(
      std::vector<std::string>{fake_camera_program(), address, "TEST01", served_file});
  camera->wait_for_line("ready");
  return camera;
}

}  // namespace sslv::test
