// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"
#include "colors/learn_colors.h"

namespace sslv {

/// The result of learning, without the table itself: problem, notes, robots and balls with their places in
/// the images, and each label's figures.
Json learnt_colors_json(const LearntColors& learnt, const LabelSet& labels_known);

}  // namespace sslv
