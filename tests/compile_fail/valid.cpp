// SPDX-License-Identifier: Apache-2.0
// The control: the correct version of what the other files do wrong. It must compile.
#include "base/snapshot.h"
#include "pipeline/camera_stage.h"

namespace sslv {

struct Valid {
  struct Params {
    static constexpr auto fields() { return std::tuple{}; }
  };
  void process(const Params&, const Scene&, const RunList&, RegionList&, Update<LabelImage>) noexcept {}
};
const StageType kType = stage<Valid>("x", "");

std::shared_ptr<const int> hold(const Snapshot<int>& value) {
  return value.load();
}

Image pass_on(Image&& image) {
  return std::move(image);
}

}  // namespace sslv
