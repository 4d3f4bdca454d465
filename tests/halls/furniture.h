// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "hall.h"

namespace sslv::halls {

/// Adds the boards, goals, people, cables, cones and tape of a hall's kind where its camera sees them, and
/// the distractors of its options.
void furnish(Hall& hall);

}  // namespace sslv::halls
