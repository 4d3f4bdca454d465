// SPDX-License-Identifier: Apache-2.0
#include "services/colors/colors_json.h"

#include "base/params_json.h"
#include "colors/margins_json.h"
#include "vision/detections_json.h"

#include <algorithm>
#include <cstddef>
#include <memory>

namespace sslv {
namespace {

constexpr std::size_t kMaxSteps = 20;

Json step_json(const TableStep& step) {
  std::size_t cells = 0;
  for (const CellRun& run : step.changes) cells += run.length;
  return {{"what", step.what},
          {"who", step.who},
          {"time", static_cast<double>(step.time_us) * 1e-6},
          {"cells", cells}};
}

template <class Numbers>
Json array_json(const Numbers& numbers) {
  Json out = Json::array();
  for (const auto& number : numbers) out.push_back(number);
  return out;
}

Json learnt_color_json(const LearntLabel& learnt, const LearningReport& report, const LabelSet& labels) {
  return {{"label", labels.name(learnt.label)},
          {"samples", learnt.seen + learnt.guided},
          {"mean", {learnt.mean.r, learnt.mean.g, learnt.mean.b}},
          {"spread", learnt.spread},
          {"before_cells", report.cells_before[learnt.label]},
          {"after_cells", report.cells_after[learnt.label]}};
}

Json taught_json(const LearntColors& learnt, std::size_t picture) {
  constexpr double kTopRadius_mm = 90;
  Json out = Json::array();
  for (const LearntRobot& robot : learnt.robots) {
    if (robot.frame != picture) continue;
    out.push_back({{"kind", "robot"},
                   {"team", name_of(robot.team)},
                   {"x", robot.pixel_x},
                   {"y", robot.pixel_y},
                   {"radius", kTopRadius_mm * robot.px_per_mm}});
  }
  for (const LearntBall& ball : learnt.balls) {
    if (ball.frame != picture) continue;
    out.push_back({{"kind", "ball"},
                   {"team", nullptr},
                   {"x", ball.pixel_x},
                   {"y", ball.pixel_y},
                   {"radius", ball.radius_px}});
  }
  return out;
}

Json report_json(const LearningReport& report, const LabelSet& labels) {
  const LearntColors& learnt = report.learnt;
  Json colors = Json::array();
  for (const LearntLabel& one : learnt.labels) colors.push_back(learnt_color_json(one, report, labels));
  Json pictures = Json::array();
  for (std::size_t i = 0; i < report.pictures.size(); ++i) {
    const LearningPicture& one = report.pictures[i];
    pictures.push_back({{"frame", one.picture->frame_number},
                        {"t_capture", one.picture->t_capture_s},
                        {"width", one.picture->view.width},
                        {"height", one.picture->view.height},
                        {"before", detections_json(one.robots_before, one.balls_before)},
                        {"after", detections_json(one.robots_after, one.balls_after)},
                        {"taught", taught_json(learnt, i)}});
  }
  return {{"learnt", learnt.lut != nullptr},
          {"problem", learnt.problem},
          {"notes", learnt.notes},
          {"robots", {{"yellow", learnt.robots_of(Team::kYellow)}, {"blue", learnt.robots_of(Team::kBlue)}}},
          {"balls", learnt.balls.size()},
          {"mm_per_px", learnt.mm_per_px},
          {"calibrated", report.calibrated},
          {"changed_cells", report.changed_cells},
          {"colors", std::move(colors)},
          {"pictures", std::move(pictures)},
          {"seconds", report.seconds}};
}

}  // namespace

Json light_json(const LightView& light) {
  const LightState& state = light.state;
  Json steps = Json::array();
  for (auto step = light.steps.rbegin(); step != light.steps.rend() && steps.size() < kMaxSteps; ++step) {
    steps.push_back({{"time", step->time_s},
                     {"gain", array_json(step->change.gain)},
                     {"robots", step->robots},
                     {"from_carpet", step->from_carpet}});
  }
  return {{"state", name_of(state.following)},
          {"reason", state.why},
          {"gain", array_json(state.gain)},
          {"columns", LightState::kColumns},
          {"rows", LightState::kRows},
          {"areas", array_json(state.areas)},
          {"robots", state.robots},
          {"last_confirmed", state.last_confirmed_s ? Json(*state.last_confirmed_s) : Json(nullptr)},
          {"changed", light.changed},
          {"steps", std::move(steps)}};
}

Json colors_json(int camera_id, const std::string& origin, ColorDesk& desk, const LabelSet& labels,
                 const LightView& light, const std::optional<std::vector<LabelMargin>>& margins) {
  const TableStatistics& statistics = desk.statistics();
  Json label_list = Json::array();
  for (std::size_t i = 0; i < label::kMaxCount; ++i) {
    const auto value = static_cast<Label>(i);
    // A label that was removed from the settings may still be in the table.
    if (!labels.has(value) && statistics.cells[i] == 0) continue;
    label_list.push_back({{"value", i},
                          {"name", labels.name(value)},
                          {"color", hex(labels.color(value))},
                          {"built_in", i < label::kCount},
                          {"cells", statistics.cells[i]}});
  }
  Json conflicts = Json::array();
  std::size_t conflict_cells = 0;
  for (const TableConflict& conflict : statistics.conflicts) {
    conflicts.push_back(
        {{"labels", {labels.name(conflict.a), labels.name(conflict.b)}}, {"cells", conflict.cells}});
    conflict_cells += conflict.cells;
  }
  const TableHistory& history = desk.history();
  Json steps = Json::array();
  for (auto step = history.done().rbegin(); step != history.done().rend() && steps.size() < kMaxSteps; ++step)
    steps.push_back(step_json(*step));
  return {{"camera", camera_id},
          {"revision", desk.revision()},
          {"origin", origin},
          {"bits", desk.table()->color_bits()},
          {"labels", std::move(label_list)},
          {"conflicts", std::move(conflicts)},
          {"conflict_cells", conflict_cells},
          {"undo", history.can_undo() ? step_json(history.done().back()) : Json(nullptr)},
          {"redo", history.can_redo() ? step_json(history.undone().back()) : Json(nullptr)},
          {"steps", std::move(steps)},
          {"light", light_json(light)},
          {"margins", margins ? margins_json(*margins, labels) : Json(nullptr)},
          {"wanted_margin", kWantedMargin},
          {"least_margin", kMinMargin}};
}

Json table_change_json(const TableChange& change, const LabelSet& labels) {
  Json from = Json::array();
  std::size_t cells = 0;
  for (const auto& [label, count] : cells_before(change.cells)) {
    from.push_back({{"label", labels.name(label)}, {"cells", count}});
    cells += count;
  }
  return {{"cells", cells}, {"from", std::move(from)}, {"left_to_carpet", change.left_clear}};
}

Json imported_json(const std::vector<ImportedTable>& tables, const LabelSet& labels) {
  Json out = Json::array();
  for (const ImportedTable& one : tables) {
    std::array<std::size_t, label::kMaxCount> cells{};
    for (const Label label : one.table.labels) ++cells[label % label::kMaxCount];
    Json names = Json::array();
    std::size_t labelled = 0;
    for (std::size_t i = 1; i < cells.size(); ++i) {
      if (cells[i] == 0) continue;
      names.push_back(labels.name(static_cast<Label>(i)));
      labelled += cells[i];
    }
    out.push_back({{"name", one.name},
                   {"format", one.format},
                   {"bits", one.table.bits},
                   {"labels", std::move(names)},
                   {"cells", labelled}});
  }
  return out;
}

Json learning_json(int camera_id, const ColorLearning::Job& job, const LabelSet& labels) {
  return {{"camera", camera_id},
          {"state", name_of(job.state)},
          {"frames_taken", job.frames},
          {"problem", job.problem},
          {"started", job.order ? Json(job.order->time_s) : Json(nullptr)},
          {"who", job.order ? job.order->who : ""},
          {"report", job.report ? report_json(*job.report, labels) : Json(nullptr)}};
}

LearningRequest read_learning_request(const Json& json) {
  return params_from_json<LearningRequest>(json, "");
}

}  // namespace sslv
