// SPDX-License-Identifier: Apache-2.0
// The construction of its stage throws.
#include <cstdlib>
#include <stdexcept>

#include <kit/stages.h>

namespace {
class Nothing {
 public:
  struct Params {
    static constexpr auto fields() { return std::tuple{}; }
  };
  Nothing() {
    if (std::getenv("PATH") != nullptr) throw std::runtime_error("no camera for it");
  }
  void process(const Params&, const sslv::BallList&) noexcept {}
};
}  // namespace

SSLV_STAGES(sslv::stage<Nothing>("throws_making", ""))
