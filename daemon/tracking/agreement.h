// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tracking/camera_agreement.h"
#include "tracking/sightings.h"

#include <optional>
#include <tuple>

namespace sslv {

/// Learns what cameras do not agree on, and takes it off what they saw. `learnt` is what it knows, which
/// stays in the frame: it is its own, for others to look at.
class Agreement {
 public:
  struct Params {
    static constexpr auto fields() { return std::tuple{}; }
  };
  void process(const Params&, const CameraSightings& seen, const ImageTime& time, Observations& out,
               CameraAgreement& learnt) noexcept;

 private:
  std::optional<double> newest_s_;
};

}  // namespace sslv
