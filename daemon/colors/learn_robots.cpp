// SPDX-License-Identifier: Apache-2.0
#include "colors/learn_robots.h"

#include "colors/find_spots.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <optional>

namespace sslv {
namespace {

constexpr std::size_t kMaxDotSpots = 1500;
constexpr int kMaxPasses = 4;
// Minimum quality of a pattern for learning.
constexpr double kMaxPatternRmsMm = 2.5, kMinPatternR2 = 0.45;
/// Largest difference of the black around a robot's dots, as a share of the dots' contrast.
constexpr double kMaxUnevenBlack = 0.45;
/// Smallest distance between robots.
constexpr double kApartMm = 120;

const Lut& no_colors() {
  static const Lut kEmpty;
  return kEmpty;
}

double quality(const SeenRobot& robot) {
  return robot.mean_r2 - 0.2 * robot.rms_mm;
}

/// The robot of a fit, if all dots are present on one common black.
std::optional<SeenRobot> whole(const PatternFit& fit, const PatternTable& patterns) {
  const std::size_t sides = patterns.dots.size();
  if (fit.seen != static_cast<int>(sides) + 1 || fit.rms_mm > kMaxPatternRmsMm || fit.min_r2 < kMinPatternR2)
    return {};
  SeenRobot out;
  out.pose = fit.pose;
  out.pixel_x = fit.pixel_x;
  out.pixel_y = fit.pixel_y;
  out.px_per_mm = fit.px_per_mm;
  out.rms_mm = fit.rms_mm;
  out.min_r2 = fit.min_r2;
  out.mean_r2 = fit.mean_r2;
  Color3 ground = Color3::Zero();
  double contrast = 0;
  for (std::size_t i = 0; i <= sides; ++i) {
    const PatternDotFit& dot = fit.dots[i == 0 ? PatternFit::kCenter : i - 1];
    const SeenDot seen{Color3(dot.contrast_rgb.data()), Color3(dot.color_rgb.data()), dot.pixel_x,
                       dot.pixel_y, dot.snr};
    ground += seen.color - seen.contrast;
    contrast += seen.contrast.norm();
    out.dots.push_back(seen);
  }
  const double count = static_cast<double>(sides) + 1;
  out.black = ground / count;
  contrast /= count;
  for (const SeenDot& dot : out.dots) {
    if ((dot.color - dot.contrast - out.black).norm() > kMaxUnevenBlack * contrast) return {};
  }
  return out;
}

/// Scales in px per mm that cover the image.
std::vector<double> scales_of(const ImageView& image, const CameraModel& camera, double height_mm) {
  std::vector<double> all;
  for (int y = 0; y < 5; ++y) {
    for (int x = 0; x < 5; ++x) {
      const double area =
          camera.mm2_per_px({(x + 0.5) / 5 * image.width, (y + 0.5) / 5 * image.height}, height_mm);
      if (area > 0) all.push_back(1 / std::sqrt(area));
    }
  }
  if (all.empty()) return {};
  std::sort(all.begin(), all.end());
  constexpr double kSame = 1.5;  // the spot filter tolerates a factor of sqrt(kSame)
  const double low = all[all.size() / 10], high = all[all.size() - 1 - all.size() / 10];
  const double middle = all[all.size() / 2];
  if (high / low < kSame) return {middle};
  std::vector<double> out;
  for (double scale = low * std::sqrt(kSame); scale / std::sqrt(kSame) < high; scale *= kSame)
    out.push_back(scale);
  return out;
}

/// Keeps only the best of overlapping robots.
std::vector<SeenRobot> without_duplicates(std::vector<SeenRobot> found) {
  std::sort(found.begin(), found.end(),
            [](const SeenRobot& a, const SeenRobot& b) { return quality(a) > quality(b); });
  std::vector<SeenRobot> out;
  for (SeenRobot& robot : found) {
    const bool taken = std::any_of(out.begin(), out.end(), [&](const SeenRobot& other) {
      return other.frame == robot.frame &&
             std::hypot(other.pixel_x - robot.pixel_x, other.pixel_y - robot.pixel_y) <
                 kApartMm * robot.px_per_mm;
    });
    if (!taken) out.push_back(std::move(robot));
  }
  return out;
}

class PatternSearch {
 public:
  PatternSearch(const RobotSearch& search, std::size_t frame)
      : search_(search), frame_(frame), image_(search.frames[frame]) {}

  void look(const CameraModel& camera, double height_mm, double px_per_mm) {
    if (search_.stop.stop_requested()) return;
    const double radius_px = search_.patterns.center_diameter_mm / 2 * px_per_mm;
    const SmallPicture& picture = search_.pictures[frame_].of(cell_px_for(image_.format, radius_px));
    const auto spots =
        find_spots(picture, radius_px, search_.noise_grey[frame_], SpotsOf::kBrighter, kMaxDotSpots);
    const PatternFitter::Frame frame{image_, camera, search_.patterns, no_colors(), kUsualBlurPx};
    for (const Spot& spot : spots) {
      if (search_.stop.stop_requested()) return;
      const auto place = camera.unproject(spot.pixel, height_mm);
      if (!place) continue;
      const auto center = fitter_.fit_center(frame, place->x(), place->y(), height_mm);
      if (!center.seen) continue;
      std::array<double, PatternFitter::kMaxHeadings> angles;
      const std::size_t count = fitter_.find_headings(frame, center.x_mm, center.y_mm, height_mm, angles);
      for (std::size_t i = 0; i < count; ++i) {
        const PatternFit fit =
            fitter_.fit(frame, search_.patterns.with_center_at(center.x_mm, center.y_mm, angles[i]),
                        height_mm, kMaxPasses);
        auto robot = whole(fit, search_.patterns);
        if (!robot) continue;
        robot->frame = frame_;
        robot->height_mm = height_mm;
        found_.push_back(std::move(*robot));
        break;
      }
    }
  }
  std::vector<SeenRobot> found() { return without_duplicates(std::move(found_)); }

 private:
  const RobotSearch& search_;
  std::size_t frame_;
  const ImageView& image_;
  PatternFitter fitter_;
  std::vector<SeenRobot> found_;
};

}  // namespace

std::vector<SeenRobot> find_patterns(const RobotSearch& search, const CameraModel& camera,
                                     std::span<const double> heights_mm) {
  std::vector<SeenRobot> out;
  for (std::size_t frame = 0; frame < search.frames.size(); ++frame) {
    PatternSearch one(search, frame);
    for (const double height_mm : heights_mm) {
      for (const double px_per_mm : scales_of(search.frames[frame], camera, height_mm))
        one.look(camera, height_mm, px_per_mm);
    }
    auto found = one.found();
    std::move(found.begin(), found.end(), std::back_inserter(out));
  }
  return out;
}

std::vector<SeenRobot> find_patterns_flat(const RobotSearch& search, double mm_per_px) {
  std::vector<SeenRobot> all;
  constexpr std::array kHeightsMm{0.0};
  for (const double factor : {1.0, 0.94, 1.06}) {
    const ImageView& image = search.frames.front();
    auto found =
        find_patterns(search, flat_camera(image.width, image.height, factor * mm_per_px), kHeightsMm);
    for (SeenRobot& robot : found) {
      robot.pose.x_mm /= factor;
      robot.pose.y_mm /= factor;
    }
    std::move(found.begin(), found.end(), std::back_inserter(all));
  }
  return without_duplicates(std::move(all));
}

CameraModel flat_camera(int width_px, int height_px, double mm_per_px) {
  constexpr double kFocalPx = 20'000;
  CameraCalibration c;
  c.focal_length = kFocalPx;
  c.principal_point_x = (width_px - 1) / 2.0;
  c.principal_point_y = (height_px - 1) / 2.0;
  // Looks down; in the image +x is right, +y up.
  c.q0 = 1;
  c.q3 = 0;
  c.tz = kFocalPx * mm_per_px;
  c.pixel_image_width = width_px;
  c.pixel_image_height = height_px;
  return CameraModel(c);
}

double find_scale(const RobotSearch& search) {
  // A camera sees between 1.5 m and 14 m of a field, and a dot is at least four pixels wide.
  constexpr double kMaxSeenMm = 14'000, kMinSeenMm = 1500, kMinPxPerMm = 0.08, kStep = 1.1;
  const double width = search.frames.empty() ? 0 : search.frames.front().width;
  const double least = std::max(kMinPxPerMm, width / kMaxSeenMm), most = width / kMinSeenMm;
  const auto score_at = [&](double px_per_mm, std::size_t frame) {
    const CameraModel camera =
        flat_camera(search.frames[frame].width, search.frames[frame].height, 1 / px_per_mm);
    PatternSearch one(search, frame);
    one.look(camera, 0, px_per_mm);
    double score = 0;
    for (const SeenRobot& robot : one.found()) score += std::max(0.1, quality(robot));
    return score;
  };
  double best_scale = 0, best = 0;
  for (std::size_t frame = 0; frame < search.frames.size() && best == 0; ++frame) {
    for (double scale = least; scale < most && !search.stop.stop_requested(); scale *= kStep) {
      const double score = score_at(scale, frame);
      if (score <= best) continue;
      best = score;
      best_scale = scale;
    }
    if (best == 0) continue;
    // Refine around the best scale.
    for (const double factor : {1.05, 0.95, 1.025, 0.975, 1.0125, 0.9875}) {
      const double score = score_at(best_scale * factor, frame);
      if (score <= best) continue;
      best = score;
      best_scale *= factor;
    }
  }
  return best_scale > 0 ? 1 / best_scale : 0;
}

}  // namespace sslv
