// SPDX-License-Identifier: Apache-2.0
#include "services/stage_report.h"

#include "base/plain_text.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include <fmt/format.h>

namespace sslv {
namespace {

/// Stages that take more than this share of the time have no time for another image.
constexpr double kBusyShare = 0.9;
/// Processing a single image may take this many image intervals, because drivers buffer some images.
constexpr double kLongImages = 2;

std::string duration_text(double ms) {
  return ms < 9.95 ? fmt::format("{:.1f} ms", ms) : fmt::format("{:.0f} ms", ms);
}

/// "Camera 0: the stage ..."; "Field: the stage ...".
std::string title_of(const StackFacts& facts, const std::string& text) {
  return (facts.camera ? fmt::format("Camera {}: ", *facts.camera) : "Field: ") + text;
}

std::string settings_page(const StackFacts& facts) {
  return facts.camera ? "#/settings/cameras" : "#/settings/field";
}

/// "12 robots, 1 ball".
std::string invalid_text(const InvalidCounts& what) {
  std::string out;
  const auto add = [&](std::uint64_t count, const char* one, const char* several) {
    if (count == 0) return;
    out += fmt::format("{}{} {}", out.empty() ? "" : ", ", count, count == 1 ? one : several);
  };
  add(what.robots, "robot", "robots");
  add(what.balls, "ball", "balls");
  add(what.others, "time or kick", "times or kicks");
  return out;
}

void report_slow(const StackFacts& facts, HealthReport& report) {
  const auto slow = find_slow_stage(facts);
  if (!slow) return;
  const std::string rate = facts.camera ? "lower the frame rate" : "lower the cameras' frame rates";
  report.alerts.push_back(
      {.id = "stage_slow",
       .check = facts.check,
       .severity = slow->is_always && facts.camera ? Severity::kBad : Severity::kWarn,
       .title = title_of(facts, slow->text),
       .fix =
           slow->is_ours
               ? fmt::format("Close other programs on this computer, {}, or give the stage less to do.", rate)
               : fmt::format("Give the stage less to do in its settings, remove it from the stack, or {}.",
                             rate),
       .page = "#/diagnostics",
       .camera = facts.camera,
       .about = slow->name});
}

void report_stage(const StackFacts& facts, const StageFigures& stage, HealthReport& report) {
  const std::string name = stage_text(stage.name, stage.library);
  if (stage.left_out.any()) {
    report.alerts.push_back(
        {.id = "stage_senseless",
         .check = facts.check,
         .severity = Severity::kWarn,
         .title = title_of(facts, fmt::format("{} gave invalid results: {} dropped in the last {} s", name,
                                              invalid_text(stage.left_out), StageWatch::kSeconds)),
         .fix = "The stage is faulty: remove it from the stack and tell its author.",
         .page = settings_page(facts),
         .camera = facts.camera,
         .about = stage.name});
  }
  if (stage.note.kind == StageNotes::Kind::kWarning) {
    report.alerts.push_back(
        {.id = "stage_warns",
         .check = facts.check,
         .severity = Severity::kWarn,
         .title = title_of(facts, fmt::format("{} warns: {}", name, escaped_text(stage.note.text))),
         .fix = "The stage's own description explains what to do.",
         .page = settings_page(facts),
         .camera = facts.camera,
         .about = stage.name});
  }
}

}  // namespace

std::string library_name(std::string_view file) {
  return escaped_text(file.substr(file.rfind('/') + 1));
}

std::string stage_text(const std::string& name, const std::string& library) {
  return library.empty() ? fmt::format("the stage '{}'", name)
                         : fmt::format("the stage '{}' ({})", name, library);
}

std::optional<SlowStage> find_slow_stage(const StackFacts& facts) {
  if (!(facts.loses || facts.is_slow) || facts.stages.empty() || !(facts.come_per_s > 0)) return std::nullopt;
  const double every_ms = 1000 / facts.come_per_s;
  const auto result = [&](const StageFigures& stage, const std::string& time, bool is_always) {
    const std::string name = stage_text(stage.name, stage.library);
    return SlowStage{name, fmt::format("{} {}; images arrive every {}", name, time, duration_text(every_ms)),
                     is_always, stage.library.empty()};
  };
  const double all_ms = std::accumulate(facts.stages.begin(), facts.stages.end(), 0.0,
                                        [](double sum, const auto& stage) { return sum + stage.mean_ms; });
  if (all_ms * facts.processed_per_s >= kBusyShare * 1000) {
    const auto& slowest = *std::ranges::max_element(facts.stages, {}, &StageFigures::mean_ms);
    std::string time = fmt::format("takes {} an image", duration_text(slowest.mean_ms));
    if (slowest.mean_ms < every_ms) time += fmt::format(", all stages together {}", duration_text(all_ms));
    return result(slowest, time, true);
  }
  const auto& longest = *std::ranges::max_element(facts.stages, {}, &StageFigures::max_ms);
  if (!facts.loses || longest.max_ms < kLongImages * every_ms) return std::nullopt;
  return result(longest, fmt::format("took up to {} for an image", duration_text(longest.max_ms)), false);
}

void report_stages(const StackFacts& facts, HealthReport& report) {
  report_slow(facts, report);
  for (const StageFigures& stage : facts.stages) report_stage(facts, stage, report);
}

std::string place_text(const Hang& hang) {
  return hang.stage.empty() ? "" : " in " + stage_text(hang.stage, hang.library);
}

Json to_json(const std::optional<Hang>& hang, double now_s, std::int64_t now_ns) {
  if (!hang) return nullptr;
  return {{"stage", hang->stage.empty() ? Json(nullptr) : Json(hang->stage)},
          {"library", hang->library},
          {"since", now_s - static_cast<double>(now_ns - hang->since_ns) * 1e-9}};
}

template <class Floor>
Json stages_json(const BasicPipeline<Floor>& pipeline) {
  Json out = Json::array();
  for (std::size_t i = 0; i < pipeline.stack().size(); ++i) {
    const auto times = pipeline.durations(i).percentiles();
    const StageNotes::Note note = pipeline.note(i);
    Json said = nullptr;
    if (note.kind != StageNotes::Kind::kNone) {
      said = {{"kind", note.kind == StageNotes::Kind::kWarning ? "warning" : "note"},
              {"text", escaped_text(note.text)}};
    }
    out.push_back({{"name", pipeline.stack()[i]},
                   {"p50_us", times.p50_us},
                   {"p99_us", times.p99_us},
                   {"library", library_name(pipeline.library(i))},
                   {"note", std::move(said)}});
  }
  return out;
}

template Json stages_json<CameraFloor>(const Pipeline&);
template Json stages_json<FieldFloor>(const FieldPipeline&);

}  // namespace sslv
