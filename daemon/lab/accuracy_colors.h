// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "colors/learn_colors.h"
#include "lab/accuracy_trial.h"
#include "pipeline/camera_pipeline.h"
#include "vision/lut_from_samples.h"

#include <vector>

namespace sslv {

/// Learns a table without clicks; its `problem` is set if nothing was learnt.
LearntColors learn(const Trial& trial, const CameraContext& context);

/// Returns the colours at an admin's simulated clicks, spread over the images: eight places for each label.
std::vector<ColorSample> click(const Trial& trial, const CameraContext& context);

}  // namespace sslv
