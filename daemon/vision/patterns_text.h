// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vision/patterns.h"

#include <string>

namespace sslv {

/// JSON text from which parse_patterns() makes the same table.
std::string patterns_text(const PatternTable& table, const LabelSet& labels = LabelSet::built_in());

}  // namespace sslv
