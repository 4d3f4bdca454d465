// SPDX-License-Identifier: Apache-2.0
#include "calibration/check_lines.h"

#include "base/statistics.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <optional>

namespace sslv {
namespace {

constexpr std::size_t kMaxPlaces = 200;
constexpr int kMinPlaces = 5;     // sample points per line
constexpr double kClearMm = 120;  // minimum distance from other lines and from ends
constexpr int kSamplesAlong = 3;  // samples along the line, kAlongPx apart
constexpr int kMiddle = kSamplesAlong / 2;
constexpr double kAlongPx = 2, kEndPx = kAlongPx * kMiddle;
constexpr double kMinWindowMm = 60;  // minimum on each side, if the image's edge cuts the window
constexpr double kMinStripe = 4;     // grey levels
constexpr double kMinScatters = 4;   // times the median contrast along the profile
/// A nearer stripe is preferred to the strongest stripe if it has at least this share of the strongest
/// stripe's contrast.
constexpr double kAsGood = 0.6;
/// A line with a smaller offset is at its expected position.
constexpr double kGoodMm = 30;
/// A line is found if this share of its sample points has a stripe: robots and people may cover the other
/// points.
constexpr double kFoundShare = 0.4;

/// Grey level, 0 .. 255. The pixel needs a right and a lower neighbour.
double light_at(const ImageView& image, double x, double y) {
  const int column = static_cast<int>(x), row = static_cast<int>(y);
  const std::uint8_t* at = image.row(row);
  switch (image.format) {
    case PixelFormat::kUyvy: return at[2 * column + 1];
    case PixelFormat::kYuyv: return at[2 * column];
    case PixelFormat::kRgb24:
    case PixelFormat::kBgr24: return (at[3 * column] + 2 * at[3 * column + 1] + at[3 * column + 2]) / 4.0;
    case PixelFormat::kMono8: return at[column];
    case PixelFormat::kBayerRg8:
    case PixelFormat::kBayerGr8:
    case PixelFormat::kBayerGb8:
    case PixelFormat::kBayerBg8: break;
  }
  // Any 2 x 2 quad of a Bayer image contains two green samples.
  const std::uint8_t* below = image.row(row + 1);
  return (at[column] + at[column + 1] + below[column] + below[column + 1]) / 4.0;
}

/// For each sample of the profile, the contrast of a stripe `width` samples wide against the brighter of its
/// two sides.
std::vector<double> stripes(const std::vector<double>& profile, int width) {
  std::vector<double> sums(profile.size() + 1, 0);
  std::partial_sum(profile.begin(), profile.end(), sums.begin() + 1);
  const auto mean = [&](std::size_t begin, int count) {
    return (sums[begin + static_cast<std::size_t>(count)] - sums[begin]) / count;
  };
  const int side = std::max(2, width), gap = 1;  // the gap is blurred: neither line nor ground
  const int reach = width / 2 + gap + side;
  std::vector<double> out(profile.size(), 0);
  for (int i = reach; i + reach + width % 2 < static_cast<int>(profile.size()); ++i) {
    const int begin = i - width / 2;
    const double left = mean(static_cast<std::size_t>(begin - gap - side), side);
    const double right = mean(static_cast<std::size_t>(begin + width + gap), side);
    out[static_cast<std::size_t>(i)] = mean(static_cast<std::size_t>(begin), width) - std::max(left, right);
  }
  return out;
}

/// Offset of the stripe from `middle`, in samples; nothing if no stripe stands out.
std::optional<double> find_stripe(const std::vector<double>& profile, double middle, double width) {
  const int whole = std::max(1, static_cast<int>(std::lround(width)));
  const std::vector<double> stripe = stripes(profile, whole);
  std::vector<double> sizes;
  sizes.reserve(stripe.size());
  for (const double value : stripe) sizes.push_back(std::abs(value));
  const double best = *std::max_element(stripe.begin(), stripe.end());
  if (best < std::max(kMinStripe, kMinScatters * median(std::move(sizes)))) return std::nullopt;
  std::optional<double> nearest;
  for (std::size_t i = 1; i + 1 < stripe.size(); ++i) {
    const double here = stripe[i], before = stripe[i - 1], after = stripe[i + 1];
    if (here < kAsGood * best || here < before || here < after) continue;
    const double bend = before - 2 * here + after;
    // A stripe with an even number of samples has its middle half a sample before i.
    const double at = static_cast<double>(i) + (bend < 0 ? 0.5 * (before - after) / bend : 0) -
                      (whole % 2 == 0 ? 0.5 : 0) - middle;
    if (!nearest || std::abs(at) < std::abs(*nearest)) nearest = at;
  }
  return nearest;
}

/// Expected image of a point of a line. `across` points to the side where offsets are positive.
struct Place {
  Eigen::Vector2d pixel, along, across;  // along, across: unit vectors
  double px_per_mm;                      // across the line
};

std::optional<Place> place_of(const CameraModel& camera, const CurvePoint& point) {
  const auto here = camera.project(point.place_mm);
  if (!here) return std::nullopt;
  const Eigen::Vector3d along(point.direction.x(), point.direction.y(), 0);
  const Eigen::Vector3d across(-point.direction.y(), point.direction.x(), 0);
  constexpr double kStepMm = 5;
  const auto next = camera.project(point.place_mm + kStepMm * along);
  const auto beside = camera.project(point.place_mm + kStepMm * across);
  if (!next || !beside) return std::nullopt;
  Place out{.pixel = *here, .along = (*next - *here).normalized(), .across = {}, .px_per_mm = 0};
  // Perpendicular to the line's image, where the stripe is narrowest.
  out.across = {-out.along.y(), out.along.x()};
  const double px = out.across.dot(*beside - *here);
  if (px < 0) out.across = -out.across;
  out.px_per_mm = std::abs(px) / kStepMm;
  return out.px_per_mm > 0.01 ? std::optional(out) : std::nullopt;
}

}  // namespace

std::vector<LineSeen> check_lines(const ImageView& image, const CameraModel& camera,
                                  std::span<const PaintedCurve> curves, double window_mm) {
  double length_mm = 0;
  for (const PaintedCurve& curve : curves) length_mm += curve.length_mm();
  const auto points = points_along(curves, std::max(100.0, length_mm / kMaxPlaces), kClearMm);
  std::vector<LineSeen> seen(curves.size());
  std::vector<std::vector<double>> offsets_mm(curves.size());
  std::vector<double> profile;
  for (const CurvePoint& point : points) {
    const auto place = place_of(camera, point);
    if (!place) continue;
    const auto is_inside = [&](int across) {
      return std::ranges::all_of(std::array{-kEndPx, kEndPx}, [&](double along) {
        const Eigen::Vector2d at = place->pixel + across * place->across + along * place->along;
        return at.x() >= 1 && at.y() >= 1 && at.x() < image.width - 2 && at.y() < image.height - 2;
      });
    };
    const int wanted = static_cast<int>(std::ceil(window_mm * place->px_per_mm)) + 8;
    const int least = static_cast<int>(std::ceil(kMinWindowMm * place->px_per_mm)) + 8;
    int begin = 0, end = 0;
    while (begin > -wanted && is_inside(begin - 1)) --begin;
    while (end < wanted && is_inside(end + 1)) ++end;
    if (begin > -least || end < least) continue;
    LineSeen& line = seen[point.curve];
    ++line.points;
    profile.clear();
    for (int across = begin; across <= end; ++across) {
      double sum = 0;
      for (int i = 0; i < kSamplesAlong; ++i) {
        const Eigen::Vector2d at =
            place->pixel + across * place->across + (i - kMiddle) * kAlongPx * place->along;
        sum += light_at(image, at.x() + 0.5, at.y() + 0.5);
      }
      profile.push_back(sum / kSamplesAlong);
    }
    if (const auto stripe = find_stripe(profile, -begin, curves[point.curve].width_mm * place->px_per_mm)) {
      ++line.found;
      offsets_mm[point.curve].push_back(*stripe / place->px_per_mm);
    }
  }
  std::vector<LineSeen> out;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    if (seen[i].points < kMinPlaces) continue;
    seen[i].curve = i;
    if (seen[i].found > 0) seen[i].offset_mm = median(std::move(offsets_mm[i]));
    out.push_back(seen[i]);
  }
  return out;
}

LinesVerdict judge_lines(std::span<const LineSeen> lines) {
  LinesVerdict out;
  int places = 0, missing = 0;
  for (const LineSeen& line : lines) {
    ++out.lines;
    places += line.points;
    if (line.found < kFoundShare * line.points) {
      missing += line.points;
      continue;
    }
    if (std::abs(line.offset_mm) < kGoodMm) out.good += line.found;
    if (std::abs(line.offset_mm) > out.worst_mm) {
      out.worst_mm = std::abs(line.offset_mm);
      out.worst = line.curve;
    }
  }
  if (places > 0) out.missing_share = static_cast<double>(missing) / places;
  return out;
}

const FieldPreset* find_better_size(const ImageView& image, const CameraModel& camera, const FieldSize& size,
                                    const LinesVerdict& judged, double window_mm) {
  // With the true size, all lines are found, so a size that shares only some of these lines cannot have more
  // good stripes.
  constexpr double kClearly = 1.3, kMaxMissing = 0.2;
  constexpr int kMinGood = 20;
  for (const FieldPreset& preset : field_presets()) {
    if (preset.size.field_length == size.field_length && preset.size.field_width == size.field_width)
      continue;
    const LinesVerdict other =
        judge_lines(check_lines(image, camera, painted_curves(preset.size), window_mm));
    if (other.good >= kMinGood && other.good > kClearly * judged.good && other.worst_mm < kGoodMm &&
        other.missing_share < kMaxMissing)
      return &preset;
  }
  return nullptr;
}

}  // namespace sslv
