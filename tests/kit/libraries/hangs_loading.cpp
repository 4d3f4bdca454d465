// SPDX-License-Identifier: Apache-2.0
// Hangs while being loaded.
#include <tuple>

#include <kit/stages.h>
#include <unistd.h>

namespace {
class Nothing {
 public:
  struct Params {
    static constexpr auto fields() { return std::tuple{}; }
  };
  void process(const Params&, const sslv::BallList&) noexcept {}
};
}  // namespace

static const int kHung = []() -> int {
  for (;;) pause();  // uses no CPU time, which other tests need
}();

SSLV_STAGES(sslv::stage<Nothing>("hangs_loading", ""))
