// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/params.h"

namespace sslv {

/// Deceleration of the ball, published for the teams' predictions. Defaults: RoboCup 2026. Combines
/// SSL_BallModelStraightTwoPhase and SSL_BallModelChipFixedLoss in one flat struct.
struct BallModels {
  double acc_slide = -3.40;
  double acc_roll = -0.45;
  double k_switch = 0.64;
  double damping_xy_first_hop = 0.55;
  double damping_xy_other_hops = 0.88;
  double damping_z = 0.54;

  static constexpr auto fields() {
    using B = BallModels;
    return std::tuple{
        number("acc_slide", &B::acc_slide, -100.0, 0.0, "m/s2", "acceleration of a sliding ball"),
        number("acc_roll", &B::acc_roll, -100.0, 0.0, "m/s2", "acceleration of a rolling ball"),
        number("k_switch", &B::k_switch, 0.0, 1.0, "",
               "fraction of the kick's speed at which the ball starts to roll"),
        number("damping_xy_first_hop", &B::damping_xy_first_hop, 0.0, 1.0, "",
               "speed kept along the floor, first hop"),
        number("damping_xy_other_hops", &B::damping_xy_other_hops, 0.0, 1.0, "",
               "speed kept along the floor, later hops"),
        number("damping_z", &B::damping_z, 0.0, 1.0, "", "upward speed kept at each hop"),
    };
  }
};

}  // namespace sslv
