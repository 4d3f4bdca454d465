// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"
#include "colors/pixel_figures.h"
#include "vision/label.h"

#include <cstdint>

namespace sslv {

/// Pixels in docs/openapi.json.
Json pixels_json(const PixelBlock& block, const PixelFigures& figures, std::uint32_t frame_number,
                 const LabelSet& labels);

}  // namespace sslv
