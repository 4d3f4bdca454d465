// SPDX-License-Identifier: Apache-2.0
// The library gpu_threshold.so, which the service loads if the package ssl-visiond-gpu is installed.
#include "gpu/gpu_threshold_stage.h"
#include "kit/stages.h"

SSLV_STAGES(sslv::stage<sslv::GpuThresholdStage>(
    "gpu_threshold", "labels pixels by colour like threshold, on the GPU if it is faster"))
