// SPDX-License-Identifier: Apache-2.0
// A part with the name of ball_count.h's but another layout.
#include <string_view>

#include <kit/stages.h>

namespace {
struct BallCount {
  static constexpr std::string_view kPartName = "ball_count";
  double balls = 0;
  void clear() { balls = 0; }
};
class ReadOther {
 public:
  struct Params {
    static constexpr auto fields() { return std::tuple{}; }
  };
  void process(const Params&, const BallCount&) noexcept {}
};
}  // namespace

SSLV_STAGES(sslv::stage<ReadOther>("read_other", ""))
