// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"
#include "colors/surfaces.h"
#include "vision/label.h"

#include <span>

namespace sslv {

/// Shares of the light by which it may grow or fall before a surface gets a label: docs/openapi.json's
/// "margins".
Json margins_json(std::span<const LabelMargin> margins, const LabelSet& labels);

}  // namespace sslv
