// SPDX-License-Identifier: Apache-2.0
// expect-error: neither a part of Frame
#include "pipeline/camera_stage.h"

namespace sslv {

struct UnknownPart {
  struct Params {
    static constexpr auto fields() { return std::tuple{}; }
  };
  void process(const Params&, const int&, RegionList&) noexcept {}
};
const StageType kType = stage<UnknownPart>("x", "");

}  // namespace sslv
