// SPDX-License-Identifier: Apache-2.0
// Another version of counting.cpp, whose stage has other parameters.
#include "ball_count.h"

#include <kit/stages.h>

namespace {
class CountBalls {
 public:
  struct Params {
    int at_most = 50;
    static constexpr auto fields() {
      return std::tuple{sslv::number("at_most", &Params::at_most, 0, 100, "balls", "more are none")};
    }
  };
  void process(const Params& params, const sslv::BallList& balls, BallCount& count) noexcept {
    const auto found = static_cast<int>(balls.balls.size());
    count.balls = found > params.at_most ? 0 : found;
  }
};
}  // namespace

SSLV_STAGES(sslv::stage<CountBalls>("count_balls", "counts the balls"))
