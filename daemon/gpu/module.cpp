// SPDX-License-Identifier: Apache-2.0
// The stages of the library gpu_threshold.so, which the service loads where it is installed.
#include "gpu/gpu_threshold_stage.h"
#include "pipeline/camera_stage.h"

#include <vector>

namespace sslv {

/// The only name that the library shows.
[[gnu::visibility("default")]] std::vector<StageType> gpu_stages();

std::vector<StageType> gpu_stages() {
  return {
      stage<GpuThresholdStage>("gpu_threshold",
                               "labels pixels by colour in the place of threshold, on a GPU where that is "
                               "faster than the CPU")};
}

}  // namespace sslv
