// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "rival.h"
#include "tracking/agreement.h"
#include "tracking/clocks.h"
#include "tracking/smoother.h"
#include "tracking/tracker.h"

namespace sslv::worlds {

/// The stages of the field's stack in a world, but for the first, which checks what a world makes right, and
/// the last, which sends.
class Ours final : public Rival {
 public:
  void add(const WorldImage& image) override {
    clocks_.process({}, image.sightings, time_);
    agreement_.process({}, image.sightings, time_, observations_, learnt_);
    tracker_.add(observations_);
  }
  std::optional<TrackedRobot> robot(const RobotName& name, double t_s) override {
    return tracker_.robot(name, t_s);
  }
  std::optional<TrackedBall> ball(double t_s) override { return tracker_.ball(t_s); }
  std::vector<TrackedBall> balls(double t_s) override {
    tracker_.at(t_s, tracked_);
    return tracked_.balls;
  }
  std::optional<TrackedKick> kick() const override { return tracker_.kick(); }
  const CameraAgreement& agreement() const { return learnt_; }
  const Tracker& tracker() const { return tracker_; }
  /// Of the last image.
  const Observations& observations() const { return observations_; }

 private:
  Clocks clocks_;
  Agreement agreement_;
  Tracker tracker_;
  TrackedField tracked_;
  ImageTime time_;
  Observations observations_;
  CameraAgreement learnt_;
};

/// What is known of a world with a delay, for recordings: it is compared with the truth of that time.
class Later {
 public:
  explicit Later(double lag_s) : smoother_(lag_s) {}
  /// Gives the field as it was that long before.
  const TrackedField& add(const WorldImage& image) {
    ours_.add(image);
    smoother_.add(ours_.observations(), image.arrival_s);
    smoother_.at(field_);
    return field_;
  }

 private:
  Ours ours_;
  Smoother smoother_;
  TrackedField field_;
};

}  // namespace sslv::worlds
