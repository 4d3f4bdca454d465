// SPDX-License-Identifier: Apache-2.0
// expect-error: neither a part of Frame
#include "pipeline/camera_stage.h"

namespace sslv {

struct WritesConstant {
  struct Params {
    static constexpr auto fields() { return std::tuple{}; }
  };
  void process(const Params&, Scene&, RegionList&) noexcept {}
};
const StageType kType = stage<WritesConstant>("x", "");

}  // namespace sslv
