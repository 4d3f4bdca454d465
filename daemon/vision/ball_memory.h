// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>

namespace sslv {

/// Tells things of the hall from balls by what they did: what lies off the field, has never moved and did not
/// come from the field is furniture. A ball that rolls out is none, and nothing on the field is.
class BallMemory {
 public:
  /// To be called before a picture's sightings. Forgets all when time has gone back.
  void begin(double now_s) noexcept;
  struct Known {
    bool as_furniture = false;
    bool at_rest = false;  // it was there in the last pictures, too
  };
  /// Something there looks like a ball, or might.
  Known see(double x_mm, double y_mm, double outside_mm) noexcept;

 private:
  static constexpr std::size_t kMost = 64;
  struct Entry {
    double x_mm, y_mm;            // where it was first
    double from_x_mm, from_y_mm;  // where the track that led there began
    double first_s, seen_s;
    int pictures;
    bool is_ball;  // was on the field, or moved
  };

  std::array<Entry, kMost> entries_;
  std::size_t count_ = 0;
  double now_s_ = 0;
};

}  // namespace sslv
