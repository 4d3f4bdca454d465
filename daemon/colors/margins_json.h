// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"
#include "colors/surfaces.h"
#include "vision/label.h"

#include <span>

namespace sslv {

/// Relative changes of the light, up and down, at which a surface gets a label: "margins" in
/// docs/openapi.json.
Json margins_json(std::span<const LabelMargin> margins, const LabelSet& labels);

}  // namespace sslv
