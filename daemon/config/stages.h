// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "pipeline/camera_stage.h"
#include "pipeline/field_stage.h"

#include <span>
#include <string>
#include <vector>

namespace sslv {

/// Every stage a stack may name.
std::span<const StageType> stage_table();

/// The stack of a camera that does not say otherwise.
std::vector<std::string> default_stack();

/// Every stage that the field's stack may name.
std::span<const FieldStageType> field_stage_table();

/// The field's stack unless the settings say otherwise.
std::vector<std::string> default_field_stack();

}  // namespace sslv
