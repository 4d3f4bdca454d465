// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kit/load_stages.h"
#include "pipeline/camera_stage.h"
#include "pipeline/field_stage.h"
#include "pipeline/pipeline.h"

#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace sslv {

// Tables are made at a program's start: settings, schema, pipelines and totals go by a row's place, so once
// anything has used a table, it stays as it is.

/// Adds the stages of one library. Throws StageLibraryError, and adds nothing, for a stage whose name is
/// taken and for a part that another library brings with another layout; std::logic_error when a table was
/// used before.
void add_stages(StageRows rows);

/// Where stage libraries are looked for; only a command line says so.
struct StageFolders {
  std::vector<std::filesystem::path> inside;  // their code runs in this program (kit/load_stages.h)
  std::vector<std::filesystem::path> apart;   // each stage runs in a process of its own (kit/apart/apart.h)
};

/// Adds those of all libraries in these folders. What is left out is logged. `missing`: what becomes of
/// stages that settings name and that are not there, when there are any folders.
void add_stage_libraries(const StageFolders& folders, MissingStages missing);
std::span<const LeftOutLibrary> left_out_libraries();

/// Nobody waits any more for a process of a stage to start or to answer a question: that fails, now and
/// later. Those that run go on.
void ask_stages_to_stop();

/// Ends the processes of stages when main() does, while all that they are told to is still there. To be
/// declared before anything that has stages.
struct EndOfStageProcesses {
  EndOfStageProcesses() = default;
  ~EndOfStageProcesses();
  EndOfStageProcesses(const EndOfStageProcesses&) = delete;
  EndOfStageProcesses& operator=(const EndOfStageProcesses&) = delete;
};

/// Settings may name stages that are not there, as with kLeftOut above.
void leave_out_missing_stages();
MissingStages missing_stages();

/// Every stage a stack may name.
std::span<const StageType> stage_table();

/// The stack of a camera that does not say otherwise.
std::vector<std::string> default_stack();

/// Every stage that the field's stack may name.
std::span<const FieldStageType> field_stage_table();

/// The field's stack unless the settings say otherwise.
std::vector<std::string> default_field_stack();

}  // namespace sslv
