// SPDX-License-Identifier: Apache-2.0
#include "calibration/publish.h"

#include "base/statistics.h"
#include "calibration/fit_camera.h"

#include <algorithm>
#include <limits>
#include <vector>

#include <Eigen/Geometry>

namespace sslv {

namespace {

/// Places in the image on the floor and at the robots' tops, within `half_mm` of the field's middle.
std::vector<Sighting> places_on_grid(const LensCamera& camera, const Eigen::Vector2d& half_mm) {
  constexpr int kColumns = 32, kRows = 24;
  constexpr double kPlanesMm[] = {0, kRobotTopsMm};
  std::vector<Sighting> sightings;
  for (int j = 0; j < kRows; ++j) {
    for (int i = 0; i < kColumns; ++i) {
      const Eigen::Vector2d pixel(i * (camera.width - 1.0) / (kColumns - 1),
                                  j * (camera.height - 1.0) / (kRows - 1));
      for (const double height_mm : kPlanesMm) {
        const auto place = camera.unproject(pixel, height_mm);
        if (!place || (place->array().abs() > half_mm.array()).any()) continue;
        Sighting& sighting = sightings.emplace_back();
        sighting.place_mm = {place->x(), place->y(), height_mm};
        sighting.pixel = pixel;
      }
    }
  }
  return sightings;
}

}  // namespace

Published publish(const LensCamera& camera, const std::optional<CameraCalibration>& previous,
                  const std::optional<FieldSize>& field) {
  LensCamera wire = camera;
  Published out;
  if (camera.k2 != 0) {
    constexpr double kAroundMm = 1000;
    constexpr std::size_t kFewest = 100;
    std::vector<Sighting> sightings;
    if (field)
      sightings = places_on_grid(
          camera, {field->field_length / 2.0 + kAroundMm, field->field_width / 2.0 + kAroundMm});
    if (sightings.size() < kFewest)
      sightings = places_on_grid(camera, Eigen::Vector2d::Constant(std::numeric_limits<double>::infinity()));
    CameraPrior anything;
    anything.focal_px = camera.focal_px;
    anything.focal_share = 10;
    anything.center_x = camera.center_x;
    anything.center_y = camera.center_y;
    anything.center_sigma_px = 1e4;
    anything.k1 = camera.k1;
    anything.k1_sigma = 10;
    wire.k2 = 0;
    wire = fit_camera(wire, sightings, anything).camera;
    wire.k2 = 0;
    Rms off;
    for (const Sighting& sighting : sightings) {
      if (sighting.place_mm.z() != 0) continue;
      const auto place = wire.unproject(sighting.pixel, 0);
      if (!place) continue;
      const double off_mm = (*place - sighting.place_mm.head<2>()).norm();
      off.add(off_mm);
      out.worst_mm = std::max(out.worst_mm, off_mm);
    }
    out.rms_mm = off.value();
  }
  Eigen::Quaterniond q(wire.rotation);
  q.normalize();
  if (previous) {
    const Eigen::Quaterniond old(previous->q3, previous->q0, previous->q1, previous->q2);
    if (old.dot(q) < 0) q.coeffs() *= -1;
  }
  const Eigen::Vector3d t = -wire.rotation * wire.position_mm;
  out.calibration = {wire.focal_px, wire.center_x, wire.center_y, wire.k1, q.x(),      q.y(),      q.z(),
                     q.w(),         t.x(),         t.y(),         t.z(),   wire.width, wire.height};
  return out;
}

}  // namespace sslv
