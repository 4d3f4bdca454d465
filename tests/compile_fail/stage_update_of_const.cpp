// SPDX-License-Identifier: Apache-2.0
// expect-error: neither a part of Frame
#include "pipeline/camera_stage.h"

namespace sslv {

struct UpdateOfConst {
  struct Params {
    static constexpr auto fields() { return std::tuple{}; }
  };
  void process(const Params&, Update<const RegionList>) noexcept {}
};
const StageType kType = stage<UpdateOfConst>("x", "");

}  // namespace sslv
