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

/// What becomes of stages whose library does not fit the settings.
enum class MissingStages {
  kRefused,
  kLeftOut,  // the rest runs; what settings say of them is kept as it is
};

/// A stage of a library that does not know its parameters.
struct RefusedStage {
  std::string name, why;
};

/// What the settings say of stages, read once.
struct StageSettings {
  Json complete;                        // of every stage of the table, with defaults filled in
  std::vector<StageParams> params;      // by the table
  std::vector<RefusedStage> refused{};  // left out: their params are their defaults
};

/// `stages` maps stage names to their parameters; absent ones have their defaults. Throws SettingsError,
/// beginning with `path`, for a stage that is not in the table or a parameter that is not allowed.
template <class Floor>
StageSettings read_stages(std::span<const BasicStageType<Floor>> table, const Json& stages,
                          const std::string& path, MissingStages missing = MissingStages::kRefused);

/// Whether the stack may run: its stages, in order. Throws SettingsError, beginning with `path`, for an
/// unknown stage, a stage listed twice, a part that no earlier stage provides or that two stages write.
template <class Floor>
std::vector<const BasicStageType<Floor>*> check_stack(std::span<const BasicStageType<Floor>> table,
                                                      const std::vector<std::string>& stack,
                                                      const std::string& path);

/// What of a stack can run.
struct RunningStack {
  std::vector<std::string> stages;
  std::vector<std::string> missing;   // not in the table
  std::vector<RefusedStage> refused;  // of the stack or not
  std::vector<std::string> idle;      // they need what one that is left out would have made
};

/// All of it, unless stages are missing or refused. The rest throws as check_stack() does.
template <class Floor>
RunningStack running_stack(std::span<const BasicStageType<Floor>> table,
                           const std::vector<std::string>& stack, const std::string& path,
                           MissingStages missing, std::vector<RefusedStage> refused);

/// The stages of one stack in their order, checked. Made when the stack changes; parameters may change
/// without (Parameters below). Used by one thread at a time.
template <class Floor>
class BasicPipeline {
 public:
  using StageType = BasicStageType<Floor>;
  using Inputs = typename Floor::Inputs;

  /// Throws as check_stack() does. `table` must outlive the pipeline. A stage of a library whose constructor
  /// throws does nothing and says so (note()).
  BasicPipeline(std::span<const StageType> table, const std::vector<std::string>& stack,
                const std::string& path);

  /// One parameter set for each stage of the stack, taken together, so that a frame sees all of a change or
  /// none.
  using Parameters = std::vector<StageParams>;

  /// Those of this stack. `params`: by the table, as StageSettings has them.
  Parameters parameters_of(const std::vector<StageParams>& params) const;
  /// Likewise of what read_stages() reads, and throws.
  Parameters make_parameters(const Json& stages, const std::string& path) const;

  /// Runs every stage in order and notes each one's time in the frame's stage_ns. No allocation of its own
  /// once stage_ns has its capacity.
  void run(const Inputs& inputs, const Parameters& parameters) noexcept;

  /// What the stages remember of earlier frames, between two frames: its bytes in `room`; 0 when they do not
  /// fit. Allocates nothing.
  std::size_t save(std::span<std::byte> room) const noexcept;
  /// What save() wrote for the same stack: the stages go on as they did then. Names of those that do not
  /// understand it, which remember nothing.
  std::vector<std::string> restore(std::span<const std::byte> saved);

  const std::vector<std::string>& stack() const { return stack_; }
  /// Recent durations of stage i of the stack; may be read from any thread.
  const RecentDurations& durations(std::size_t i) const { return steps_[i]->durations; }
  /// Where the stage is from: a file's name; empty: it is the service's own.
  const std::string& library(std::size_t i) const { return steps_[i]->type->library; }
  /// What stage i made that was left out because it made no sense (senseless.h); likewise.
  Senseless left_out(std::size_t i) const { return steps_[i]->left_out.read(); }
  /// What stage i has to say at the moment; likewise.
  StageNotes::Note note(std::size_t i) const { return steps_[i]->step->notes.read(); }

 private:
  struct Running {
    explicit Running(const StageType& stage_type);
    const StageType* type;
    std::unique_ptr<Step<Floor>> step;
    const PartSet changes;
    RecentDurations durations;
    SenselessTotals left_out;
  };
  std::span<const StageType> table_;
  std::vector<std::string> stack_;
  std::vector<std::unique_ptr<Running>> steps_;
  std::vector<std::pair<std::size_t, OwnPartType>> own_parts_;  // by place: of all stages of the stack
  typename Floor::Guard guard_;
};

/// The stages of one camera.
using Pipeline = BasicPipeline<CameraFloor>;
/// Those of the whole field.
using FieldPipeline = BasicPipeline<FieldFloor>;

}  // namespace sslv
