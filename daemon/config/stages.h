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

// Stage tables are built at the program's start and fixed once used: settings, schema, pipelines and totals
// refer to rows by index.

/// Adds the stages of one library. Throws StageLibraryError, and adds nothing, if a stage's name is taken or
/// another library has a frame part (pipeline/own_parts.h) of the same name with another layout;
/// std::logic_error if a table was already used.
void add_stages(StageRows rows);

/// Folders that are searched for stage libraries; set on the command line only.
struct StageFolders {
  std::vector<std::filesystem::path> inside;  // their code runs in this program (kit/load_stages.h)
  std::vector<std::filesystem::path>
      sandboxed;  // each stage runs in a process of its own (kit/sandbox/sandbox.h)
};

/// Adds the stages of all libraries in these folders. Logs the libraries that are left out. `missing`: how to
/// treat missing stages that are named in the settings; ignored if there are no folders.
void add_stage_libraries(const StageFolders& folders, MissingStages missing);
std::span<const LeftOutLibrary> left_out_libraries();

/// From now on, no caller waits for a stage's process to start or to answer: the wait fails instead. Running
/// processes continue.
void ask_stages_to_stop();

/// Ends the processes of stages at the end of main(), while all objects that report their end still exist.
/// Declare it before anything that has stages.
struct EndOfStageProcesses {
  EndOfStageProcesses() = default;
  ~EndOfStageProcesses();
  EndOfStageProcesses(const EndOfStageProcesses&) = delete;
  EndOfStageProcesses& operator=(const EndOfStageProcesses&) = delete;
};

/// From now on, settings may name missing stages (MissingStages::kLeftOut).
void leave_out_missing_stages();
MissingStages missing_stages();

/// Every stage a stack may name.
std::span<const StageType> stage_table();

/// The stack of a camera unless the settings set one.
std::vector<std::string> default_stack();

/// Every stage that the field's stack may name.
std::span<const FieldStageType> field_stage_table();

/// The field's stack unless the settings set one.
std::vector<std::string> default_field_stack();

}  // namespace sslv
