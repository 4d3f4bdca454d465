// SPDX-License-Identifier: Apache-2.0
#pragma once

// Reports on the stages of a camera or of the field: stages that are slow, give invalid results, warn, or
// hang.

#include "base/json.h"
#include "pipeline/pipeline.h"
#include "pipeline/stage_mark.h"
#include "services/health_report.h"
#include "services/stage_watch.h"

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace sslv {

/// Name of a stage's library file, without its folders.
std::string library_name(std::string_view file);

/// "the stage 'x' (library.so)".
std::string stage_text(const std::string& name, const std::string& library);

/// Facts about a stack, read once.
struct StackFacts {
  std::optional<int> camera{};  // none: the field's
  std::string check{};          // id of its Go / No-Go check
  std::vector<StageFigures> stages{};
  double come_per_s = 0;       // images that should be processed
  double processed_per_s = 0;  // images that are processed
  bool loses = false;          // the counters show images lost in the last seconds
  bool is_slow = false;        // fewer images are processed than requested, whatever the counters say
};

/// A stage that causes the loss of images.
struct SlowStage {
  std::string name;        // "the stage 'x' (library.so)"
  std::string text;        // "the stage 'x' takes 41 ms an image; images arrive every 13 ms"
  bool is_always = false;  // the stages cannot keep up; false: only single images take long
  bool is_ours = true;     // built into the service, not from a library
};
/// Returns nothing if the stages have enough time, or if no image is lost.
std::optional<SlowStage> find_slow_stage(const StackFacts& facts);

/// Adds alerts.
void report_stages(const StackFacts& facts, HealthReport& report);

/// A thread that makes no progress.
struct Hang {
  std::int64_t since_ns = 0;  // time of steady_ns()
  std::string stage{};        // stage that the thread is in; empty: none
  std::string library{};      // library of that stage
};
/// Text that names the stage in which a thread hangs: " in the stage 'x' (library.so)"; empty if it hangs
/// outside of the stages.
std::string place_text(const Hang& hang);
/// As in docs/openapi.json. `now_s`, `now_ns`: the same moment as Unix time and as steady_ns().
Json to_json(const std::optional<Hang>& hang, double now_s, std::int64_t now_ns);

/// Returns a Hang in the marked stage, whose name and library are looked up in the stage table.
template <class Floor>
Hang hang_of(std::span<const BasicStageType<Floor>> table, const StageMark::Reading& mark) {
  return {mark.since_ns, table[mark.stage].name, library_name(table[mark.stage].library)};
}

/// The field's thread counts as hung after this time in one stage. A camera's thread counts as hung after
/// this time without progress; its cycle takes 0.1 s plus the processing of a frame.
inline constexpr std::int64_t kHangs_ns = 5'000'000'000;

/// Stage of docs/openapi.json for each stage of the stack.
template <class Floor>
Json stages_json(const BasicPipeline<Floor>& pipeline);

}  // namespace sslv
