// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "rival.h"
#include "tracking/agreement.h"
#include "tracking/clocks.h"
#include "tracking/smoother.h"
#include "tracking/tracker.h"

namespace sslv::worlds {

/// The field's stack in a world, without its first and last stages: a world's data needs no validation, and
/// nothing is sent.
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
  /// The last image's observations.
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

/// Smoothed tracks with a delay, for recordings; compared with the truth at that time.
class Later {
 public:
  explicit Later(double lag_s) : smoother_(lag_s) {}
  /// Returns the field as it was `lag_s` earlier.
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
