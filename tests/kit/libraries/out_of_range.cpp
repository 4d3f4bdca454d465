// SPDX-License-Identifier: Apache-2.0
// Writes beyond the end of a list: AddressSanitizer must detect it in a library of its own (installed.sh).
#include <vector>

#include <kit/stages.h>

namespace {
class WriteBehind {
 public:
  struct Params {
    static constexpr auto fields() { return std::tuple{}; }
  };
  void process(const Params&, const sslv::BallList& balls) noexcept {
    std::vector<int> list(balls.balls.size() + 1);
    volatile int* const behind = list.data() + list.size();
    *behind = 1;
  }
};
}  // namespace

SSLV_STAGES(sslv::stage<WriteBehind>("write_behind", "writes behind the end of a list"))
