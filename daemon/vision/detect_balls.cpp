// SPDX-License-Identifier: Apache-2.0
#include "vision/detect_balls.h"

#include "vision/color_name.h"
#include "vision/cut_off.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <vector>

namespace sslv {
namespace {

/// Colours that may be confused with the ball's.
constexpr std::array kLikeBalls{label::kOrange, label::kYellow, label::kPink, label::kBlue, label::kGreen};

/// Whether the ray through the pixel meets a robot's top, `inside_mm` or more within its outline.
bool lies_on_one(const std::vector<Robot>& robots, const CameraModel& camera, const Eigen::Vector2d& pixel,
                 double radius_mm, double front_mm, double inside_mm) {
  const double within_mm = radius_mm - inside_mm;
  double height_mm = std::numeric_limits<double>::quiet_NaN();
  // Point where the ray meets the plane z = height_mm; most robots have the same height.
  Eigen::Vector2d top = Eigen::Vector2d::Constant(height_mm);
  for (const Robot& robot : robots) {
    if (robot.height_mm != height_mm) {
      height_mm = robot.height_mm;
      top.setConstant(std::numeric_limits<double>::quiet_NaN());
      if (const auto place = camera.unproject(pixel, height_mm)) top = *place;
    }
    const double dx = top.x() - robot.x_mm, dy = top.y() - robot.y_mm;
    if (!(within_mm > 0 && dx * dx + dy * dy < within_mm * within_mm)) continue;
    const double ahead = std::cos(robot.orientation_rad) * dx + std::sin(robot.orientation_rad) * dy;
    if (ahead < front_mm - inside_mm) return true;
  }
  return false;
}

/// Distance (mm) outside the touch and goal lines; below 0: inside. The goals belong to the field.
double outside_mm(const FieldSize& field, const Eigen::Vector2d& place_mm) {
  const double beyond_x = std::abs(place_mm.x()) - field.field_length / 2.0;
  const double beyond_y = std::abs(place_mm.y()) - field.field_width / 2.0;
  const bool in_goal = beyond_x < field.goal_depth && std::abs(place_mm.y()) < field.goal_width / 2.0;
  return in_goal ? std::min(0.0, beyond_x) : std::max(beyond_x, beyond_y);
}

/// By how many mm the segmentation's cells are wider than in the images to which the confidence was fitted; 0
/// if the difference is small.
double coarser_mm(const CameraModel& camera, const ImageView& image, const Eigen::Vector2d& pixel,
                  double radius_mm) {
  // Cell width / radius: Bayer quads in images of 0.18 px/mm (kUsual) and 0.12 px/mm (kCoarse). Up to
  // kCoarse, one fit from a region's centroid is sufficient; five fits for each region would cost too much in
  // a hall full of orange objects.
  constexpr double kUsual = 0.55, kCoarse = 0.75;
  const double cell_mm = (is_bayer(image.format) ? 2 : 1) * std::sqrt(camera.mm2_per_px(pixel, radius_mm));
  return cell_mm > kCoarse * radius_mm ? cell_mm - kUsual * radius_mm : 0;
}

/// The highest confidence that is possible after BallFitter::judge().
double max_confidence_of(BallEvidence e) {
  e.misfit = e.out_of_round = e.max_alike = 0;
  return confidence_of(e);
}

/// Limits if cells are coarse: kUnsure for the radius's sigma / radius, kOffColor for the distance of the
/// colour in spreads of the ball's colour.
constexpr double kUnsure = 0.35, kOffColor = 0.5;
/// A ball is partly hidden if a share of less than kHidden is visible. Then more fits start kAside radii to
/// each side of the region's centroid.
constexpr double kHidden = 0.95, kMinVisible = 0.4, kAside = 0.35;
/// Least confidence of objects from which the balls' colour is learnt.
constexpr double kSure = 0.8;
/// Best case assumed for an unfinished fit: the unexplained share and the radius error shrink by the factor
/// kStillUnexplained, the distance of the colour shrinks by the factor kStillOff, and the contrast grows by
/// the factor kMoreContrast. The detections were the same with and without this check in 816 YUV and RGB
/// images of 34 drawn halls. Not used if cells are coarse, because balls are then searched from additional
/// starts.
constexpr double kStillUnexplained = 0.3, kStillOff = 0.4, kMoreContrast = 1.5;
/// Least confidence of objects that are remembered.
constexpr double kPerhaps = 0.02;

/// Whether `place` is a better fit of a ball than `other`. If both have the same position, `other` is
/// preferred unless it is clearly worse, because small differences are random.
template <class Place, class Other>
bool is_better(const Place& place, double confidence, const Other& other, double others_confidence) {
  constexpr double kSamePlaceMm = 0.1, kSameConfidence = 0.01;
  const bool same_place = std::hypot(place.x_mm - other.x_mm, place.y_mm - other.y_mm) < kSamePlaceMm;
  return confidence > others_confidence + (same_place ? kSameConfidence : 0);
}

}  // namespace

void DetectBalls::process(const Params& params, const Scene& scene, const Lut& lut, const Mask& mask,
                          const FrameInfo& info, const Image& image, const RegionList& regions,
                          const RobotList& robots, BallList& out) noexcept {
  out.balls.clear();
  candidates_.clear();
  out.capped = false;
  if (!scene.camera || image.view().empty()) return;
  const CameraModel& camera = *scene.camera;
  const double radius_mm = scene.field.ball_radius;
  const double true_area_mm2 = std::numbers::pi * radius_mm * radius_mm;
  const double max_x_mm = scene.field.field_length / 2.0 + params.max_outside_mm;
  const double max_y_mm = scene.field.field_width / 2.0 + params.max_outside_mm;
  const double robot_radius_mm = scene.field.max_robot_radius;
  // The league's robots have a flat front at this distance.
  const double robot_front_mm = robot_radius_mm * 55 / 90;

  const BallFitter::Frame frame{image.view(),    camera,         radius_mm,     robots.robots,
                                robot_radius_mm, robot_front_mm, params.blur_px};
  const double min_remembered = std::min(params.min_confidence, kPerhaps);
  if (calibration_ && *calibration_ != camera.calibration()) memory_.forget_places();
  calibration_ = camera.calibration();
  memory_.begin(info.times.t_capture_s);
  int fits = 0;
  const auto look_at = [&](const Region& region) {
    const Eigen::Vector2d pixel(region.x_px, region.y_px);
    const double ratio = region.area_px * camera.mm2_per_px(pixel, radius_mm) / true_area_mm2;
    if (!(ratio >= params.min_area_ratio && ratio <= params.max_area_ratio)) return;
    // If the image's edge cuts a region on two sides, too little of the region is visible to locate its
    // middle.
    const bool in_corner = (region.left == 0 || region.right + 1 >= image.view().width) &&
                           (region.top == 0 || region.bottom + 1 >= image.view().height);
    if (in_corner || is_cut_off(region, image.view(), mask)) return;
    const auto place = camera.unproject(pixel, radius_mm);
    if (!place || std::abs(place->x()) > max_x_mm || std::abs(place->y()) > max_y_mm) return;
    if (lies_on_one(robots.robots, camera, pixel, robot_radius_mm, robot_front_mm, params.on_robot_mm))
      return;
    if (++fits > params.max_fits) {
      out.capped = true;
      return;
    }
    const double coarse_mm = coarser_mm(camera, image.view(), pixel, radius_mm);
    BallFit fit;
    BallEvidence evidence;
    double confidence = 0;
    // Most orange objects in a hall are not balls, and most fits show this before they are finished.
    const auto may_become_ball = [&](const BallFit& so_far) {
      BallEvidence at_best = evidence_of(so_far, scene, lut, ratio, coarse_mm);
      at_best.r2 = 1 - kStillUnexplained * (1 - at_best.r2);
      at_best.radius_off *= kStillUnexplained;
      at_best.color_off *= kStillOff;
      at_best.contrast *= kMoreContrast;
      at_best.is_orange = true;
      at_best.moved_share = 0;
      at_best.radius_sigma = std::min(at_best.radius_sigma, 0.1);
      return max_confidence_of(at_best) >= min_remembered;
    };
    BallFitter::MayBeBall may_be_ball;
    // In Bayer images an unfinished fit is not informative enough, and finishing it costs little.
    if (coarse_mm == 0 && !is_bayer(image.view().format))
      may_be_ball = std::cref(may_become_ball);  // no copy: nothing is allocated
    const auto try_from = [&](double x_mm, double y_mm) {
      BallFit other = fitter_.fit(frame, x_mm, y_mm, may_be_ball);
      if (!fit.ok) fit.visible_share = other.visible_share;
      if (!other.ok) return;
      other.moved_mm = std::hypot(other.x_mm - place->x(), other.y_mm - place->y());
      BallEvidence says = evidence_of(other, scene, lut, ratio, coarse_mm);
      // With only a few samples, nearly any object fits as round, so the colour decides.
      const bool unlike =
          coarse_mm > 0 && (!says.is_orange || says.color_off > kOffColor || says.radius_sigma > kUnsure);
      // Skips judge() if even its best result could not make this object a ball. This is the case for most
      // orange objects in a hall.
      double likely = unlike ? 0 : max_confidence_of(says);
      if (!unlike && likely >= min_remembered) {
        fitter_.judge(other);
        says = evidence_of(other, scene, lut, ratio, coarse_mm);
        likely = confidence_of(says);
      }
      if (fit.ok && !is_better(other, likely, fit, confidence)) return;
      fit = other;
      evidence = says;
      confidence = likely;
    };
    try_from(place->x(), place->y());
    // The region's centroid may be nearer to the silhouette than to the ball's centre if cells are large or
    // if a robot hides half of the ball.
    const bool is_hidden =
        fit.visible_share > 0 && fit.visible_share < kHidden && confidence < params.min_confidence;
    if (coarse_mm > 0 || is_hidden) {
      const double aside_mm = coarse_mm > 0 ? coarse_mm / 2 : kAside * radius_mm;
      for (const double x : {-aside_mm, aside_mm}) {
        for (const double y : {-aside_mm, aside_mm}) try_from(place->x() + x, place->y() + y);
      }
      if (is_hidden && !(evidence.is_orange && fit.visible_share > kMinVisible)) return;
    }
    if (!fit.ok) return;
    // Objects that are not reported are remembered too: in other light they may look more like balls.
    if (confidence < min_remembered) return;
    // If several regions belong to one ball, the best fit counts.
    const Candidate candidate{fit, evidence, confidence, region.area_px, {}};
    const auto same = std::find_if(candidates_.begin(), candidates_.end(), [&](const Candidate& other) {
      return std::hypot(other.fit.x_mm - fit.x_mm, other.fit.y_mm - fit.y_mm) < radius_mm;
    });
    if (same == candidates_.end()) {
      candidates_.push_back(candidate);
    } else if (is_better(fit, confidence, same->fit, same->confidence)) {
      *same = candidate;
    }
  };
  for (const Region& region : regions.of(label::kOrange)) {
    if (out.capped) break;
    look_at(region);
  }
  // If a ball fills no cell completely, its colour and the carpet's mix to yellow.
  const Eigen::Vector2d middle(image.view().width / 2.0, image.view().height / 2.0);
  if (coarser_mm(camera, image.view(), middle, radius_mm) > 0) {
    for (const Region& region : regions.of(label::kYellow)) {
      if (out.capped) break;
      look_at(region);
    }
  }
  const auto object_of = [&](const Candidate& c) {
    return BallMemory::Object{
        c.fit.x_mm,          c.fit.y_mm, c.evidence.outside_mm, c.fit.color, c.evidence.out_of_round,
        c.confidence > kSure};
  };
  for (Candidate& candidate : candidates_) candidate.known = memory_.see_again(object_of(candidate));
  for (Candidate& candidate : candidates_) {
    if (!candidate.known) candidate.known = memory_.see_elsewhere(object_of(candidate));
  }
  for (Candidate& candidate : candidates_) {
    const BallMemory::Known& known = *candidate.known;
    if (known.as_furniture || known.unlike_balls) continue;
    const BallFit& fit = candidate.fit;
    double confidence = candidate.confidence;
    const auto pixel = camera.project({fit.x_mm, fit.y_mm, radius_mm});
    if (!pixel) continue;
    // Compares with tape only if the ball is at rest, because a moving ball is blurred into a strip, and only
    // if pixels are small enough to show the corners of tape.
    constexpr double kLargePixel = 0.47;  // share of the radius
    constexpr double kNearly = 0.5;       // its confidence over time may suffice, even if this one does not
    if (confidence >= kNearly * params.min_confidence && known.at_rest &&
        std::sqrt(camera.mm2_per_px(*pixel, radius_mm)) < kLargePixel * radius_mm) {
      candidate.evidence.tape_gain = fitter_.rectangle_gain(frame, fit);
      candidate.evidence.is_bayer = is_bayer(image.view().format);
      confidence = confidence_of(candidate.evidence);
    }
    confidence = memory_.over_time(known.number, confidence);
    if (confidence < params.min_confidence) continue;
    out.balls.push_back({fit.x_mm, fit.y_mm, pixel->x(), pixel->y(), candidate.area_px, confidence,
                         fit.place_cov, fit.radius_mm, fit.radius_sigma_mm});
  }
  std::sort(out.balls.begin(), out.balls.end(),
            [](const Ball& a, const Ball& b) { return a.confidence > b.confidence; });
  if (out.balls.size() > static_cast<std::size_t>(params.max_balls)) {
    out.balls.resize(static_cast<std::size_t>(params.max_balls));
  }
}

BallEvidence DetectBalls::evidence_of(const BallFit& fit, const Scene& scene, const Lut& lut,
                                      double area_ratio, double coarser_mm) {
  const double radius_mm = scene.field.ball_radius;
  BallEvidence e;
  e.r2 = fit.r2;
  e.moved_share = std::max(0.0, fit.moved_mm - coarser_mm) / radius_mm;
  e.clear_share = fit.clear_share;
  e.misfit = fit.misfit;
  e.out_of_round =
      fit.out_of_round_mm / std::hypot(0.035 * radius_mm, fit.out_of_round_sigma_mm, 0.1 * coarser_mm);
  e.radius_off = std::abs(fit.radius_mm - radius_mm) / std::hypot(0.08 * radius_mm, fit.radius_sigma_mm);
  e.radius_sigma = fit.radius_sigma_mm / radius_mm;
  e.area_ratio = area_ratio / std::max(0.1, fit.visible_share);
  // Cells at the silhouette are half ball, half carpet.
  if (e.area_ratio < 1) e.area_ratio = std::min(1.0, e.area_ratio + coarser_mm / radius_mm);
  e.visible_share = fit.visible_share;
  const ColorName name = name_color(fit.color, fit.color, lut, kLikeBalls);
  // If balls fill no cell completely, the table knows only mixtures with the carpet, not their own colour.
  constexpr double kSameColor = 0.25;
  const bool same_color = coarser_mm > 0 && name.off < kSameColor;
  e.is_orange = name.color == label::kOrange && (name.margin > 0 || same_color);
  e.color_off = name.off;
  e.contrast = fit.contrast;
  e.max_alike = fit.max_alike;
  e.outside_mm = outside_mm(scene.field, {fit.x_mm, fit.y_mm});
  return e;
}

}  // namespace sslv
