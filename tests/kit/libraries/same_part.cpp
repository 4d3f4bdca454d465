// SPDX-License-Identifier: Apache-2.0
// Reads a part that another library adds.
#include "ball_count.h"

#include <kit/stages.h>

namespace {
class WarnOfBalls {
 public:
  struct Params {
    static constexpr auto fields() { return std::tuple{}; }
  };
  void process(const Params&, const BallCount& count, sslv::StageNotes& notes) noexcept {
    if (count.balls > 1) {
      notes.warn("more than one ball");
    } else {
      notes.clear();
    }
  }
};
}  // namespace

SSLV_STAGES(sslv::stage<WarnOfBalls>("warn_of_balls", "warns of more than one ball"))
