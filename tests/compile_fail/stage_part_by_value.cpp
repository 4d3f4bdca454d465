// SPDX-License-Identifier: Apache-2.0
// expect-error: neither a part of Frame
#include "pipeline/camera_stage.h"

namespace sslv {

struct PartByValue {
  struct Params {
    static constexpr auto fields() { return std::tuple{}; }
  };
  void process(const Params&, RunList, RegionList&) noexcept {}
};
const StageType kType = stage<PartByValue>("x", "");

}  // namespace sslv
