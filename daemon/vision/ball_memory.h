// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <tuple>
#include <vector>

namespace sslv {

/// Distinguishes balls from other objects in the hall by their history. An object off the field is furniture
/// if it has never moved and did not come from the field. A ball that rolls off the field is not furniture,
/// nor is any object on the field. Also, an object that has not moved since the memory began, on or off the
/// field, is not a ball if it differs in hue from the balls that have moved, or is clearly less round than
/// they are: balls that have moved show the colour and outline of balls in this hall more exactly than any
/// table or limit. An object that appeared later is not compared, because it may be a ball in different
/// light.
class BallMemory {
 public:
  /// Call before an image's detections. Forgets everything if the time jumps back.
  void begin(double now_s) noexcept;
  /// Call when positions change their meaning, as after a calibration. Keeps what is known of the balls.
  void forget_places() noexcept;

  using Color = std::array<double, 3>;  // red, green and blue, in grey levels
  /// An object that is or may be a ball.
  struct Object {
    double x_mm, y_mm, outside_mm;
    Color color;
    double out_of_round;  // see BallEvidence
    bool is_sure;         // the balls' colour and outline may be learnt from it
  };
  static constexpr std::size_t kNoNumber = ~std::size_t{0};
  struct Known {
    bool as_furniture = false;
    bool at_rest = false;            // was seen at this place in an earlier image, too
    bool unlike_balls = false;       // has another hue or outline than the balls that have moved
    std::size_t number = kNoNumber;  // for over_time(), in the same image; kNoNumber: not remembered
  };
  /// Records an object where one was seen before; empty if there was none. In each image call it for all
  /// objects, and then see_elsewhere() for the others: what is still at its place has not moved to theirs.
  std::optional<Known> see_again(const Object& object) noexcept;
  Known see_elsewhere(const Object& object) noexcept;

  /// An object's confidence from this image and those before, in which it was at the same place, or from
  /// which it has moved on as a ball. For an object that was there when the memory began and has not moved
  /// since, earlier images can only lower it. Call once in each image.
  double over_time(std::size_t number, double confidence) noexcept;

  BallMemory() {
    entries_.reserve(kMax);
    moved_.reserve(kMaxMoved);
  }
  template <class Self>
  static auto stored(Self& self) {
    return std::tie(self.entries_, self.begun_s_, self.before_s_, self.now_s_, self.moved_,
                    self.moved_count_);
  }

 private:
  static constexpr std::size_t kMax = 64;
  struct Entry {
    double x_mm, y_mm;            // position where it was first seen
    double from_x_mm, from_y_mm;  // start of the track that led there
    double first_s, seen_s;
    std::array<double, 2> velocity_mm_s;  // from the position before; 0 without one
    int pictures;                         // number of images with the object at this place
    bool is_ball;                         // was on the field, or has moved
    bool has_moved;                       // has moved far along its track
    bool is_sure;
    bool is_counted;  // is in moved_
    bool was_there;   // was there when the memory began
    bool was_unlike;
    int colors;          // number of colours averaged in `chromaticity`
    Color chromaticity;  // shares of red, green and blue
    int outlines;        // number of images averaged in `out_of_round`
    double out_of_round;
    double rated_s, logit;  // last call of over_time(), and the confidence from then
  };
  /// A ball that has left its place.
  struct Moved {
    double x_mm, y_mm;
    Color chromaticity;
    double out_of_round;
  };
  static constexpr std::size_t kMaxMoved = 32;

  static void average(Entry& entry, const Object& object) noexcept;
  static bool is_at_first_place(const Entry& entry) noexcept;
  void count_moved(Entry& entry) noexcept;
  bool has_other_hue(const Entry& entry) const noexcept;
  bool is_less_round(const Entry& entry) const noexcept;
  bool is_unlike_balls(Entry& entry) const noexcept;

  std::vector<Entry> entries_;                     // at most kMax
  double begun_s_ = 0, before_s_ = 0, now_s_ = 0;  // of the first image, the one before, and this one
  std::vector<Moved> moved_;                       // ring buffer of at most kMaxMoved
  std::size_t moved_count_ = 0;                    // total number of balls added to moved_
};

}  // namespace sslv
