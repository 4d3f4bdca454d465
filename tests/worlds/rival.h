// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tracking/tracks.h"
#include "world.h"

#include <optional>
#include <vector>

namespace sslv::worlds {

/// A tracker under test in a world: ours, or the league's usual one.
class Rival {
 public:
  virtual ~Rival() = default;
  virtual void add(const WorldImage& image) = 0;
  virtual std::optional<TrackedRobot> robot(const RobotName& name, double t_s) = 0;
  virtual std::optional<TrackedBall> ball(double t_s) = 0;
  /// All tracks that it considers balls.
  virtual std::vector<TrackedBall> balls(double t_s) {
    const auto one = ball(t_s);
    return one ? std::vector{*one} : std::vector<TrackedBall>{};
  }
  virtual std::optional<TrackedKick> kick() const = 0;
};

}  // namespace sslv::worlds
