// SPDX-License-Identifier: Apache-2.0
#include "capture/simulator/simulator_camera.h"

#include "base/error.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>

#include <Eigen/Geometry>
#include <fmt/format.h>

namespace sslv {
namespace {

constexpr int kBandRows = 64;             // the whole image is developed in bands, to limit memory
constexpr double kMainsLightHz = 100.03;  // twice the mains frequency, which is never exactly 50 Hz
constexpr double kUsualReadOutMs = 10;

SimulatorOptions with_resolved_hall(SimulatorOptions options) {
  options.hall = resolved(options.hall);
  return options;
}

Scene checked(const SimulatorOptions& options, const SourceContext& context) {
  if (!context.scene.camera) {
    throw CaptureError(
        fmt::format("camera {}: the simulator draws what a calibrated camera sees and needs its "
                    "\"calibration\" (focal_length, principal_point_x, ..., tz), which is missing",
                    context.camera_id));
  }
  const CameraCalibration& made_for = context.scene.camera->calibration();
  if (made_for.pixel_image_width > 0 && made_for.pixel_image_height > 0 &&
      (made_for.pixel_image_width != options.width || made_for.pixel_image_height != options.height)) {
    throw CaptureError(
        fmt::format("camera {}: its calibration is for images of {} x {} (pixel_image_width, "
                    "pixel_image_height), but the simulator's width and height say {} x {}",
                    context.camera_id, made_for.pixel_image_width, made_for.pixel_image_height, options.width,
                    options.height));
  }
  Scene scene = context.scene;
  scene.camera = with_errors(*scene.camera, options.errors);
  return scene;
}

SimulatedWorld world_of(const SimulatorOptions& options, const SourceContext& context) {
  try {
    return {options, context.scene.field, context.scene.robot_height_mm, &*context.scene.camera};
  } catch (const SettingsError& error) {
    throw CaptureError(fmt::format("camera {}: {}", context.camera_id, error.what()));
  }
}

/// The swing's factor at a Unix time, the same for all cameras.
double swing_at(const std::vector<std::array<double, 2>>& swing, double t_s) {
  if (swing.empty()) return 1;
  const double at = t_s - std::floor(t_s / swing.back()[0]) * swing.back()[0];
  const auto next = std::find_if(swing.begin() + 1, swing.end() - 1,
                                 [&](const std::array<double, 2>& point) { return point[0] > at; });
  const auto& [from_s, from] = *(next - 1);
  return from + ((*next)[1] - from) * (at - from_s) / ((*next)[0] - from_s);
}

}  // namespace

SimulatedCamera::SimulatedCamera(const SimulatorOptions& options, const SourceContext& context,
                                 const PatternTable& patterns)
    : options_(with_resolved_hall(options)),
      scene_(checked(options, context)),
      lamps_(options_.hall, scene_.field),
      banding_(options_.hall.lamps.banding.value()),
      world_(world_of(options, context)),
      renderer_(options, scene_.field, *scene_.camera, patterns),
      sensor_(options, static_cast<std::uint64_t>(options.seed) << 32 | context.camera_id),
      layout_{nullptr,
              options.width,
              options.height,
              static_cast<std::ptrdiff_t>(options.width) * bytes_per_pixel(options.pixel_format),
              options.pixel_format,
              static_cast<std::ptrdiff_t>(sensor_.picture_bytes() - sensor_.plane_bytes())},
      background_{renderer_.background(options.placement == SimulatorPlacement::kPaths ? world_.at(0)
                                                                                       : SimulatedScene()),
                  std::vector<std::uint8_t>(sensor_.picture_bytes()),
                  {},
                  {1, 1, 1}},
      canvas_{background_.light, {}, {}},
      exposure_{std::vector<SimulatedScene>(options.exposure_ms > 0 ? SimulatorRenderer::kMaxMoments : 1),
                {}} {
  for (const SimulatedRobot& robot : world_.at(0).robots) {
    const bool known = std::any_of(patterns.codes.begin(), patterns.codes.end(),
                                   [&](const PatternTable::Code& code) { return code.id == robot.id; });
    if (!known) {
      throw CaptureError(
          fmt::format("camera {}: the simulator is to draw the {} robot {}, but pattern table \"{}\" has "
                      "no such id",
                      context.camera_id, name_of(robot.team), robot.id, patterns.name));
    }
  }
  if (light_changes()) background_.blurred = sensor_.blurred(background_.light);
  develop_background();
}

bool SimulatedCamera::light_changes() const {
  return !options_.light_swing.empty() || !options_.cast_swing.empty() || lamps_.flickers() || banding_ > 0;
}

void SimulatedCamera::develop_background() {
  if (light_changes()) {
    sensor_.develop_blurred(background_.blurred, background_.clean.data());
  } else {
    for (int top = 0; top < options_.height; top += kBandRows) {
      const DrawnBox band{0, top, options_.width, std::min(options_.height, top + kBandRows)};
      sensor_.develop(background_.light, band, background_.clean.data());
    }
  }
  canvas_.clean = background_.clean;
}

/// A change of the light changes the whole background.
void SimulatedCamera::follow_light(double t_s) {
  if (!light_changes()) return;
  double light = swing_at(options_.light_swing, t_s);
  const double cast = swing_at(options_.cast_swing, t_s);
  if (lamps_.flickers()) light *= lamps_.flicker(options_.seed, picture_number(options_, t_s));
  const std::array gains{static_cast<float>(light * cast), static_cast<float>(light),
                         static_cast<float>(light / cast)};
  if (gains == background_.gains && banding_ == 0) return;
  background_.gains = gains;
  sensor_.set_gains(gains);
  for (int y = 0; y < options_.height && banding_ > 0; ++y) {
    // A global shutter would show no bands; if the option asks for them, assume the usual read-out time.
    const double read_out_s =
        1e-3 * (options_.rolling_shutter_ms > 0 ? options_.rolling_shutter_ms : kUsualReadOutMs);
    const double turns = kMainsLightHz * (t_s + read_out_s * y / options_.height);
    sensor_.set_row_gain(y, static_cast<float>(1 + banding_ * std::sin(2 * std::numbers::pi * turns)));
  }
  develop_background();
}

void SimulatedCamera::draw(double t_s, std::uint8_t* picture) noexcept {
  follow_light(t_s);
  world_.expose(t_s, options_.exposure_ms * 1e-3, exposure_.moments);
  const bool rolls = options_.rolling_shutter_ms > 0;
  if (rolls) exposure_.motions = world_.motions_at(t_s, options_.rolling_shutter_ms * 0.5e-3);
  renderer_.draw(exposure_.moments, canvas_.light, canvas_.boxes, rolls ? &exposure_.motions : nullptr);
  for (const DrawnBox& box : canvas_.boxes)
    sensor_.develop(canvas_.light, sensor_.reached_from(box), canvas_.clean.data());
  sensor_.add_noise(canvas_.clean.data(), picture);

  // Restore the background for the next frame.
  const auto stride = static_cast<std::size_t>(layout_.stride_bytes);
  const auto pixel_bytes = static_cast<std::size_t>(bytes_per_pixel(layout_.format));
  for (const DrawnBox& box : canvas_.boxes) {
    for (int y = box.top; y < box.bottom; ++y) {
      std::copy(background_.light.at(box.left, y), background_.light.at(box.right, y),
                canvas_.light.at(box.left, y));
    }
    const DrawnBox reached = sensor_.reached_from(box);
    const std::size_t bytes = static_cast<std::size_t>(reached.right - reached.left) * pixel_bytes;
    for (int y = reached.top; y < reached.bottom; ++y) {
      const std::size_t at =
          static_cast<std::size_t>(y) * stride + static_cast<std::size_t>(reached.left) * pixel_bytes;
      for (std::size_t of = at; of < canvas_.clean.size(); of += sensor_.plane_bytes())
        std::memcpy(canvas_.clean.data() + of, background_.clean.data() + of, bytes);
    }
  }
}

bool SimulatedCamera::fully_visible(const Eigen::Vector3d& center_mm, double radius_mm,
                                    const SimulatedScene& scene) const {
  constexpr int kPoints = 32;
  for (int i = 0; i < kPoints; ++i) {
    const double angle = i * 2 * std::numbers::pi / kPoints;
    const auto pixel =
        scene_.camera->project(center_mm + radius_mm * Eigen::Vector3d(std::cos(angle), std::sin(angle), 0));
    if (!pixel || pixel->x() < 0 || pixel->y() < 0 || pixel->x() > options_.width - 1 ||
        pixel->y() > options_.height - 1) {
      return false;
    }
  }
  const Eigen::Vector3d& eye = scene_.camera->position_mm();
  for (const SimulatedRobot& robot : scene.robots) {
    if (robot.height_mm <= center_mm.z()) continue;
    // Distance between the other robot and the line of sight below the plane of its top.
    const double share = (robot.height_mm - center_mm.z()) / (eye.z() - center_mm.z());
    const Eigen::Vector2d along = share * (eye - center_mm).head<2>();
    const Eigen::Vector2d from = center_mm.head<2>() - Eigen::Vector2d(robot.x_mm, robot.y_mm);
    const double t = std::clamp(-from.dot(along) / std::max(along.squaredNorm(), 1e-12), 0.0, 1.0);
    const double distance = (from + t * along).norm();
    if (distance < scene_.field.max_robot_radius + radius_mm) return false;
  }
  return true;
}

/// Visible fraction of a ball's disc, or of a robot's `top`, estimated at sample points; 1 only if fully
/// visible.
double SimulatedCamera::visible_share(const Eigen::Vector3d& center_mm, double radius_mm,
                                      const SimulatedScene& scene, const SimulatedRobot* top) const {
  if (fully_visible(center_mm, radius_mm, scene)) return 1;
  constexpr double kMax = 0.999;  // limit for a thing that is or may be partly hidden
  const auto is_visible = [&](const Eigen::Vector3d& point) {
    const auto pixel = scene_.camera->project(point);
    return pixel && pixel->x() >= -0.5 && pixel->y() >= -0.5 && pixel->x() <= options_.width - 0.5 &&
           pixel->y() <= options_.height - 0.5 &&
           std::none_of(scene.robots.begin(), scene.robots.end(), [&](const SimulatedRobot& robot) {
             return hides(robot, scene_.field.max_robot_radius, point, scene_.camera->position_mm());
           });
  };
  const Eigen::Rotation2Dd turn(top != nullptr ? top->orientation_rad : 0);
  int points = 0, visible = 0;
  for (const Eigen::Vector2d& p : points_of_disc()) {
    if (top != nullptr && p.x() > kRobotFrontPerRadius) continue;
    const Eigen::Vector2d offset_mm = radius_mm * (turn * p);
    ++points;
    visible += is_visible(center_mm + Eigen::Vector3d(offset_mm.x(), offset_mm.y(), 0));
  }
  return std::min(kMax, static_cast<double>(visible) / points);
}

Json SimulatedCamera::truth(const std::string& frame, double t_s) const {
  const SimulatedScene scene = world_.at(t_s);
  Json out{{"frame", frame}, {"t", t_s}, {"robots", Json::array()}, {"balls", Json::array()}};
  const bool rolls = options_.rolling_shutter_ms > 0;
  const SimulatorMotions motions =
      rolls ? world_.motions_at(t_s, options_.rolling_shutter_ms * 0.5e-3) : SimulatorMotions();
  // The scene when the row that shows the centre of a thing is read out.
  const auto seen_at = [&](const auto& center_in) {
    SimulatedScene seen = scene;
    for (int i = 0; i < 4 && rolls; ++i) {
      const auto pixel = scene_.camera->project(center_in(seen));
      if (!pixel) break;
      const double y = std::clamp(pixel->y(), 0.0, options_.height - 1.0);
      seen = moved(scene, motions, renderer_.row_delay_s(y));
    }
    return seen;
  };
  // A thing whose centre is this far outside cannot appear in the image.
  const auto pixel_of = [&](const Eigen::Vector3d& center_mm) {
    auto pixel = scene_.camera->project(center_mm);
    const double margin = options_.width / 4.0;
    if (pixel && (pixel->x() < -margin || pixel->y() < -margin || pixel->x() > options_.width + margin ||
                  pixel->y() > options_.height + margin)) {
      pixel.reset();
    }
    return pixel;
  };
  for (std::size_t i = 0; i < scene.robots.size(); ++i) {
    const SimulatedRobot& robot = scene.robots[i];
    const auto center_in = [&](const SimulatedScene& there) {
      return Eigen::Vector3d(there.robots[i].x_mm, there.robots[i].y_mm, robot.height_mm);
    };
    const SimulatedScene seen = seen_at(center_in);
    const Eigen::Vector3d center = center_in(seen);
    const auto pixel = pixel_of(center);
    if (!pixel) continue;
    const double share = visible_share(center, scene_.field.max_robot_radius, seen, &seen.robots[i]);
    out["robots"].push_back({{"team", name_of(robot.team)},
                             {"id", robot.id},
                             {"x", robot.x_mm},
                             {"y", robot.y_mm},
                             {"orientation", robot.orientation_rad},
                             {"height", robot.height_mm},
                             {"covered_dot", robot.covered_dot ? Json(*robot.covered_dot) : Json()},
                             {"visible", share == 1},
                             {"visible_share", share},
                             {"pixel_x", pixel->x()},
                             {"pixel_y", pixel->y()}});
  }
  for (std::size_t i = 0; i < scene.balls.size(); ++i) {
    const SimulatedBall& ball = scene.balls[i];
    const auto center_in = [&](const SimulatedScene& there) {
      return Eigen::Vector3d(there.balls[i].x_mm, there.balls[i].y_mm, scene_.field.ball_radius);
    };
    const SimulatedScene seen = seen_at(center_in);
    const Eigen::Vector3d center = center_in(seen);
    const auto pixel = pixel_of(center);
    if (!pixel) continue;
    const double share = visible_share(center, scene_.field.ball_radius, seen, nullptr);
    out["balls"].push_back({{"x", ball.x_mm},
                            {"y", ball.y_mm},
                            {"visible", share == 1},
                            {"visible_share", share},
                            {"pixel_x", pixel->x()},
                            {"pixel_y", pixel->y()}});
  }
  return out;
}

}  // namespace sslv
