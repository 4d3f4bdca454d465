// SPDX-License-Identifier: Apache-2.0
// expect-error: process.. must be noexcept
#include "pipeline/camera_stage.h"

namespace sslv {

struct MayThrow {
  struct Params {
    static constexpr auto fields() { return std::tuple{}; }
  };
  void process(const Params&, const RunList&, RegionList&) {}
};
const StageType kType = stage<MayThrow>("x", "");

}  // namespace sslv
