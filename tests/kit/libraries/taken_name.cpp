// SPDX-License-Identifier: Apache-2.0
// Its stage has the name of a built-in stage.
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

SSLV_STAGES(sslv::stage<Nothing>("threshold", ""))
