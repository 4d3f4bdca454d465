// SPDX-License-Identifier: Apache-2.0
#include "calibration/measure_lines.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Dense>

namespace sslv {
namespace {

/// Brightness at every half pixel along a line's normal, averaged along the line.
class Profile {
 public:
  Profile(const LinePicture& picture, const ExpectedLine& at, double reach_px)
      : middle_(static_cast<int>(2 * reach_px) + 2), values_(static_cast<std::size_t>(2 * middle_ + 1), -1) {
    constexpr int kAlong = 3;
    const Eigen::Vector2d along(-at.normal.y(), at.normal.x());
    for (int i = -middle_; i <= middle_; ++i) {
      float sum = 0;
      int count = 0;
      for (int j = -kAlong; j <= kAlong; ++j) {
        const Eigen::Vector2d place = at.pixel + 0.5 * i * at.normal + j * along;
        const float value = value_at(picture.light, place.x(), place.y());
        if (value < 0) continue;
        sum += value;
        ++count;
      }
      if (count >= 2 * kAlong - 1) values_[index(i)] = sum / static_cast<float>(count);
    }
  }

  int reach() const { return middle_; }
  /// Contrast of sample `i` to the samples `side` half pixels away on both sides.
  double stands_out(int i, int side) const {
    if (std::abs(i) + side > middle_) return 0;
    const float here = values_[index(i)], a = values_[index(i - side)], b = values_[index(i + side)];
    if (here < 0 || a < 0 || b < 0) return 0;
    return here - std::max(a, b) - 0.5 * std::abs(a - b);
  }

 private:
  std::size_t index(int i) const { return static_cast<std::size_t>(i + middle_); }
  int middle_;
  std::vector<float> values_;
};

/// Step edge blurred by a Gaussian of sigma 1: -0.5 .. 0.5.
double edge(double x) {
  return 0.5 * std::erf(x * std::numbers::sqrt2 / 2);
}
double bell(double x) {
  return std::exp(-0.5 * x * x) / std::sqrt(2 * std::numbers::pi);
}

}  // namespace

std::optional<ExpectedLine> expect_line(const LensCamera& camera, const PaintedCurve& curve,
                                        const CurvePoint& point, double margin_px) {
  const auto here = camera.project(point.place_mm);
  if (!here || !camera.is_in_picture(*here, margin_px)) return std::nullopt;
  // Points about 10 px before and after, along the line or arc, give the direction and the curvature.
  const double mm_per_px = [&] {
    const auto beside = camera.unproject(*here + Eigen::Vector2d(1, 0), 0);
    return beside ? (*beside - point.place_mm.head<2>()).norm() : 0;
  }();
  if (!(mm_per_px > 0)) return std::nullopt;
  const double along_mm = 10 * mm_per_px;
  const auto pixel = [&](const Eigen::Vector2d& place) { return camera.project({place.x(), place.y(), 0}); };
  const Eigen::Vector2d middle = point.place_mm.head<2>(), side(-point.direction.y(), point.direction.x());
  const bool bends = curve.is_arc;
  const auto before =
      pixel(bends ? curve.point(point.at_mm - along_mm) : middle - along_mm * point.direction);
  const auto after = pixel(bends ? curve.point(point.at_mm + along_mm) : middle + along_mm * point.direction);
  const auto left = pixel(middle - 0.5 * curve.width_mm * side),
             right = pixel(middle + 0.5 * curve.width_mm * side);
  if (!before || !after || !left || !right) return std::nullopt;

  ExpectedLine out;
  out.pixel = *here;
  const Eigen::Vector2d along = (*after - *before).normalized();
  out.normal = {-along.y(), along.x()};
  out.width_px = std::abs((*right - *left).dot(out.normal));
  const double half_px = (*after - *before).norm() / 2;
  out.curvature = 2 * ((*before + *after) / 2 - *here).dot(out.normal) / (half_px * half_px);
  return out;
}

std::vector<Sighting> find_lines(const LinePicture& picture, const LensCamera& camera,
                                 std::span<const PaintedCurve> curves, std::span<const CurvePoint> points,
                                 double window_px) {
  constexpr double kMarginPx = 6, kBeyondPx = 2.2;
  // The profile averages seven pixels, which divides the noise by 2.6.
  const double least = std::max(0.6 * picture.min_line, 3 * picture.noise / 2.6);
  constexpr std::size_t kMaxStripes = 4;  // with more stripes, the right stripe is unknown
  std::vector<Sighting> out;
  for (const CurvePoint& point : points) {
    const auto expected = expect_line(camera, curves[point.curve], point, kMarginPx);
    if (!expected) continue;
    const double beyond_px = expected->width_px / 2 + kBeyondPx;
    const Profile profile(picture, *expected, window_px + beyond_px);
    const int side = std::max(2, static_cast<int>(std::lround(2 * beyond_px)));
    std::size_t stripes = 0;
    double nearest_px = window_px;
    bool found = false;
    double before = profile.stands_out(-profile.reach(), side),
           here = profile.stands_out(1 - profile.reach(), side);
    for (int i = 1 - profile.reach(); i < profile.reach(); ++i) {
      const double after = profile.stands_out(i + 1, side);
      if (here > least && here >= before && here > after) {
        const double bend = before - 2 * here + after;
        const double offset_px = 0.5 * (i + (bend < 0 ? 0.5 * (before - after) / bend : 0));
        if (std::abs(offset_px) <= window_px) ++stripes;
        if (std::abs(offset_px) < std::abs(nearest_px)) {
          nearest_px = offset_px;
          found = true;
        }
      }
      before = here;
      here = after;
    }
    if (!found || stripes > kMaxStripes) continue;
    Sighting& sighting = out.emplace_back();
    sighting.place_mm = point.place_mm;
    sighting.pixel = expected->pixel + nearest_px * expected->normal;
    sighting.normal = expected->normal;
    sighting.curve = point.curve;
  }
  return out;
}

std::optional<MeasuredLine> measure_line(const LinePicture& picture, const ExpectedLine& expected,
                                         double blur_px) {
  struct Pixel {
    double across, along, value;
  };
  constexpr double kBeyondPx = 1.6, kHalfPx = kPatchPx / 2;
  constexpr std::size_t kMinPixels = 30;
  const double half_width = expected.width_px / 2;
  const double reach = half_width + 3 * blur_px + kBeyondPx;
  const double box = kHalfPx + reach;
  const int left = static_cast<int>(std::ceil(expected.pixel.x() - box)),
            right = static_cast<int>(std::floor(expected.pixel.x() + box)),
            top = static_cast<int>(std::ceil(expected.pixel.y() - box)),
            bottom = static_cast<int>(std::floor(expected.pixel.y() + box));
  if (left < 0 || top < 0 || right >= picture.width() || bottom >= picture.height()) return std::nullopt;
  const Eigen::Vector2d& n = expected.normal;
  static thread_local std::vector<Pixel> pixels;
  pixels.clear();
  for (int y = top; y <= bottom; ++y) {
    const float* row = picture.light.row(y);
    for (int x = left; x <= right; ++x) {
      const Eigen::Vector2d from(x - expected.pixel.x(), y - expected.pixel.y());
      const double along = from.dot(Eigen::Vector2d(-n.y(), n.x()));
      const double across = from.dot(n) - 0.5 * expected.curvature * along * along;
      if (std::abs(along) <= kHalfPx && std::abs(across) <= reach) pixels.push_back({across, along, row[x]});
    }
  }
  if (pixels.size() < kMinPixels) return std::nullopt;

  // Parameters: background, its gradients across and along, contrast, offset of the stripe.
  using Vector5 = Eigen::Matrix<double, 5, 1>;
  Vector5 model = Vector5::Zero();
  Eigen::Matrix<double, 5, 5> normal;
  double squares = 0;
  constexpr int kSteps = 7;
  for (int step = 0; step < kSteps; ++step) {
    normal.setZero();
    Vector5 gradient = Vector5::Zero();
    squares = 0;
    for (const Pixel& pixel : pixels) {
      const double in = (pixel.across - model[4] + half_width) / blur_px,
                   out = (pixel.across - model[4] - half_width) / blur_px;
      const double share = edge(in) - edge(out);
      Vector5 columns;
      columns << 1, pixel.across, pixel.along, share, -model[3] * (bell(in) - bell(out)) / blur_px;
      const double off =
          pixel.value - (model[0] + model[1] * pixel.across + model[2] * pixel.along + model[3] * share);
      squares += off * off;
      normal += columns * columns.transpose();
      gradient += off * columns;
    }
    if (step == 0) normal(4, 4) = 1;  // no contrast yet: fits only the other four parameters
    Vector5 change = normal.ldlt().solve(gradient);
    change[4] = std::clamp(change[4], -1.0, 1.0);
    model += change;
    if (!(std::abs(model[4]) < 0.7 * reach)) return std::nullopt;
    if (step > 0 && std::abs(change[4]) < 1e-4) break;
  }
  MeasuredLine out;
  out.offset_px = model[4];
  out.contrast = model[3];
  out.residual = std::sqrt(squares / static_cast<double>(pixels.size() - 5));
  out.sigma_px = picture.noise * std::sqrt(std::max(0.0, normal.inverse()(4, 4)));
  return out;
}

}  // namespace sslv
