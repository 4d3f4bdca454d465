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

/// What cameras do not agree on, in one piece of memory.
struct AgreementNow {
  struct Camera {
    int id;
    double time_offset_s;
    double error_mm;  // that is taken off what it sees: rms over the places that it shares with others
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

/// As JSON has it; nobody reads more.
inline double to_hundredths(double value) {
  return std::round(value * 100) / 100;
}

/// What was seen long ago is forgotten.
void write_now(CameraAgreement& agreement, double now_s, AgreementNow& out) noexcept;

/// What two cameras differ by, where both see robots.
struct CameraPairNow {
  int camera, other;
  double off_mm;             // median over the parts of the field
  std::size_t parts;         // so many
  Eigen::Vector2d worst_mm;  // the middle of the one where they differ most
};
/// Of each two that share enough of the field.
std::vector<CameraPairNow> pairs_of(const AgreementNow& agreement);

/// As docs/openapi.json's FieldAgreement, without what was before.
Json to_json(const AgreementNow& now);

}  // namespace sslv
