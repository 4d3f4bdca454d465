// SPDX-License-Identifier: Apache-2.0
// The stage's name is not allowed in settings.
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

SSLV_STAGES(sslv::stage<Nothing>("Bad Name", ""))
