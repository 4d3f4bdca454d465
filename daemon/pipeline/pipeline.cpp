// SPDX-License-Identifier: Apache-2.0
#include "pipeline/pipeline.h"

#include "base/clock.h"

#include <algorithm>
#include <array>

#include <fmt/format.h>

namespace sslv {
namespace {

/// Of a part of the frame, or of one that a library brought.
template <class Floor>
std::string part_name(std::span<const BasicStageType<Floor>> table, std::size_t index) {
  static constexpr auto kNames =
      std::apply([](const auto&... part) { return std::array{part.name...}; }, Floor::kParts);
  if (index < kNames.size()) return std::string(kNames[index]);
  for (const auto& type : table) {
    for (const OwnPartUse& use : type.own_parts)
      if (kNames.size() + *use.place == index) return use.type.name;
  }
  return {};
}

template <class Floor>
const BasicStageType<Floor>& find_stage(std::span<const BasicStageType<Floor>> table, const std::string& name,
                                        const std::string& path) {
  const auto found =
      std::find_if(table.begin(), table.end(), [&](const auto& type) { return type.name == name; });
  if (found != table.end()) return *found;
  std::string known;
  for (const auto& type : table) known += (known.empty() ? "" : ", ") + std::string(type.name);
  throw SettingsError(fmt::format("{}: unknown stage '{}'; known: {}", path, shortened(name), known));
}

}  // namespace

template <class Floor>
std::vector<const BasicStageType<Floor>*> check_stack(std::span<const BasicStageType<Floor>> table,
                                                      const std::vector<std::string>& stack,
                                                      const std::string& path) {
  using Type = BasicStageType<Floor>;
  PartSet have = Floor::kProvided;
  std::array<std::string, PartSet().size()> writer;
  std::vector<const Type*> stages;
  for (std::size_t s = 0; s < stack.size(); ++s) {
    const std::string here = fmt::format("{}/{}", path, s);
    const Type& type = find_stage<Floor>(table, stack[s], here);
    if (std::count(stack.begin(), stack.end(), stack[s]) > 1) {
      throw SettingsError(fmt::format("{}: stage '{}' is in the stack twice", here, stack[s]));
    }
    for (std::size_t i = 0; i < have.size(); ++i) {
      if (type.reads[i] && !have[i]) {
        throw SettingsError(fmt::format("{}: stage '{}' needs '{}', which no earlier stage provides", here,
                                        type.name, part_name<Floor>(table, i)));
      }
      if (type.writes[i] && have[i]) {
        throw SettingsError(
            fmt::format("{}: stage '{}' would overwrite '{}', which {} provides", here, type.name,
                        part_name<Floor>(table, i),
                        writer[i].empty() ? std::string(Floor::kProvider) : "'" + writer[i] + "'"));
      }
      if (type.writes[i]) writer[i] = type.name;
    }
    have |= type.writes;
    stages.push_back(&type);
  }
  return stages;
}

template <class Floor>
BasicPipeline<Floor>::BasicPipeline(std::span<const StageType> table, const std::vector<std::string>& stack,
                                    const std::string& path)
    : table_(table), stack_(stack) {
  std::size_t s = 0;
  for (const StageType* type : check_stack<Floor>(table, stack, path)) {
    try {
      steps_.push_back(std::make_unique<Running>(*type));
    } catch (const std::exception& error) {
      throw SettingsError(
          fmt::format("{}/{}: stage '{}' cannot start: {}", path, s, type->name, shortened(error.what())));
    }
    for (const OwnPartUse& use : type->own_parts) own_parts_.emplace_back(*use.place, use.type);
    ++s;
  }
}

template <class Floor>
typename BasicPipeline<Floor>::Parameters BasicPipeline<Floor>::parameters_of(
    const std::vector<StageParams>& params) const {
  Parameters parameters;
  for (const auto& step : steps_)
    parameters.push_back(params[static_cast<std::size_t>(step->type - table_.data())]);
  return parameters;
}

template <class Floor>
typename BasicPipeline<Floor>::Parameters BasicPipeline<Floor>::make_parameters(
    const Json& stages, const std::string& path) const {
  return parameters_of(read_stages<Floor>(table_, stages, path).params);
}

template <class Floor>
void BasicPipeline<Floor>::run(const Inputs& inputs, const Parameters& parameters) noexcept {
  auto& stage_ns = inputs.frame.stage_ns;
  stage_ns.resize(steps_.size());
  for (const auto& [place, type] : own_parts_) inputs.frame.own_parts.prepare(place, type);
  const Inputs guarded = Floor::guarded(inputs, guard_);
  std::int64_t before = steady_ns();
  for (std::size_t i = 0; i < steps_.size(); ++i) {
    Running& running = *steps_[i];
    const auto place = static_cast<std::size_t>(running.type - table_.data());
    inputs.stage_begins(place, before);
    running.step->run(guarded, parameters[i].get());
    Senseless left_out = guard_.take_left_out();
    if (running.changes.any()) left_out += Floor::drop_senseless(inputs, running.changes, guard_);
    if (left_out.any()) {
      running.left_out.add(left_out);
      inputs.left_out(place, left_out);
    }
    const std::int64_t after = steady_ns();
    stage_ns[i] = after - before;
    running.durations.add_ns(after - before);
    inputs.stage_took(place, after - before);
    before = after;
  }
}

template <class Floor>
StageSettings read_stages(std::span<const BasicStageType<Floor>> table, const Json& stages,
                          const std::string& path) {
  if (!stages.is_object()) refuse(path, stages, "an object of stages");
  for (const auto& item : stages.items()) {
    if (item.key() != kCommentKey) find_stage<Floor>(table, item.key(), path + "/" + shortened(item.key()));
  }
  StageSettings out{Json::object(), {}};
  for (const auto& type : table) {
    const std::string name(type.name);
    auto parsed = type.parse(stages.contains(name) ? stages.at(name) : Json::object(), path + "/" + name);
    out.complete[name] = std::move(parsed.complete);
    out.params.push_back(std::move(parsed.params));
  }
  return out;
}

template class BasicPipeline<CameraFloor>;
template StageSettings read_stages<CameraFloor>(std::span<const BasicStageType<CameraFloor>>, const Json&,
                                                const std::string&);
template std::vector<const BasicStageType<CameraFloor>*> check_stack<CameraFloor>(
    std::span<const BasicStageType<CameraFloor>>, const std::vector<std::string>&, const std::string&);

template class BasicPipeline<FieldFloor>;
template StageSettings read_stages<FieldFloor>(std::span<const BasicStageType<FieldFloor>>, const Json&,
                                               const std::string&);
template std::vector<const BasicStageType<FieldFloor>*> check_stack<FieldFloor>(
    std::span<const BasicStageType<FieldFloor>>, const std::vector<std::string>&, const std::string&);

}  // namespace sslv
