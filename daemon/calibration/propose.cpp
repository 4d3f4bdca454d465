// SPDX-License-Identifier: Apache-2.0
#include "calibration/propose.h"

#include "calibration/find_pose.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>

#include <Eigen/Dense>

namespace sslv {
namespace {

constexpr double kPi = std::numbers::pi;

/// A point on a bright stripe's middle, in px, and the direction of the stripe's normal.
struct StripePoint {
  double x, y, normal_rad;
};

/// Line x cos(normal) + y sin(normal) = distance, in undistorted px from the image's middle.
struct StraightLine {
  double normal_rad, distance_px, length_px;
};

/// Direction across the stripe at a pixel, from the second moments of the contrast around it; nothing if
/// these show no clear direction.
std::optional<double> normal_at(const LinePicture& picture, int x, int y) {
  constexpr int kReach = 5;
  double sum = 0, sx = 0, sy = 0, xx = 0, xy = 0, yy = 0;
  for (int j = -kReach; j <= kReach; ++j) {
    const float* row = picture.line.row(y + j) + x;
    for (int i = -kReach; i <= kReach; ++i) {
      const double weight = std::max(0.0F, row[i] - 0.5F * picture.min_line);
      sum += weight;
      sx += weight * i;
      sy += weight * j;
      xx += weight * i * i;
      xy += weight * i * j;
      yy += weight * j * j;
    }
  }
  if (sum <= 0) return std::nullopt;
  xx -= sx * sx / sum;
  xy -= sx * sy / sum;
  yy -= sy * sy / sum;
  constexpr double kMinCoherence = 0.6;
  if (std::hypot(xx - yy, 2 * xy) < kMinCoherence * (xx + yy)) return std::nullopt;
  return 0.5 * std::atan2(2 * xy, xx - yy) + kPi / 2;
}

std::vector<StripePoint> stripe_points(const LinePicture& picture) {
  constexpr int kMargin = 6;
  std::vector<StripePoint> out;
  for (int y = kMargin; y < picture.height() - kMargin; ++y) {
    const float *above = picture.line.row(y - 1), *here = picture.line.row(y),
                *below = picture.line.row(y + 1);
    for (int x = kMargin; x < picture.width() - kMargin; ++x) {
      if (here[x] < picture.min_line) continue;
      const bool on_crest =
          (here[x] >= here[x - 1] && here[x] > here[x + 1]) || (here[x] >= above[x] && here[x] > below[x]);
      if (!on_crest) continue;
      const auto normal = normal_at(picture, x, y);
      if (!normal) continue;
      const double nx = std::cos(*normal), ny = std::sin(*normal);
      const float before = value_at(picture.line, x - nx, y - ny),
                  after = value_at(picture.line, x + nx, y + ny);
      if (here[x] < before || here[x] < after) continue;
      const float bend = before - 2 * here[x] + after;
      const double offset = bend < 0 ? std::clamp(0.5 * (before - after) / bend, -0.7, 0.7) : 0;
      out.push_back({x + offset * nx, y + offset * ny, *normal});
    }
  }
  return out;
}

/// Converts pixels to undistorted ("straight") px from the image's middle, and back. With radii from the
/// principal point in units of the focal length: undistorted = distorted (1 + k1 distorted^2).
class Straightener {
 public:
  Straightener(int width, int height, const CameraPrior& lens, double k1)
      : lens_(lens.center_x, lens.center_y), focal_px_(lens.focal_px), half_px_(width / 2.0), k1_(k1) {
    const Eigen::Vector2d middle = Eigen::Vector2d((width - 1) / 2.0, (height - 1) / 2.0) - lens_;
    middle_ = middle * (1 + k1_ * middle.squaredNorm() / (focal_px_ * focal_px_));
  }

  StripePoint straight(const StripePoint& point) const {
    const double x = point.x - lens_.x(), y = point.y - lens_.y(), unit2 = focal_px_ * focal_px_;
    const double scale = 1 + k1_ * (x * x + y * y) / unit2;
    const double tx = -std::sin(point.normal_rad), ty = std::cos(point.normal_rad);
    const double change = 2 * k1_ * (x * tx + y * ty) / unit2;
    const double vx = tx * scale + x * change, vy = ty * scale + y * change;
    double normal = std::atan2(vx, -vy);
    normal -= kPi * std::floor(normal / kPi);
    return {x * scale - middle_.x(), y * scale - middle_.y(), normal};
  }
  /// The pixel of an undistorted position.
  Eigen::Vector2d bent(const Eigen::Vector2d& place) const {
    const Eigen::Vector2d from_lens = place + middle_;
    const double undistorted = from_lens.norm() / focal_px_;
    double r = undistorted;
    for (int i = 0; i < 6; ++i) r -= (r * (1 + k1_ * r * r) - undistorted) / (1 + 3 * k1_ * r * r);
    return lens_ + from_lens * (undistorted > 1e-9 ? r / undistorted : 1);
  }
  double half_px() const { return half_px_; }

 private:
  Eigen::Vector2d lens_, middle_;  // principal point, px; undistorted vector from it to the image's middle
  double focal_px_, half_px_, k1_;
};

/// Hough transform for straight lines (Hough 1962, Duda and Hart 1972). A point votes only for directions
/// near its own.
class Votes {
 public:
  static constexpr int kAngles = 360;
  Votes(int width, int height)
      : reach_px_(1.1 * std::hypot(width, height)),  // the undistorted image is larger than the image
        step_px_(std::max(1.5, width / 600.0)),
        distances_(static_cast<int>(2 * reach_px_ / step_px_) + 3) {}

  void count(std::span<const StripePoint> points) {
    constexpr int kNear = 5;
    counts_.assign(static_cast<std::size_t>(kAngles) * static_cast<std::size_t>(distances_), 0);
    const std::size_t step = std::max<std::size_t>(1, points.size() / 20000);
    for (std::size_t i = 0; i < points.size(); i += step) {
      const int middle = static_cast<int>(std::lround(points[i].normal_rad / kPi * kAngles));
      for (int near = -kNear; near <= kNear; ++near) {
        const int angle = (middle + near + kAngles) % kAngles;
        const double rad = angle * kPi / kAngles;
        const double distance_px = points[i].x * std::cos(rad) + points[i].y * std::sin(rad);
        const int bin = static_cast<int>((distance_px + reach_px_) / step_px_);
        if (bin >= 0 && bin < distances_) counts_[index(angle, bin)] += 1;
      }
    }
  }
  /// Measure that grows as the votes concentrate.
  double sharpness() const {
    double sum = 0;
    for (const float count : counts_) sum += static_cast<double>(count) * count * count;
    return sum;
  }
  /// Returns the line with the most votes and clears the votes around it; nothing if only few votes are left.
  std::optional<StraightLine> take_best() {
    constexpr float kMinVotes = 8;
    const auto best = std::max_element(counts_.begin(), counts_.end());
    if (best == counts_.end() || *best < kMinVotes) return std::nullopt;
    const auto at = static_cast<int>(best - counts_.begin());
    const int angle = at / distances_, bin = at % distances_;
    for (int i = -12; i <= 12; ++i) {
      for (int j = -4; j <= 4; ++j) {
        int a = angle + i, b = bin + j;
        if (a < 0 || a >= kAngles) {  // wraps around: the opposite normal
          a = (a + kAngles) % kAngles;
          b = distances_ - 1 - b;
        }
        if (b >= 0 && b < distances_) counts_[index(a, b)] = 0;
      }
    }
    return StraightLine{angle * kPi / kAngles, (bin + 0.5) * step_px_ - reach_px_, 0};
  }

 private:
  std::size_t index(int angle, int bin) const {
    return static_cast<std::size_t>(angle) * static_cast<std::size_t>(distances_) +
           static_cast<std::size_t>(bin);
  }
  double reach_px_, step_px_;
  int distances_;
  std::vector<float> counts_;
};

double angle_between(double a_rad, double b_rad) {
  const double difference = std::abs(a_rad - b_rad);
  return std::min(difference, std::abs(kPi - difference));
}

/// Straight lines through the points, each by total least squares over its own points.
std::vector<StraightLine> straight_lines(std::span<const StripePoint> points, Votes& votes, int width) {
  const double near_px = std::max(3.0, width / 300.0), min_length_px = 0.06 * width;
  constexpr int kMaxPeaks = 24;
  constexpr std::size_t kMinPoints = 8;
  constexpr double kNearRad = 0.12, kGapPx = 2.5;
  std::vector<char> used(points.size(), 0);
  std::vector<StraightLine> out;
  for (int peak = 0; peak < kMaxPeaks; ++peak) {
    auto line = votes.take_best();
    if (!line) break;
    std::vector<std::size_t> on;
    for (int round = 0; round < 4; ++round) {
      on.clear();
      const double c = std::cos(line->normal_rad), s = std::sin(line->normal_rad);
      for (std::size_t i = 0; i < points.size(); ++i) {
        if (used[i] == 0 && std::abs(points[i].x * c + points[i].y * s - line->distance_px) < near_px &&
            angle_between(points[i].normal_rad, line->normal_rad) < kNearRad)
          on.push_back(i);
      }
      if (on.size() < kMinPoints) break;
      Eigen::Vector2d middle(0, 0);
      for (const std::size_t i : on) middle += Eigen::Vector2d(points[i].x, points[i].y);
      middle /= static_cast<double>(on.size());
      double xx = 0, xy = 0, yy = 0;
      for (const std::size_t i : on) {
        const double dx = points[i].x - middle.x(), dy = points[i].y - middle.y();
        xx += dx * dx;
        xy += dx * dy;
        yy += dy * dy;
      }
      line->normal_rad = 0.5 * std::atan2(2 * xy, xx - yy) + kPi / 2;
      line->normal_rad -= kPi * std::floor(line->normal_rad / kPi);
      line->distance_px = middle.x() * std::cos(line->normal_rad) + middle.y() * std::sin(line->normal_rad);
    }
    if (on.size() < kMinPoints) continue;
    std::vector<double> along;
    for (const std::size_t i : on)
      along.push_back(-points[i].x * std::sin(line->normal_rad) + points[i].y * std::cos(line->normal_rad));
    std::sort(along.begin(), along.end());
    for (std::size_t i = 1; i < along.size(); ++i)
      line->length_px += std::min(along[i] - along[i - 1], kGapPx);
    if (line->length_px < min_length_px) continue;
    const bool is_known = std::any_of(out.begin(), out.end(), [&](const StraightLine& other) {
      const bool turned = std::abs(other.normal_rad - line->normal_rad) > kPi / 2;
      const double distance_px = turned ? -line->distance_px : line->distance_px;
      return angle_between(other.normal_rad, line->normal_rad) < 0.03 &&
             std::abs(other.distance_px - distance_px) < std::max(4.0, width / 250.0);
    });
    if (is_known) continue;
    for (const std::size_t i : on) used[i] = 1;
    out.push_back(*line);
  }
  return out;
}

/// Lines of one direction, sorted by their distance from the middle.
using Family = std::vector<StraightLine>;

/// The longest lines, at most kMax each, of two roughly perpendicular directions.
std::array<Family, 2> two_families(const std::vector<StraightLine>& lines) {
  double best = 0, most = -1;
  constexpr int kAngles = 180;
  for (int i = 0; i < kAngles; ++i) {
    const double angle = i * kPi / 2 / kAngles;
    double sum = 0;
    for (const StraightLine& line : lines)
      sum += line.length_px * std::pow(std::max(0.0, std::cos(4 * (line.normal_rad - angle))), 4);
    if (sum <= most) continue;
    most = sum;
    best = angle;
  }
  std::array<Family, 2> out;
  constexpr double kAlike = 0.55;
  constexpr std::size_t kMax = 7;
  for (const StraightLine& line : lines) {
    const double alike = std::cos(2 * (line.normal_rad - best));
    if (alike > kAlike) out[0].push_back(line);
    if (alike < -kAlike) out[1].push_back(line);
  }
  for (std::size_t f = 0; f < 2; ++f) {
    Family& family = out[f];
    std::sort(family.begin(), family.end(),
              [](const StraightLine& a, const StraightLine& b) { return a.length_px > b.length_px; });
    if (family.size() > kMax) family.resize(kMax);
    const double base = best + (f == 0 ? 0 : kPi / 2);
    for (StraightLine& line : family) {  // make all normals point the same way
      while (line.normal_rad - base > kPi / 2) line.normal_rad -= kPi, line.distance_px = -line.distance_px;
      while (line.normal_rad - base < -kPi / 2) line.normal_rad += kPi, line.distance_px = -line.distance_px;
    }
    std::sort(family.begin(), family.end(),
              [](const StraightLine& a, const StraightLine& b) { return a.distance_px < b.distance_px; });
  }
  return out;
}

Eigen::Vector2d crossing(const StraightLine& a, const StraightLine& b) {
  Eigen::Matrix2d normals;
  normals << std::cos(a.normal_rad), std::sin(a.normal_rad), std::cos(b.normal_rad), std::sin(b.normal_rad);
  return normals.inverse() * Eigen::Vector2d(a.distance_px, b.distance_px);
}

/// Distinct coordinates in mm: x of the lines along y (first), y of the lines along x (second).
std::array<std::vector<double>, 2> coordinates(std::span<const PaintedCurve> curves) {
  std::array<std::vector<double>, 2> out;
  constexpr double kSameMm = 30;
  for (const PaintedCurve& curve : curves) {
    if (curve.is_arc) continue;
    const bool along_y = std::abs(curve.from.x() - curve.to.x()) < 1;
    if (!along_y && std::abs(curve.from.y() - curve.to.y()) >= 1) continue;
    auto& list = out[along_y ? 0 : 1];
    const double value = along_y ? curve.from.x() : curve.from.y();
    const bool is_new = std::none_of(list.begin(), list.end(),
                                     [&](double other) { return std::abs(other - value) < kSameMm; });
    if (is_new) list.push_back(value);
  }
  for (auto& list : out) std::sort(list.begin(), list.end());
  return out;
}

constexpr double kUnitMm = 3000;

/// Homography through four pairs of points: from field positions in units of kUnitMm to undistorted positions
/// in half image widths.
Eigen::Matrix3d homography(const std::array<Eigen::Vector2d, 4>& places_mm,
                           const std::array<Eigen::Vector2d, 4>& straight_px, double half_px) {
  Eigen::Matrix<double, 8, 8> rows;
  Eigen::Matrix<double, 8, 1> right;
  for (int i = 0; i < 4; ++i) {
    const Eigen::Vector2d p = places_mm[static_cast<std::size_t>(i)] / kUnitMm,
                          q = straight_px[static_cast<std::size_t>(i)] / half_px;
    rows.row(2 * i) << p.x(), p.y(), 1, 0, 0, 0, -q.x() * p.x(), -q.x() * p.y();
    rows.row(2 * i + 1) << 0, 0, 0, p.x(), p.y(), 1, -q.y() * p.x(), -q.y() * p.y();
    right[2 * i] = q.x();
    right[2 * i + 1] = q.y();
  }
  const Eigen::Matrix<double, 8, 1> h = rows.partialPivLu().solve(right);
  Eigen::Matrix3d out;
  out << h[0], h[1], h[2], h[3], h[4], h[5], h[6], h[7], 1;
  return out;
}

std::optional<Eigen::Vector2d> pixel_by(const Eigen::Matrix3d& map, const Straightener& straightener,
                                        const Eigen::Vector2d& place_mm, double farthest) {
  const Eigen::Vector3d h = map * Eigen::Vector3d(place_mm.x() / kUnitMm, place_mm.y() / kUnitMm, 1);
  if (h.z() < 0.2) return std::nullopt;
  const Eigen::Vector2d unit = h.head<2>() / h.z();
  if (unit.squaredNorm() > farthest * farthest) return std::nullopt;
  return straightener.bent(unit * straightener.half_px());
}

struct Guess {
  Eigen::Matrix3d map;
  double score;
};

/// Length of the field's lines on bright stripes, minus kMissing times the length in view that is not on a
/// stripe; in px up to a constant factor. -1: rejected.
double score_of(const Eigen::Matrix3d& map, const Straightener& straightener, const LinePicture& picture,
                std::span<const CurvePoint> points, double px_per_mm) {
  const double radius_px = std::max(4.0, 0.008 * picture.width());
  constexpr double kMissing = 0.6;
  constexpr int kFirstLook = 30, kMinInView = 20;
  double score = 0;
  int in_view = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const CurvePoint& point = points[i * 37 % points.size()];  // spreads the first samples over the field
    const auto pixel = pixel_by(map, straightener, point.place_mm.head<2>(), 2.5);
    if (!pixel) continue;
    const auto x = static_cast<int>(pixel->x() + 0.5), y = static_cast<int>(pixel->y() + 0.5);
    if (!(x >= 5 && y >= 5 && x < picture.width() - 5 && y < picture.height() - 5)) continue;
    const double off = picture.distance_px.row(y)[x];
    score += off < radius_px ? 1 - 0.5 * off / radius_px : -kMissing;
    if (++in_view == kFirstLook && score < 4) return -1;
  }
  return in_view >= kMinInView ? score * px_per_mm : -1;
}

}  // namespace

Proposal propose_cameras(const LinePicture& picture, std::span<const PaintedCurve> curves,
                         const CameraPrior& prior, const std::stop_token& stop) {
  Proposal out;
  const int width = picture.width(), height = picture.height();
  const auto bent_points = stripe_points(picture);
  if (bent_points.size() < 50) {
    out.problem = "There are hardly any white lines in the image.";
    return out;
  }
  Votes votes(width, height);
  std::vector<StripePoint> points(bent_points.size());
  const auto vote = [&](double k1) {
    const Straightener straightener(width, height, prior, k1);
    std::transform(bent_points.begin(), bent_points.end(), points.begin(),
                   [&](const StripePoint& point) { return straightener.straight(point); });
    votes.count(points);
  };
  double k1 = 0, sharpest = -1;
  for (const double one : {0., .03, .06, .09, .13, .17, .23, .29, .38, .46, .58, .72, .87}) {
    if (stop.stop_requested()) return out;
    vote(one);
    if (votes.sharpness() <= sharpest) continue;
    sharpest = votes.sharpness();
    k1 = one;
  }
  vote(k1);
  const Straightener straightener(width, height, prior, k1);
  const auto families = two_families(straight_lines(points, votes, width));
  const auto &a = families[0], &b = families[1];
  if (a.size() < 2 || b.size() < 2) {
    out.problem = "The image does not show two straight white lines along the field and two across it.";
    return out;
  }

  const auto template_lines = coordinates(curves);
  double length_mm = 1, width_mm = 1;
  if (template_lines[0].size() >= 2) length_mm = template_lines[0].back() - template_lines[0].front();
  if (template_lines[1].size() >= 2) width_mm = template_lines[1].back() - template_lines[1].front();
  // If the field looks the same rotated by 180 deg, one of the two rotations is enough.
  const bool looks_alike_turned = same_turned(curves);
  const auto samples = points_along(curves, std::max(80.0, length_mm / 70), 0);
  std::vector<Guess> guesses;
  constexpr double kMinApart = 0.05;                   // share of the image's width
  constexpr double kMinRatio = 0.62, kMaxRatio = 1.6;  // ratio of the scales in the two directions
  const auto try_map = [&](const std::array<Eigen::Vector2d, 4>& corners, double apart_a, double apart_b,
                           bool swapped, double a0, double a1, double b0, double b1) {
    const double scale_a = apart_a / std::abs(a1 - a0), scale_b = apart_b / std::abs(b1 - b0);
    if (scale_a / scale_b < kMinRatio || scale_a / scale_b > kMaxRatio) return;
    const double scale = std::sqrt(scale_a * scale_b);
    if (scale < 0.4 * width / length_mm || scale > 3 * width / width_mm) return;
    const auto place = [&](double at_a, double at_b) {
      return swapped ? Eigen::Vector2d(at_b, at_a) : Eigen::Vector2d(at_a, at_b);
    };
    const Eigen::Matrix3d map = homography({place(a0, b0), place(a1, b0), place(a1, b1), place(a0, b1)},
                                           corners, straightener.half_px());
    const double score = score_of(map, straightener, picture, samples, scale);
    if (score > 0) guesses.push_back({map, score});
  };
  for (std::size_t i = 0; i < a.size(); ++i) {
    for (std::size_t j = i + 1; j < a.size(); ++j) {
      for (std::size_t k = 0; k < b.size(); ++k) {
        for (std::size_t l = k + 1; l < b.size(); ++l) {
          if (stop.stop_requested()) return out;
          const double apart_a = a[j].distance_px - a[i].distance_px,
                       apart_b = b[l].distance_px - b[k].distance_px;
          if (apart_a < kMinApart * width || apart_b < kMinApart * width) continue;
          const std::array corners{crossing(a[i], b[k]), crossing(a[j], b[k]), crossing(a[j], b[l]),
                                   crossing(a[i], b[l])};
          for (const bool swapped : {false, true}) {
            const auto &of_a = template_lines[swapped ? 1 : 0], &of_b = template_lines[swapped ? 0 : 1];
            for (std::size_t p = 0; p < of_a.size(); ++p) {
              for (std::size_t q = p + 1; q < of_a.size(); ++q) {
                for (std::size_t r = 0; r < of_b.size(); ++r) {
                  for (std::size_t s = r + 1; s < of_b.size(); ++s) {
                    // The image's y axis points down, so the field seen from above appears mirrored. Each
                    // order of the lines in `a` therefore allows only one order in `b`.
                    const double b0 = of_b[swapped ? r : s], b1 = of_b[swapped ? s : r];
                    try_map(corners, apart_a, apart_b, swapped, of_a[p], of_a[q], b0, b1);
                    if (!looks_alike_turned)
                      try_map(corners, apart_a, apart_b, swapped, of_a[q], of_a[p], b1, b0);
                  }
                }
              }
            }
          }
        }
      }
    }
  }
  if (guesses.empty()) {
    out.problem = "The white lines in the image do not match a field of this size.";
    return out;
  }
  std::sort(guesses.begin(), guesses.end(), [](const Guess& x, const Guess& y) { return x.score > y.score; });

  constexpr std::size_t kMaxCameras = 6;
  constexpr double kMinShare = 0.6, kSameShare = 0.02, kSigmaPx = 2;
  constexpr double kMaxAxisZ = -0.66;  // tilted by 49 degrees
  for (const Guess& guess : guesses) {
    if (stop.stop_requested()) return out;
    if (out.cameras.size() >= kMaxCameras || guess.score < kMinShare * guesses.front().score) break;
    std::vector<Eigen::Vector2d> pixels, places;
    for (const double x : template_lines[0]) {
      for (const double y : template_lines[1]) {
        const auto pixel = pixel_by(guess.map, straightener, {x, y}, 1.6);
        if (!pixel) continue;
        pixels.push_back(*pixel);
        places.emplace_back(x, y);
      }
    }
    if (pixels.size() < 4) continue;
    CameraPrior held = prior;
    held.k1 = k1;  // rough, like the focal length
    held.k1_sigma = 0.05 + 0.3 * k1;
    const auto fit = camera_of_points(pixels, places, kSigmaPx, width, height, held);
    if (!fit || !is_plausible(fit->camera) || fit->camera.rotation(2, 2) > kMaxAxisZ) continue;
    const bool is_known = std::any_of(out.cameras.begin(), out.cameras.end(), [&](const LensCamera& other) {
      for (const double side : {0.0, 0.4}) {
        const Eigen::Vector2d pixel((0.5 + side) * width, 0.5 * height);
        const auto p = other.unproject(pixel, 0), q = fit->camera.unproject(pixel, 0);
        if (!p || !q || (*p - *q).norm() > kSameShare * length_mm) return false;
      }
      return true;
    });
    if (!is_known) out.cameras.push_back(fit->camera);
  }
  if (out.cameras.empty()) out.problem = "The white lines in the image do not match a field of this size.";
  return out;
}

}  // namespace sslv
