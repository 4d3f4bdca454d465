// SPDX-License-Identifier: Apache-2.0
// Crashes while being loaded.
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

static const int kCrashed = [] {
  if (std::getenv("PATH") != nullptr) std::abort();
  return 0;
}();

SSLV_STAGES(sslv::stage<Nothing>("crashes_loading", ""))
