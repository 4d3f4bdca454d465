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

/// Appends rows to the two tables: stages that come from elsewhere. Once, before anything else uses a table:
/// settings, schema, pipelines and totals go by a row's place, so a table does not change while it is used.
/// Throws SettingsError for a name that is there already, and std::logic_error when a table was used or this
/// was called before; nothing has changed then.
void add_stages(std::vector<StageType> camera, std::vector<FieldStageType> field);

/// The stack of a camera that does not say otherwise.
std::vector<std::string> default_stack();

/// Every stage that the field's stack may name.
std::span<const FieldStageType> field_stage_table();

/// The field's stack unless the settings say otherwise.
std::vector<std::string> default_field_stack();

}  // namespace sslv
