// SPDX-License-Identifier: Apache-2.0
// Hangs while being loaded.
#include <cstdlib>
#include <stdexcept>

#include <kit/stages.h>

namespace {
class Nothing {
 public:
  struct Params {
    static constexpr auto fields() { return std::tuple{}; }
  };
  void process(const Params&, const sslv::BallList&) noexcept {}
};
}  // namespace

static const int kHung = [] {
  const volatile bool goes_on = true;
  while (goes_on) {
  }
  return 0;
}();

SSLV_STAGES(sslv::stage<Nothing>("hangs_loading", ""))
