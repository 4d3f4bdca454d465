// SPDX-License-Identifier: Apache-2.0
// Needs a function that does not exist.
#include <cstdlib>

#include <kit/stages.h>

void nobody_has_this();

namespace {
class Nothing {
 public:
  struct Params {
    static constexpr auto fields() { return std::tuple{}; }
  };
  void process(const Params&, const sslv::BallList&) noexcept { nobody_has_this(); }
};
}  // namespace

SSLV_STAGES(sslv::stage<Nothing>("missing_symbol", ""))
