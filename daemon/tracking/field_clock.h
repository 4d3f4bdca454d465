// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace sslv {

/// What time it is where tracks are made: this computer's, or that of a world that is simulated.
class FieldClock {
 public:
  virtual ~FieldClock() = default;
  /// Unix time, as t_capture.
  virtual double now_s() const noexcept = 0;
};

}  // namespace sslv
