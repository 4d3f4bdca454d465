// SPDX-License-Identifier: Apache-2.0
// expect-error: a stage needs a nested struct Params
#include "pipeline/camera_stage.h"

namespace sslv {

struct NoParams {
  void process(const RunList&, RegionList&) noexcept {}
};
const StageType kType = stage<NoParams>("x", "");

}  // namespace sslv
