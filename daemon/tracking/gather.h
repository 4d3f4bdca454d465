// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/params.h"
#include "geometry/field.h"
#include "tracking/field_clock.h"
#include "tracking/sightings.h"

#include <array>
#include <cstdint>
#include <map>
#include <tuple>

namespace sslv {

/// Numbers of dropped images and detections since the service started, and the reason for the last drop.
struct LeftOut {
  std::uint64_t images_off_time = 0;     // capture time too far from this computer's clock
  std::uint64_t images_of_too_many = 0;  // images from cameras beyond the maximum number
  std::uint64_t sightings = 0;           // invalid, far off the field, or with an id that occurs twice
  /// Why the last image was dropped.
  enum class Why : std::uint8_t { kNothing, kTime, kTooMany };
  friend constexpr Why largest(Why) { return Why::kTooMany; }
  // The last dropped image:
  Why why = Why::kNothing;
  int camera = -1;
  double t_s = 0;
};

/// Accepts the measurements of a camera if they match the field and this computer's clock. Adds covariances
/// if the camera gives none.
class Gather {
 public:
  /// Parameters of the stage.
  struct Params {
    double max_time_off_s = 0.5;
    double reach_mm = 2000;
    double robot_sigma_mm = 1, orientation_sigma_deg = 0.5, ball_sigma_mm = 1;
    static constexpr auto fields() {
      using P = Params;
      return std::tuple{
          number("max_time_off_s", &P::max_time_off_s, 0.02, 10.0, "s",
                 "images that are older than this, or this far in the future, are ignored"),
          number("reach_mm", &P::reach_mm, 0.0, 100'000.0, "mm",
                 "maximum distance of a robot or a ball beyond the lines"),
          number("robot_sigma_mm", &P::robot_sigma_mm, 0.01, 100.0, "mm",
                 "uncertainty (sigma) of robot positions from other computers, which send none"),
          number("orientation_sigma_deg", &P::orientation_sigma_deg, 0.01, 90.0, "deg",
                 "uncertainty (sigma) of robot orientations from other computers"),
          number("ball_sigma_mm", &P::ball_sigma_mm, 0.01, 100.0, "mm",
                 "uncertainty (sigma) of ball positions from other computers"),
      };
    }
  };
  /// Copies valid measurements of `arrived` to `out` and counts the others in `left_out`.
  void process(const Params& params, const FieldSize& field, const FieldClock& clock,
               const ArrivedSightings& arrived, CameraSightings& out, LeftOut& left_out) noexcept;

 private:
  bool is_taken(const Params& params, const ArrivedSightings& arrived, double now_s, LeftOut& left_out);

  struct Heard {
    double t_s;
    bool is_of_other_computer;
  };
  std::map<int, Heard> heard_;  // by camera
};

}  // namespace sslv
