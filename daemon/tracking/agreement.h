// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tracking/camera_agreement.h"
#include "tracking/sightings.h"

#include <optional>
#include <tuple>

namespace sslv {

/// Estimates the differences between cameras and corrects the cameras' measurements accordingly. `learnt` is
/// the state of this stage; it stays in the frame so that other stages can read it.
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
