// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "colors/learn_colors.h"
#include "ctl/accuracy_trial.h"
#include "pipeline/camera_pipeline.h"
#include "vision/lut_from_samples.h"

#include <vector>

namespace sslv {

/// A table without a click; with a problem when nothing was learnt.
LearntColors learn(const Trial& trial, const CameraContext& context);

/// What an admin clicks at, spread over the image: eight places of each label.
std::vector<ColorSample> click(const Trial& trial, const CameraContext& context);

}  // namespace sslv
