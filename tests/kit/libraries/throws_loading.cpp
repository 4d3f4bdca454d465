// SPDX-License-Identifier: Apache-2.0
// Throws while being loaded.
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

static const int kThrown = [] {
  if (std::getenv("PATH") != nullptr) throw std::runtime_error("no licence");
  return 0;
}();

SSLV_STAGES(sslv::stage<Nothing>("throws_loading", ""))
