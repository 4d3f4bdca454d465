// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "rival.h"
#include "tracking/tracker.h"

namespace sslv::worlds {

/// Our tracker in a world.
class Ours final : public Rival {
 public:
  explicit Ours(const World& world) {
    for (std::size_t i = 0; i < world.cameras().size(); ++i)
      tracker_.set_camera(static_cast<int>(i), world.cameras()[i].center_mm, World::kRobotHeightMm);
  }
  void add(const WorldImage& image) override { tracker_.add(image.sightings); }
  std::optional<TrackedRobot> robot(const RobotName& name, double t_s) override {
    return tracker_.robot(name, t_s);
  }
  std::optional<TrackedBall> ball(double t_s) override { return tracker_.ball(t_s); }
  std::optional<TrackedKick> kick() const override { return tracker_.kick(); }
  const Tracker& tracker() const { return tracker_; }

 private:
  Tracker tracker_;
};

}  // namespace sslv::worlds
