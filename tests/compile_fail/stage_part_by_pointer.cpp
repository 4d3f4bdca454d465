// SPDX-License-Identifier: Apache-2.0
// expect-error: neither a part of Frame
#include "pipeline/camera_stage.h"

namespace sslv {

struct PartByPointer {
  struct Params {
    static constexpr auto fields() { return std::tuple{}; }
  };
  void process(const Params&, const RunList&, RegionList*) noexcept {}
};
const StageType kType = stage<PartByPointer>("x", "");

}  // namespace sslv
