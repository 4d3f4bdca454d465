// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <tuple>
#include <vector>

namespace sslv {

/// Tells things of the hall from balls by what they did: what lies off the field, has never moved and did not
/// come from the field is furniture. A ball that rolls out is none, and nothing on the field is. And what has
/// never moved since the memory began, wherever it lies, is no ball when its hue is another than that of the
/// balls that move: those tell what colour balls have in this hall more exactly than any table. What was put
/// down later may be a ball in other light: it is not judged so.
class BallMemory {
 public:
  /// To be called before an image's sightings. Forgets all when time has gone back.
  void begin(double now_s) noexcept;
  struct Known {
    bool as_furniture = false;
    bool at_rest = false;        // it was there in the last images, too
    bool has_other_hue = false;  // than the balls that move; it has never moved itself
  };
  using Color = std::array<double, 3>;  // red, green and blue, in grey levels
  /// Something there looks like a ball, or might. `is_sure`: it may tell what colour balls have.
  Known see(double x_mm, double y_mm, double outside_mm, const Color& color, bool is_sure) noexcept;

  BallMemory() {
    entries_.reserve(kMax);
    moved_.reserve(kMaxMoved);
  }
  template <class Self>
  static auto stored(Self& self) {
    return std::tie(self.entries_, self.begun_s_, self.now_s_, self.moved_, self.moved_count_);
  }

 private:
  static constexpr std::size_t kMax = 64;
  struct Entry {
    double x_mm, y_mm;            // where it was first
    double from_x_mm, from_y_mm;  // where the track that led there began
    double first_s, seen_s;
    int pictures;
    bool is_ball;    // was on the field, or moved
    bool has_moved;  // all along a track
    bool is_sure;
    bool is_counted;  // among those that moved
    bool was_there;   // when the memory began
    bool had_other_hue;
    int colors;          // that `chromaticity` is the mean of
    Color chromaticity;  // of red, green and blue
  };
  /// A ball that was there, and is not any more.
  struct Moved {
    double x_mm, y_mm;
    Color chromaticity;
  };
  static constexpr std::size_t kMaxMoved = 32;

  void count_moved(Entry& entry) noexcept;
  bool has_other_hue(Entry& entry) const noexcept;

  std::vector<Entry> entries_;  // kMax at most
  double begun_s_ = 0, now_s_ = 0;
  std::vector<Moved> moved_;     // kMaxMoved at most, then in a ring
  std::size_t moved_count_ = 0;  // ever
};

}  // namespace sslv
