// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"
#include "geometry/field.h"
#include "geometry/limits.h"
#include "tracking/camera_agreement.h"

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

namespace sslv {

/// Disagreement of the cameras, in one block of memory that can be copied as bytes.
struct AgreementNow {
  struct Camera {
    int id;
    double time_offset_s;
    double error_mm;  // RMS correction of its positions where other cameras see the same places
    double evenness;  // see Evenness::share()
  };
  struct Height {
    int team, id;
    double more_mm, sigma_mm;
  };
  struct Difference {
    int camera, other;
    float x_mm, y_mm, off_x_mm, off_y_mm, samples;
    double t_s;
  };
  static constexpr std::size_t kMaxCameras = limits::kMaxCameras, kMaxRobots = limits::kMaxRobots,
                               kMaxDifferences = 1024;

  double t_s = 0;
  std::uint32_t camera_count = 0, height_count = 0, difference_count = 0;
  std::array<Camera, kMaxCameras> cameras{};
  std::array<Height, kMaxRobots> heights{};
  std::array<Difference, kMaxDifferences> differences{};
};

/// Precision of the JSON.
inline double to_hundredths(double value) {
  return std::round(value * 100) / 100;
}

/// Writes the current state of `agreement` to `out`. Also drops old differences from `agreement`.
void write_now(CameraAgreement& agreement, double now_s, AgreementNow& out) noexcept;

/// Difference of two cameras where both see robots.
struct CameraPairNow {
  int camera, other;
  double off_mm;             // median over the parts of the field
  std::size_t parts;         // number of parts that were compared
  Eigen::Vector2d worst_mm;  // centre of the part in which the cameras differ most
};
/// Returns the pairs of cameras that share enough of the field. In each pair, `camera` is the one with the
/// larger sum of differences over all its pairs.
std::vector<CameraPairNow> pairs_of(const AgreementNow& agreement);

/// FieldAgreement in docs/openapi.json, without `trends`.
Json to_json(const AgreementNow& now);

}  // namespace sslv
