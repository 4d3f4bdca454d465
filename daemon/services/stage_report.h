// SPDX-License-Identifier: Apache-2.0
#pragma once

// What is said of the stages of a camera, or of the field: those that are slow, that make what makes no
// sense, that warn, that hang.

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

/// Of the file that a stage comes from: without its folders.
std::string library_name(std::string_view file);

/// "the stage 'x' (library.so)".
std::string stage_text(const std::string& name, const std::string& library);

/// What is known of a stack, read once.
struct StackFacts {
  std::optional<int> camera{};  // none: it is the field's
  std::string check{};          // of Go / No-Go
  std::vector<StageFigures> stages{};
  double come_per_s = 0;       // images: that should be processed
  double processed_per_s = 0;  // and that are
  bool loses = false;          // images, lately, as was counted
  bool is_slow = false;        // fewer are processed than were asked for, whatever was counted
};

/// A stage that images are lost by.
struct SlowStage {
  std::string name;        // "the stage 'x' (library.so)"
  std::string text;        // "the stage 'x' takes 41 ms an image; images come every 13 ms"
  bool is_always = false;  // it is not a single image that takes long: the stages cannot keep up
  bool is_ours = true;     // no library's
};
/// None where the stages have time enough, or nothing is lost.
std::optional<SlowStage> find_slow_stage(const StackFacts& facts);

/// Adds alerts.
void report_stages(const StackFacts& facts, HealthReport& report);

/// A thread that does not go on.
struct Hang {
  std::int64_t since_ns = 0;  // of steady_ns()
  std::string stage{};        // that it is in; empty: in none
  std::string library{};      // of that stage
};
/// Where a thread of a camera or of the field hangs: " in the stage 'x' (library.so)"; empty for no stage.
std::string place_text(const Hang& hang);
/// As docs/openapi.json has it. `now_s`, `now_ns`: one moment on both clocks.
Json to_json(const std::optional<Hang>& hang, double now_s, std::int64_t now_ns);

/// The stage that a thread is in, by its floor's table.
template <class Floor>
Hang hang_of(std::span<const BasicStageType<Floor>> table, const StageMark::Reading& mark) {
  return {mark.since_ns, table[mark.stage].name, library_name(table[mark.stage].library)};
}

/// A thread of the field hangs when it is in one stage for this long; a camera's, when it does not come back
/// for so long: a turn of it takes 0.1 s and a frame's processing.
inline constexpr std::int64_t kHangs_ns = 5'000'000'000;

/// Docs/openapi.json's Stage for each stage of the stack.
template <class Floor>
Json stages_json(const BasicPipeline<Floor>& pipeline);

}  // namespace sslv
