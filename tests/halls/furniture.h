// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "hall.h"

namespace sslv::halls {

/// Puts boards, goals, people, cables, cones and tape into a hall as its kind has them, where its camera sees
/// them; and distractors as its options say.
void furnish(Hall& hall);

}  // namespace sslv::halls
