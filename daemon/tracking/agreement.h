// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tracking/camera_agreement.h"
#include "tracking/sightings.h"

#include <optional>
#include <tuple>

namespace sslv {

/// Learns what cameras do not agree on, and takes it off what they saw. `learnt` is what it knows of robots,
/// which stays in the frame: it is its own, for others to look at. On the floor, where balls are,
/// calibrations err otherwise than at the robots' height: that is learnt from balls that two cameras see.
class Agreement {
 public:
  struct Params {
    static constexpr auto fields() { return std::tuple{}; }
  };
  void process(const Params&, const CameraSightings& seen, const ImageTime& time, Observations& out,
               CameraAgreement& learnt) noexcept;

 private:
  /// A ball that flies surprises for as long as it does.
  static constexpr CameraAgreement::Options kFloor{
      .error_mm = 1, .learns_clocks = false, .learns_heights = false, .bumped = 600};
  std::optional<double> newest_s_;
  CameraAgreement floor_{kFloor};
};

}  // namespace sslv
