// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/recent.h"
#include "pipeline/camera_stage.h"
#include "pipeline/field_stage.h"

#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace sslv {

/// Handling of stages that are missing or refuse their settings.
enum class MissingStages {
  kRefused,
  kLeftOut,  // left out; their settings are kept unchanged
};

/// A library's stage that refused its parameters.
struct RefusedStage {
  std::string name, why;
};

/// Settings of the stages, parsed.
struct StageSettings {
  Json complete;                        // settings of all stages of the table, with defaults filled in
  std::vector<StageParams> params;      // in the order of the table
  std::vector<RefusedStage> refused{};  // stages left out; their params are the defaults
};

/// `stages` maps stage names to their parameters; missing parameters get their defaults. Throws
/// SettingsError, its message starting with `path`, for a stage that is not in the table or a parameter that
/// is not allowed.
template <class Floor>
StageSettings read_stages(std::span<const BasicStageType<Floor>> table, const Json& stages,
                          const std::string& path, MissingStages missing = MissingStages::kRefused);

/// Validates a stack and returns its stages in order. Throws SettingsError, its message starting with `path`,
/// for an unknown stage, a stage listed twice, a part that no earlier stage provides or that two stages
/// write.
template <class Floor>
std::vector<const BasicStageType<Floor>*> check_stack(std::span<const BasicStageType<Floor>> table,
                                                      const std::vector<std::string>& stack,
                                                      const std::string& path);

/// The stages of a stack that can run, and the stages that cannot run.
struct RunningStack {
  std::vector<std::string> stages;
  std::vector<std::string> missing;   // not in the table
  std::vector<RefusedStage> refused;  // stages that refused their parameters
  std::vector<std::string> idle;      // need a part that a left-out stage would have written
};

/// Finds the stages that can run: all stages, unless some are missing or refused. Throws SettingsError like
/// check_stack() for the stages that can run.
template <class Floor>
RunningStack running_stack(std::span<const BasicStageType<Floor>> table,
                           const std::vector<std::string>& stack, const std::string& path,
                           MissingStages missing, std::vector<RefusedStage> refused);

/// The stages of one stack in order, validated. Rebuilt when the stack changes, but not for new parameters
/// (Parameters below). Used by one thread at a time.
template <class Floor>
class BasicPipeline {
 public:
  using StageType = BasicStageType<Floor>;
  using Inputs = typename Floor::Inputs;

  /// Throws like check_stack(). `table` must outlive the pipeline. A library's stage whose constructor throws
  /// does nothing and reports that in note().
  BasicPipeline(std::span<const StageType> table, const std::vector<std::string>& stack,
                const std::string& path);

  /// One parameter set for each stage of the stack, replaced together, so that a frame uses all new
  /// parameters or none.
  using Parameters = std::vector<StageParams>;

  /// Parameters of this stack. `params`: in the order of the table, as in StageSettings.
  Parameters parameters_of(const std::vector<StageParams>& params) const;
  /// Parameters of this stack from settings. Throws like read_stages().
  Parameters make_parameters(const Json& stages, const std::string& path) const;

  /// Runs every stage in order and records its duration in the frame's stage_ns. Allocates nothing itself
  /// once stage_ns has its capacity.
  void run(const Inputs& inputs, const Parameters& parameters) noexcept;

  /// Writes the stages' state to `room`. Call between two frames. Returns the number of bytes written, 0 if
  /// the state does not fit. Allocates nothing.
  std::size_t save(std::span<std::byte> room) const noexcept;
  /// Restores the state that save() wrote for the same stack. Returns the names of the stages that refused
  /// their state and now have none.
  std::vector<std::string> restore(std::span<const std::byte> saved);

  const std::vector<std::string>& stack() const { return stack_; }
  /// Recent durations of stage i of the stack; may be read from any thread.
  const RecentDurations& durations(std::size_t i) const { return steps_[i]->durations; }
  /// File name of the stage's library; empty for a built-in stage.
  const std::string& library(std::size_t i) const { return steps_[i]->type->library; }
  /// Counts of stage i's results that were dropped as invalid (validate.h); may be read from any thread.
  InvalidCounts left_out(std::size_t i) const { return steps_[i]->left_out.read(); }
  /// Current message of stage i; may be read from any thread.
  StageNotes::Note note(std::size_t i) const { return steps_[i]->step->notes.read(); }

 private:
  struct Running {
    explicit Running(const StageType& stage_type);
    const StageType* type;
    std::unique_ptr<Step<Floor>> step;
    const PartSet changes;
    RecentDurations durations;
    InvalidTotals left_out;
  };
  std::span<const StageType> table_;
  std::vector<std::string> stack_;
  std::vector<std::unique_ptr<Running>> steps_;
  std::vector<std::pair<std::size_t, OwnPartType>> own_parts_;  // place and type of each
  typename Floor::Guard guard_;
};

/// The stages of one camera.
using Pipeline = BasicPipeline<CameraFloor>;
/// The stages of the whole field.
using FieldPipeline = BasicPipeline<FieldFloor>;

}  // namespace sslv
