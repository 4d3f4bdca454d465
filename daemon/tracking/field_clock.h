// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace sslv {

/// Current time of the tracker: the time of this computer or of a simulated world.
class FieldClock {
 public:
  virtual ~FieldClock() = default;
  /// Unix time (s), like t_capture.
  virtual double now_s() const noexcept = 0;
};

}  // namespace sslv
