// SPDX-License-Identifier: Apache-2.0
#include "services/colors/color_margins.h"

#include "base/background.h"
#include "capture/source.h"
#include "colors/small_picture.h"
#include "services/cameras/stills.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <time.h>

namespace sslv {
namespace {

// Excluded around robots and balls: a robot's hull and shadow change the carpet's colours.
constexpr double kRobotReachMm = 130, kBallReach = 1.6;
/// Pause after work, as a multiple of the work's processor time. Measuring a camera's surfaces thus takes at
/// most 2 % of a processor, and computing its margins at most another 2 %, for frames of any size.
constexpr int kRestPerWork = 50;

/// Processor time used by this thread; excludes waiting.
std::chrono::nanoseconds work_so_far() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return std::chrono::seconds(time.tv_sec) + std::chrono::nanoseconds(time.tv_nsec);
}

/// Scale at a pixel for the plane z = height; 0 where the camera does not see this plane.
double px_per_mm(const CameraModel& camera, const Eigen::Vector2d& pixel, double height_mm) {
  const double area_mm2 = camera.mm2_per_px(pixel, height_mm);
  return area_mm2 > 0 ? 1 / std::sqrt(area_mm2) : 0;
}

double largest_dot_px(const ImageView& image, const Scene& scene, const PatternTable& patterns) {
  // Upper limit, also used without a calibration: no camera of a field shows larger dots.
  constexpr int kDotsAcross = 40;
  const double unknown = static_cast<double>(image.width) / kDotsAcross;
  if (!scene.camera) return unknown;
  const double largest_mm = std::max(patterns.center_diameter_mm, 2 * scene.field.ball_radius);
  double largest_px = 0;
  constexpr int kPlaces = 3;  // in each direction: the scale of a tilted camera varies over the image
  for (int i = 0; i < kPlaces * kPlaces; ++i) {
    const int column = i % kPlaces, row = i / kPlaces;
    const Eigen::Vector2d pixel((column + 0.5) * image.width / kPlaces, (row + 0.5) * image.height / kPlaces);
    for (const double height_mm : scene.robot_height_mm)
      largest_px = std::max(largest_px, largest_mm * px_per_mm(*scene.camera, pixel, height_mm));
  }
  return largest_px > 0 ? std::min(largest_px, unknown) : unknown;
}

std::vector<PixelDisc> robots_and_balls(const LentFrame& frame, const Scene& scene) {
  std::vector<PixelDisc> out;
  if (!scene.camera) return out;  // without a calibration, detections have no position
  const auto add = [&](double x_px, double y_px, double height_mm, double radius_mm) {
    out.push_back({0, x_px, y_px, radius_mm * px_per_mm(*scene.camera, {x_px, y_px}, height_mm)});
  };
  for (const Robot& robot : frame.robots) add(robot.pixel_x, robot.pixel_y, robot.height_mm, kRobotReachMm);
  for (const Ball& ball : frame.balls)
    add(ball.pixel_x, ball.pixel_y, scene.field.ball_radius, kBallReach * scene.field.ball_radius);
  return out;
}

}  // namespace

SurfaceColors surfaces_of(const LentFrame& frame, const Scene& scene, const PatternTable& patterns,
                          const Mask* mask, const std::stop_token& stop) {
  const std::vector<PixelDisc> left_out = robots_and_balls(frame, scene);
  std::vector<SmallPictures> pictures{SmallPictures(frame.image, mask)};
  SurfaceSearch search{{&frame.image, 1},
                       pictures,
                       mask,
                       left_out,
                       largest_dot_px(frame.image, scene, patterns),
                       {},
                       {},
                       stop};
  if (scene.camera) {
    search.on_carpet = [&](std::size_t, const Eigen::Vector2d& pixel) {
      const FieldSize& field = scene.field;
      const auto place_mm = scene.camera->unproject(pixel, 0);
      return place_mm &&
             std::abs(place_mm->x()) < field.field_length / 2.0 + field.boundary_width_goal_line &&
             std::abs(place_mm->y()) < field.field_width / 2.0 + field.boundary_width;
    };
  }
  return find_surfaces(search);
}

ColorMargins::ColorMargins(Hooks hooks, Pace pace)
    : hooks_(std::move(hooks)), pace_(pace), thread_([this](const std::stop_token& ending) {
        become_background_thread("margins");
        serve(ending);
      }) {}

std::shared_ptr<const SurfaceColors> ColorMargins::surfaces(int camera_id) const {
  const std::lock_guard lock(mutex_);
  const auto found = known_.find(camera_id);
  return found == known_.end() ? nullptr : found->second->surfaces;
}

std::optional<std::vector<LabelMargin>> ColorMargins::newest_margins(int camera_id) const {
  const std::lock_guard lock(mutex_);
  const auto found = known_.find(camera_id);
  if (found == known_.end() || !found->second->surfaces) return {};
  return found->second->margins;
}

std::optional<std::vector<LabelMargin>> ColorMargins::margins(int camera_id, const Lut& lut,
                                                              const std::stop_token& stop) {
  std::shared_ptr<Known> known;
  std::shared_ptr<const SurfaceColors> surfaces;
  {
    const std::lock_guard lock(mutex_);
    const auto found = known_.find(camera_id);
    if (found == known_.end() || !found->second->surfaces) return {};
    known = found->second;
    if (known->lut_id == lut.id()) return known->margins;
    surfaces = known->surfaces;
  }
  auto margins = table_margins(lut, *surfaces, stop);
  if (stop.stop_requested()) return {};
  const std::lock_guard lock(mutex_);
  if (known->surfaces == surfaces) {
    known->margins = margins;
    known->lut_id = lut.id();
  }
  return margins;
}

void ColorMargins::forget(const std::set<int>& camera_ids) {
  const std::lock_guard lock(mutex_);
  for (const int id : camera_ids) known_.erase(id);
}

void ColorMargins::serve(const std::stop_token& ending) {
  while (!ending.stop_requested()) {
    std::map<int, Look> still;
    for (const Camera& camera : hooks_.cameras()) {
      if (ending.stop_requested()) return;
      Look& look = still[camera.id] = looks_[camera.id];
      look_at(camera, look, ending);
    }
    looks_ = std::move(still);
    std::unique_lock lock(mutex_);
    rests_.wait_for(lock, ending, pace_.between_rounds, [] { return false; });
  }
}

void ColorMargins::look_at(const Camera& camera, Look& look, const std::stop_token& ending) {
  {
    const std::lock_guard lock(mutex_);
    auto& known = known_[camera.id];
    if (!known) known = std::make_shared<Known>();
    if (look.known != known) look = {.known = known};  // forgotten meanwhile: start over
  }
  const auto begun = Clock::now();
  const auto work_before = work_so_far();
  const auto rest = [&](Clock::duration least) {
    return Clock::now() + std::max<Clock::duration>(least, kRestPerWork * (work_so_far() - work_before));
  };
  if (look.scene != camera.scene || look.mask != camera.mask || begun >= look.next) {
    try {
      if (see_surfaces(camera, look, ending)) look.next = rest(pace_.between_looks);
    } catch (const CaptureError&) {  // the camera no longer exists; the next list lacks it
    }
  } else if (begun >= look.next_count) {  // tables that follow the light may change several times a second
    margins(camera.id, *camera.lut, ending);
    look.next_count = rest({});
  }
}

bool ColorMargins::see_surfaces(const Camera& camera, Look& look, const std::stop_token& ending) {
  auto frame = hooks_.wait_frame(camera.id, look.version, std::chrono::milliseconds(0));
  if (!frame) return false;
  if (!has_colors(frame->image.format)) {
    // Surfaces that were measured before the camera sent grey images are no longer valid.
    const std::lock_guard lock(mutex_);
    look.known->surfaces = nullptr;
    look.known->margins.clear();
    return false;
  }
  const bool is_another_view = look.scene != camera.scene || look.mask != camera.mask;
  look.scene = camera.scene;
  look.mask = camera.mask;
  look.version = frame->version;
  // Work on a copy and release the frame: the camera needs it.
  const StillPicture picture(frame->image, frame->number, frame->t_capture_s);
  const std::vector<Robot> robots(frame->robots.begin(), frame->robots.end());
  const std::vector<Ball> balls(frame->balls.begin(), frame->balls.end());
  frame->hold = nullptr;
  frame->image = picture.view;
  frame->robots = robots;
  frame->balls = balls;
  auto surfaces = std::make_shared<const SurfaceColors>(
      surfaces_of(*frame, *camera.scene, *camera.patterns, camera.mask.get(), ending));
  // A dark or covered camera shows no carpet: keep the earlier surfaces.
  if (surfaces->total(SurfaceKind::kCarpet) == 0) return true;
  auto margins = table_margins(*camera.lut, *surfaces, ending);
  // Keep the earlier surfaces while they give about the same margins: a table whose margins were widened for
  // them then keeps the margins shown to the user.
  if (const auto before = this->margins(camera.id, *camera.lut, ending);
      !is_another_view && before && about_same(*before, margins))
    return true;
  if (ending.stop_requested()) return true;
  const std::lock_guard lock(mutex_);
  look.known->surfaces = std::move(surfaces);
  look.known->margins = std::move(margins);
  look.known->lut_id = camera.lut->id();
  return true;
}

}  // namespace sslv
