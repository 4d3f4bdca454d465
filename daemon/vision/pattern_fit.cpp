// SPDX-License-Identifier: Apache-2.0
#include "vision/pattern_fit.h"

#include "vision/color_name.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

#include <Eigen/Dense>

namespace sslv {
namespace {

// Thresholds for a disc to count as seen. At an empty place the contrast is about two or three sigmas.
constexpr double kMinSignificance = 8, kMinR2 = 0.2;
/// In the first pass from a poor start position, for example with large cells, much of a disc's residual is
/// not noise but caused by its wrong position.
constexpr double kMinSignificanceFirst = 3.5;
/// Minimum variance of a sample: rounding.
constexpr double kMinVariance = 0.5;
/// A disc further than this from its place in the pattern is another object: kFarFirstMm during the
/// iterations, kFarMm in the final pose.
constexpr double kFarFirstMm = 10, kFarMm = 8;
/// After a step larger than this, another step follows. If edges are more blurred than by the lens alone (r2
/// below kSharpR2), for example because the robot moves, one step covers only part of the distance, so the
/// limits are smaller.
constexpr double kSmallStepMm = 1, kSmallTurnRad = 0.02;
constexpr double kSmearedStepMm = 0.1, kSmearedTurnRad = 0.002, kSharpR2 = 0.97;
constexpr double kMaxStepMm = 12, kMaxTurnRad = 0.25;
/// Regions give positions only to within this share of a cell of the segmentation. With large cells, start
/// positions may therefore be further off than the limits above.
constexpr double kCellReach = 0.7;
/// Samples this near to the rim of the top are left out: robots differ, and the rim is blurred (kRimSigmas).
/// The dots' edges lie there too, so each millimetre that is left out costs accuracy. Beyond the front edge
/// there is mostly the robot's own dark wall, so less is left out at the front. Without the maximum, large
/// pixels would leave no samples.
constexpr double kRimMm = 3, kRimSigmas = 1.5, kMaxRimMm = 12;
constexpr double kFrontRimMm = 2, kFrontRimSigmas = 0.8, kMaxFrontRimMm = 7;
/// Width of the sampled ring around a disc: kMarginPx, but at least kMinMarginMm and at most kMaxMarginMm and
/// half of the gap between dots.
constexpr double kMarginPx = 2, kMinMarginMm = 8, kMaxMarginMm = 20;
/// The whole top is black, so the common ground around all dots counts as much as this many additional
/// samples of each dot. This matters if a dot has only a few pixels.
constexpr double kGroundWeight = 4;
/// The common noise of all dots counts as much as this many samples of each dot.
constexpr double kCommonSamples = 40;

/// The three values at a pixel in the image's own colour space, from the nearest samples. Returns false
/// outside the image and for images without colours.
bool values_at(const ImageView& image, const Eigen::Vector2d& pixel, std::array<float, 3>& out) {
  if (!(pixel.x() >= 0 && pixel.y() >= 0 && pixel.x() < image.width - 0.5 && pixel.y() < image.height - 0.5))
    return false;
  const int x = static_cast<int>(pixel.x() + 0.5), y = static_cast<int>(pixel.y() + 0.5);
  const std::uint8_t* row = image.row(y);
  if (is_yuv422(image.format)) {
    const int luma = image.format == PixelFormat::kUyvy ? 1 : 0;
    const std::uint8_t* pair = row + 2 * (x & ~1);
    out = {static_cast<float>(row[2 * x + luma]), static_cast<float>(pair[1 - luma]),
           static_cast<float>(pair[3 - luma])};
  } else if (image.format == PixelFormat::kRgb24 || image.format == PixelFormat::kBgr24) {
    for (int c = 0; c < 3; ++c) out[static_cast<std::size_t>(c)] = row[3 * x + c];
  } else if (is_bayer(image.format)) {
    // The nearest sample of each colour: every 2x2 square contains all three colours.
    const int x0 = std::min(pixel.x() < x ? std::max(x - 1, 0) : x, image.width - 2);
    const int y0 = std::min(pixel.y() < y ? std::max(y - 1, 0) : y, image.height - 2);
    const bool red_odd_x = image.format == PixelFormat::kBayerGr8 || image.format == PixelFormat::kBayerBg8;
    const bool red_odd_y = image.format == PixelFormat::kBayerGb8 || image.format == PixelFormat::kBayerBg8;
    const int rx = x0 + ((x0 & 1) == (red_odd_x ? 1 : 0) ? 0 : 1),
              ry = y0 + ((y0 & 1) == (red_odd_y ? 1 : 0) ? 0 : 1);
    const int bx = 2 * x0 + 1 - rx, by = 2 * y0 + 1 - ry;
    out = {static_cast<float>(image.row(ry)[rx]),
           0.5F * static_cast<float>(image.row(ry)[bx] + image.row(by)[rx]),
           static_cast<float>(image.row(by)[bx])};
  } else {
    return false;
  }
  return true;
}

/// The larger of a limit and the error of regions' positions.
double reach_mm(double limit_mm, const ImageView& image, const PlanePatch& patch) {
  return std::max(limit_mm, kCellReach * (is_bayer(image.format) ? 2 : 1) * patch.mm_per_px());
}

/// Noise variance of one sample of each plane, from the residuals of all discs together. The residuals of one
/// disc, with a dozen samples, may be small by chance.
std::array<double, 3> common_variances(std::span<const DiscFit> discs) {
  std::array<double, 3> out{};
  for (std::size_t p = 0; p < 3; ++p) {
    double left = 0, free = 0;
    for (const DiscFit& disc : discs) {
      if (!disc.ok) continue;
      left += disc.planes[p].left;
      free += disc.planes[p].free;
    }
    out[p] = std::max(free > 0 ? left / free : 0, kMinVariance);
  }
  return out;
}

ExpectedDisc disc_at(const PatternTable& patterns, const PlanePatch& patch, const Eigen::Vector2d& place_mm,
                     double diameter_mm) {
  const double margin_mm = std::clamp(kMarginPx * patch.mm_per_px(), kMinMarginMm, kMaxMarginMm);
  return {place_mm.x(), place_mm.y(), diameter_mm / 2, std::min(margin_mm, patterns.gap_mm / 2)};
}

}  // namespace

PatternFit PatternFitter::fit(const Frame& frame, PatternPose start, double height_mm, int max_passes,
                              const Eigen::Vector2d& mm_per_row) noexcept {
  const PatternTable& patterns = frame.patterns;
  const std::size_t sides = patterns.dots.size();
  PatternFit out;
  out.pose = start;
  auto patch =
      plane_patch(frame.camera, {start.x_mm, start.y_mm}, height_mm, patterns.reach_mm + kMaxMarginMm);
  if (!patch) return out;
  // Moves the content of each row back to its place at the time when the row of the start position was
  // exposed.
  patch->xv -= mm_per_row.x();
  patch->yv -= mm_per_row.y();

  Eigen::Vector3d moved = Eigen::Vector3d::Zero();  // x, y, angle since the start
  // For each dot, beginning with the centre dot:
  std::array<Eigen::Vector2d, PatternTable::kMaxDots + 1> arms;  // positions relative to the centre
  std::array<DiscMeasure, PatternTable::kMaxDots + 1> measures;
  std::array<DiscFit, PatternTable::kMaxDots + 1> discs;
  const auto dot_at = [](std::size_t i) { return i == 0 ? PatternFit::kCenter : i - 1; };
  const double edge_mm = patch->mm_per_px() * std::sqrt(frame.blur_px * frame.blur_px + 1.0 / 12);
  const double outline_mm = patterns.top_radius_mm - std::min(kRimMm + kRimSigmas * edge_mm, kMaxRimMm);
  const double front_mm =
      patterns.top_front_mm - std::min(kFrontRimMm + kFrontRimSigmas * edge_mm, kMaxFrontRimMm);
  const double far_first_mm = reach_mm(kFarFirstMm, frame.image, *patch);
  const double max_step_mm = reach_mm(kMaxStepMm, frame.image, *patch);
  const bool starts_poorly = far_first_mm > kFarFirstMm;
  for (int pass = 1;; ++pass) {
    const double angle = start.angle_rad + moved.z(), c = std::cos(angle), s = std::sin(angle);
    const DiscOutline outline{moved.x(), moved.y(), c, s, outline_mm, front_mm};
    arms[0] = {c * patterns.center_x_mm - s * patterns.center_y_mm,
               s * patterns.center_x_mm + c * patterns.center_y_mm};
    for (std::size_t i = 0; i <= sides; ++i) {
      double diameter_mm = patterns.center_diameter_mm;
      if (i > 0) {
        const PatternDot& dot = patterns.dots[i - 1];
        arms[i] = {c * dot.x_mm - s * dot.y_mm, s * dot.x_mm + c * dot.y_mm};
        diameter_mm = dot.diameter_mm;
      }
      measures[i] = meter_.measure(frame.image, *patch,
                                   disc_at(patterns, *patch, moved.head<2>() + arms[i], diameter_mm), outline,
                                   frame.blur_px);
    }
    work_ += static_cast<double>(sides) + 1;
    const auto ground = common_ground(std::span(measures).first(sides + 1));

    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
    out.seen = 0;
    double seen_r2 = 0;
    bool all_sure = true;
    const double min_significance = starts_poorly && pass == 1 ? kMinSignificanceFirst : kMinSignificance;
    for (std::size_t i = 0; i <= sides; ++i) {
      for (std::size_t p = 0; p < 3; ++p) measures[i].planes[p].add_ground(ground[p], kGroundWeight);
      discs[i] = fit_disc(measures[i]);
    }
    const auto variances = common_variances(std::span(discs).first(sides + 1));
    for (std::size_t i = 0; i <= sides; ++i) {
      const DiscFit& disc = discs[i];
      PatternDotFit& seen = out.dots[dot_at(i)];
      double signal = 0, significance = 0;
      for (std::size_t p = 0; p < 3; ++p) {
        const double square = disc.planes[p].contrast * disc.planes[p].contrast / variances[p];
        signal += square;
        significance += square * disc.planes[p].spread;
      }
      seen.r2 = disc.r2;
      seen.snr = std::sqrt(signal);
      const double brightness = disc.contrast[0] + disc.contrast[1] + disc.contrast[2];
      seen.seen =
          disc.ok && brightness > 0 && significance > min_significance * min_significance && disc.r2 > kMinR2;
      if (!seen.seen) continue;
      const auto [dx, dy] = disc.offset_mm();
      seen.seen = dx * dx + dy * dy < far_first_mm * far_first_mm;
      if (!seen.seen) continue;
      all_sure = all_sure && significance > kMinSignificance * kMinSignificance;
      ++out.seen;
      seen_r2 += seen.r2;
      // One dot has too few samples to estimate the noise of a plane.
      Eigen::Matrix2d information = Eigen::Matrix2d::Zero();
      Eigen::Vector2d pull = Eigen::Vector2d::Zero();
      for (std::size_t p = 0; p < 3; ++p) {
        const DiscFit::Plane& plane = disc.planes[p];
        const double weight = (plane.free + kCommonSamples) / (plane.left + kCommonSamples * variances[p]);
        information(0, 0) += weight * plane.n00;
        information(0, 1) += weight * plane.n01;
        information(1, 1) += weight * plane.n11;
        pull += weight * Eigen::Vector2d(plane.g0, plane.g1);
      }
      information(1, 0) = information(0, 1);
      Eigen::Matrix<double, 2, 3> by_pose;
      by_pose << 1, 0, -arms[i].y(), 0, 1, arms[i].x();
      normal += by_pose.transpose() * information * by_pose;
      gradient += by_pose.transpose() * pull;
    }
    if (out.seen < 3) {
      out.seen = 0;
      return out;
    }
    Eigen::Vector3d step = normal.ldlt().solve(gradient);
    const double length_mm = step.head<2>().norm();
    if (length_mm > max_step_mm) step.head<2>() *= max_step_mm / length_mm;
    step.z() = std::clamp(step.z(), -kMaxTurnRad, kMaxTurnRad);
    moved += step;
    const bool sharp = seen_r2 > kSharpR2 * out.seen;
    const bool small = length_mm < (sharp ? kSmallStepMm : kSmearedStepMm) &&
                       std::abs(step.z()) < (sharp ? kSmallTurnRad : kSmearedTurnRad);
    if (!(small && all_sure) && pass < max_passes) continue;

    // Results of each dot, relative to the final pose.
    double squares = 0, sum_r2 = 0;
    out.min_r2 = 1;
    out.seen = 0;
    for (std::size_t i = 0; i <= sides; ++i) {
      PatternDotFit& seen = out.dots[dot_at(i)];
      const Eigen::Vector2d place = patch->pixel + patch->to_pixel(moved.head<2>() + arms[i]);
      seen.pixel_x = place.x();
      seen.pixel_y = place.y();
      if (!seen.seen) continue;
      const auto [dx, dy] = discs[i].offset_mm();
      seen.off_mm =
          Eigen::Vector2d(dx - step.x() + step.z() * arms[i].y(), dy - step.y() - step.z() * arms[i].x())
              .norm();
      seen.seen = seen.off_mm < kFarMm;
      if (!seen.seen) continue;
      const ColorName name =
          name_color(discs[i].contrast, discs[i].color, frame.lut,
                     i == 0 ? std::span<const Label>(patterns.team_colors) : patterns.side_colors);
      seen.color = name.color;
      seen.margin = name.margin;
      seen.off = name.off;
      seen.contrast_rgb = discs[i].contrast;
      seen.color_rgb = discs[i].color;
      ++out.seen;
      squares += seen.off_mm * seen.off_mm;
      sum_r2 += seen.r2;
      out.min_r2 = std::min(out.min_r2, seen.r2);
    }
    if (out.seen < 3) {
      out.seen = 0;
      return out;
    }
    out.rms_mm = std::sqrt(squares / out.seen);
    out.mean_r2 = sum_r2 / out.seen;
    out.pose = {start.x_mm + moved.x(), start.y_mm + moved.y(),
                std::remainder(start.angle_rad + moved.z(), 2 * std::numbers::pi)};
    const Eigen::Vector2d middle = patch->pixel + patch->to_pixel(moved.head<2>());
    out.pixel_x = middle.x();
    out.pixel_y = middle.y();
    out.pose.x_mm += mm_per_row.x() * (out.pixel_y - patch->pixel.y());
    out.pose.y_mm += mm_per_row.y() * (out.pixel_y - patch->pixel.y());
    out.px_per_mm = 1 / patch->mm_per_px();
    const Eigen::Matrix3d cov = normal.inverse();
    out.place_cov = {cov(0, 0), cov(0, 1), cov(1, 1)};
    out.angle_sigma_rad = std::sqrt(std::max(0.0, cov(2, 2)));
    return out;
  }
}

PatternFitter::Center PatternFitter::fit_center(const Frame& frame, double x_mm, double y_mm,
                                                double height_mm) noexcept {
  const PatternTable& patterns = frame.patterns;
  const auto patch = plane_patch(frame.camera, {x_mm, y_mm}, height_mm, patterns.center_diameter_mm);
  if (!patch) return {};
  const double max_step_mm = reach_mm(kMaxStepMm, frame.image, *patch);
  double best_r2 = 0;
  Center best;
  const auto fit_from = [&](const Eigen::Vector2d& start) {
    Eigen::Vector2d moved = start;
    double r2 = 0;
    for (int pass = 0; pass < 2; ++pass) {
      const DiscFit disc = fit_disc(
          meter_.measure(frame.image, *patch, disc_at(patterns, *patch, moved, patterns.center_diameter_mm),
                         {}, frame.blur_px));
      work_ += 1;
      const double brightness = disc.contrast[0] + disc.contrast[1] + disc.contrast[2];
      if (!disc.ok || brightness <= 0 || disc.r2 < kMinR2) return;
      const auto [dx, dy] = disc.offset_mm();
      Eigen::Vector2d step(dx, dy);
      if (step.norm() > max_step_mm) step *= max_step_mm / step.norm();
      moved += step;
      r2 = disc.r2;
    }
    if (!(r2 > best_r2 && moved.norm() < max_step_mm)) return;
    best_r2 = r2;
    best = {true, x_mm + moved.x(), y_mm + moved.y()};
  };
  fit_from(Eigen::Vector2d::Zero());
  if (best.seen || max_step_mm <= kMaxStepMm) return best;
  // If a dot covers hardly two cells, the fit may not converge from the region's position.
  const double aside_mm = max_step_mm / 2;
  for (const double x : {-aside_mm, aside_mm}) {
    for (const double y : {-aside_mm, aside_mm}) fit_from({x, y});
  }
  return best;
}

std::size_t PatternFitter::find_headings(const Frame& frame, double x_mm, double y_mm, double height_mm,
                                         std::array<double, kMaxHeadings>& angles_rad) noexcept {
  const PatternTable& patterns = frame.patterns;
  const auto patch = plane_patch(frame.camera, {x_mm, y_mm}, height_mm, patterns.arm_mm);
  if (!patch) return 0;
  work_ += 6;

  constexpr std::size_t kTurns = 72;  // in steps of 5 degrees
  static const auto kDirections = [] {
    std::array<Eigen::Vector2d, kTurns> out;
    for (std::size_t i = 0; i < kTurns; ++i) {
      const double angle = 2 * std::numbers::pi * static_cast<double>(i) / kTurns;
      out[i] = {std::cos(angle), std::sin(angle)};
    }
    return out;
  }();
  // A first-order approximation is sufficient, because samples are taken from the nearest pixel.
  const double det = patch->xu * patch->yv - patch->xv * patch->yu;
  Eigen::Matrix2d to_pixel;
  to_pixel << patch->yv / det, -patch->xv / det, -patch->yu / det, patch->xu / det;
  const auto value = [&](const Eigen::Vector2d& place_mm, std::array<float, 3>& out) {
    return values_at(frame.image, patch->pixel + to_pixel * place_mm, out);
  };
  // Black level: the median on a circle between the centre dot and the side dots.
  const double black_mm = patterns.center_diameter_mm / 2 + patterns.gap_mm / 2;
  std::array<std::array<float, kTurns>, 3> around;
  std::size_t count = 0;
  for (std::size_t i = 0; i < kTurns; i += 2) {
    std::array<float, 3> here;
    if (!value(black_mm * kDirections[i], here)) continue;
    for (std::size_t c = 0; c < 3; ++c) around[c][count] = here[c];
    ++count;
  }
  if (count < kTurns / 4) return 0;
  std::array<float, 3> black;
  for (std::size_t c = 0; c < 3; ++c) {
    const auto middle = around[c].begin() + static_cast<std::ptrdiff_t>(count / 2);
    std::nth_element(around[c].begin(), middle, around[c].begin() + static_cast<std::ptrdiff_t>(count));
    black[c] = *middle;
  }

  constexpr std::size_t kHeadings = 2 * kTurns;
  std::array<float, kHeadings> sum{}, least, second, between{};
  least.fill(1e9F);
  second.fill(1e9F);
  std::size_t gaps = 0;
  for (const PatternTable::Ring& ring : patterns.rings) {
    // Contrast of each place on the ring to the black level.
    std::array<float, kTurns> contrast;
    for (std::size_t i = 0; i < kTurns; ++i) {
      const Eigen::Vector2d middle = ring.radius_mm * kDirections[i], out = ring.spread_mm * kDirections[i],
                            side(-out.y(), out.x());
      std::array<float, 3> mean{};
      int points = 0;
      for (const Eigen::Vector2d& place :
           {middle, Eigen::Vector2d(middle + out), Eigen::Vector2d(middle - out),
            Eigen::Vector2d(middle + side), Eigen::Vector2d(middle - side)}) {
        std::array<float, 3> here;
        if (!value(place, here)) continue;
        for (std::size_t c = 0; c < 3; ++c) mean[c] += here[c];
        ++points;
      }
      float square = 0;
      for (std::size_t c = 0; c < 3 && points > 0; ++c) {
        const float difference = mean[c] / static_cast<float>(points) - black[c];
        square += difference * difference;
      }
      contrast[i] = std::sqrt(square);
    }
    // Limited to the contrast of the dots' inner halves: objects brighter than dots do not outvote dim dots,
    // and headings at which only the dots' rims match score less.
    std::array<float, kTurns> sorted = contrast;
    const auto limit = static_cast<std::size_t>(kTurns * (1 - std::min(1.0, ring.dot_share) / 2));
    std::nth_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(limit), sorted.end());
    for (float& one : contrast) one = std::min(one, sorted[limit]);

    /// Contrast at an angle of the pattern, for every heading.
    const auto for_headings = [&](double angle, const auto& use) {
      const double turn = angle / (2 * std::numbers::pi);
      const double start = (turn - std::floor(turn)) * kHeadings;
      const auto first = static_cast<std::size_t>(start + 0.5);
      for (std::size_t i = 0; i < kHeadings; ++i) {
        const std::size_t at = (first + i) % kHeadings;
        const float here =
            at % 2 == 0 ? contrast[at / 2] : 0.5F * (contrast[at / 2] + contrast[(at / 2 + 1) % kTurns]);
        use(i, here);
      }
    };
    for (const double angle : ring.dot_angles_rad) {
      for_headings(angle, [&](std::size_t i, float here) {
        sum[i] += here;
        second[i] = std::min(second[i], std::max(least[i], here));
        least[i] = std::min(least[i], here);
      });
    }
    for (const double angle : ring.gap_angles_rad)
      for_headings(angle, [&](std::size_t i, float here) { between[i] += here; });
    gaps += ring.gap_angles_rad.size();
  }
  std::array<float, kHeadings> scores;
  for (std::size_t i = 0; i < kHeadings; ++i) {
    scores[i] = sum[i] / static_cast<float>(patterns.dots.size()) + 0.5F * second[i] -
                (gaps > 0 ? 1.5F * between[i] / static_cast<float>(gaps) : 0);
  }
  constexpr double kApartRad = 0.25;
  constexpr float kMinScore = 4;  // grey levels: lower scores are noise on even ground
  std::size_t found = 0;
  while (found < kMaxHeadings) {
    const auto best = std::max_element(scores.begin(), scores.end());
    if (*best < kMinScore) break;
    const auto at = static_cast<std::size_t>(best - scores.begin());
    angles_rad[found++] = 2 * std::numbers::pi * static_cast<double>(at) / kHeadings;
    const auto width = static_cast<std::size_t>(kApartRad / (2 * std::numbers::pi) * kHeadings);
    for (std::size_t i = 0; i <= 2 * width; ++i) scores[(at + kHeadings + i - width) % kHeadings] = -1;
  }
  return found;
}

}  // namespace sslv
