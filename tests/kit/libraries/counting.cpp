// SPDX-License-Identifier: Apache-2.0
// A correct library: camera stages that pass on a part of their own, and a field stage.
#include "ball_count.h"

#include <array>
#include <cstdio>
#include <stdexcept>

#include <kit/stages.h>

namespace {

class CountBalls {
 public:
  struct Params {
    int at_least = 0;
    static constexpr auto fields() {
      return std::tuple{sslv::number("at_least", &Params::at_least, 0, 100, "balls", "fewer are none")};
    }
  };
  void process(const Params& params, const sslv::BallList& balls, BallCount& count) noexcept {
    const auto found = static_cast<int>(balls.balls.size());
    count.balls = found < params.at_least ? 0 : found;
    for (const sslv::Ball& ball : balls.balls) count.places_mm.push_back(ball.x_mm);
  }
};

class TellBalls {
 public:
  struct Params {
    static constexpr auto fields() { return std::tuple{}; }
  };
  void process(const Params&, const BallCount& count, sslv::StageNotes& notes) noexcept {
    std::array<char, 80> text{};
    std::snprintf(text.data(), text.size(), "%d balls, %zu places", count.balls, count.places_mm.size());
    notes.say(text.data());
  }
};

class CountTracks {
 public:
  struct Params {
    static constexpr auto fields() { return std::tuple{}; }
  };
  void process(const Params&, const sslv::TrackedField& tracked, sslv::StageNotes& notes) noexcept {
    std::array<char, 80> text{};
    std::snprintf(text.data(), text.size(), "%zu robots tracked", tracked.robots.size());
    notes.say(text.data());
  }
};

}  // namespace

SSLV_STAGES(sslv::stage<CountBalls>("count_balls", "counts the balls"),
            sslv::stage<TellBalls>("tell_balls", "says how many balls were counted"),
            sslv::field_stage<CountTracks>("count_tracks", "says how many robots are tracked"))
