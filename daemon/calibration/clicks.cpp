// SPDX-License-Identifier: Apache-2.0
#include "calibration/clicks.h"

#include "base/error.h"

#include <algorithm>

#include <fmt/format.h>

namespace sslv {
namespace {

constexpr double kFarClickPx = 16;  // lower limit, for small images

const NamedPoint& point_named(const std::string& name, std::size_t click,
                              std::span<const NamedPoint> points) {
  const auto found =
      std::find_if(points.begin(), points.end(), [&](const NamedPoint& point) { return point.name == name; });
  if (found != points.end()) return *found;
  std::string names;
  for (const NamedPoint& point : points) names += (names.empty() ? "\"" : ", \"") + point.name + "\"";
  throw SettingsError(fmt::format("/points/{}/name: \"{}\" is not a point of this field; expected one of {}",
                                  click, name, names));
}

}  // namespace

Clicks read_clicks(std::span<const ClickedPoint> clicked, std::span<const NamedPoint> points) {
  constexpr std::size_t kMin = 3;
  if (!clicked.empty() && clicked.size() < kMin) {
    throw SettingsError(
        fmt::format("/points: {} are too few; expected three or more corners or crossings, or none at all",
                    clicked.size()));
  }
  Clicks out;
  out.names_known = !clicked.empty();
  for (std::size_t i = 0; i < clicked.size(); ++i) {
    const ClickedPoint& click = clicked[i];
    out.pixels.push_back(click.pixel);
    if (click.place_mm) {
      out.places.push_back({click.name, *click.place_mm});
    } else if (!click.name.empty()) {
      out.places.push_back(point_named(click.name, i, points));
    } else {
      out.names_known = false;
    }
  }
  if (!out.names_known) out.places.assign(points.begin(), points.end());
  return out;
}

Clicks::Meaning Clicks::meaning(std::size_t pixel, const LensCamera& camera) const {
  Meaning out;
  for (const NamedPoint& place : places) {
    const auto seen = camera.project({place.place_mm.x(), place.place_mm.y(), 0});
    const double off_px = seen ? (*seen - pixels[pixel]).norm() : out.off_px;
    if (off_px < out.off_px) {
      out.place = &place;
      out.off_px = off_px;
    }
  }
  out.is_far = out.off_px > far_px(camera);
  return out;
}

double Clicks::far_px(const LensCamera& camera) {
  return std::max(kFarClickPx, kFarClickShare * camera.width);
}

bool Clicks::has_far_one(const LensCamera& camera) const {
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    if (meaning(i, camera).is_far) return true;
  }
  return false;
}

}  // namespace sslv
