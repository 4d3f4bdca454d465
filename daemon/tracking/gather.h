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

/// What was left out of images, and why. Counts since the service began.
struct LeftOut {
  std::uint64_t images_off_time = 0;     // whose time is far from this computer's
  std::uint64_t images_of_too_many = 0;  // cameras
  std::uint64_t sightings = 0;  // without sense, far off the field, or of an id that was seen already
  // The last image that was left out.
  enum class Why : std::uint8_t { kNothing, kTime, kTooMany };
  friend constexpr Why largest(Why) { return Why::kTooMany; }
  Why why = Why::kNothing;
  int camera = -1;
  double t_s = 0;
};

/// Takes what a camera saw into the field where it fits the field and this computer's clock, and says how
/// certain it is where the camera does not.
class Gather {
 public:
  struct Params {
    double max_time_off_s = 0.5;
    double reach_mm = 2000;
    double robot_sigma_mm = 1, orientation_sigma_deg = 0.5, ball_sigma_mm = 1;
    static constexpr auto fields() {
      using P = Params;
      return std::tuple{
          number("max_time_off_s", &P::max_time_off_s, 0.02, 10.0, "s",
                 "an image that is older than this, or so far in the future, is left out"),
          number("reach_mm", &P::reach_mm, 0.0, 100'000.0, "mm",
                 "how far behind the lines a robot or a ball may be"),
          number("robot_sigma_mm", &P::robot_sigma_mm, 0.01, 100.0, "mm",
                 "how sure a robot's place is that another computer sends, which does not say it"),
          number("orientation_sigma_deg", &P::orientation_sigma_deg, 0.01, 90.0, "deg",
                 "how sure its orientation is"),
          number("ball_sigma_mm", &P::ball_sigma_mm, 0.01, 100.0, "mm",
                 "how sure a ball's place is that another computer sends"),
      };
    }
  };
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
