// SPDX-License-Identifier: Apache-2.0
// The construction of its stage hangs.
#include <kit/stages.h>

namespace {
class Nothing {
 public:
  struct Params {
    static constexpr auto fields() { return std::tuple{}; }
  };
  Nothing() {
    const volatile bool goes_on = true;
    while (goes_on) {
    }
  }
  void process(const Params&, const sslv::BallList&) noexcept {}
};
}  // namespace

SSLV_STAGES(sslv::stage<Nothing>("hangs_making", ""))
