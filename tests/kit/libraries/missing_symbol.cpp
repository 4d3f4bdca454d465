// SPDX-License-Identifier: Apache-2.0
// Needs a function that nobody has.
#include <cstdlib>
#include <stdexcept>

#include <kit/stages.h>

namespace {
class Nothing {
 public:
  struct Params {
    static constexpr auto fields() { return std::tuple{}; }
  };
  void process(const Params&, const sslv::BallList&) noexcept { nobody_has_this(); }
};
}  // namespace

void nobody_has_this();

SSLV_STAGES(sslv::stage<Nothing>("missing_symbol", ""))
