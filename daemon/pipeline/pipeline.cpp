// SPDX-License-Identifier: Apache-2.0
#include "pipeline/pipeline.h"

#include "base/clock.h"

#include <algorithm>
#include <array>

#include <fmt/format.h>

namespace sslv {
namespace {

/// Name of a part of the frame or of a library's part.
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
bool is_in(std::span<const BasicStageType<Floor>> table, const std::string& name) {
  return std::ranges::find(table, name, &BasicStageType<Floor>::name) != table.end();
}

template <class Floor>
const BasicStageType<Floor>& find_stage(std::span<const BasicStageType<Floor>> table, const std::string& name,
                                        const std::string& path) {
  const auto found = std::ranges::find(table, name, &BasicStageType<Floor>::name);
  if (found != table.end()) return *found;
  std::string known;
  for (const auto& type : table) known += (known.empty() ? "" : ", ") + std::string(type.name);
  throw SettingsError(fmt::format(
      "{}: unknown stage '{}'; known: {}. A stage of your own needs its library (--stages FOLDER)", path,
      shortened(name), known));
}

/// Replaces a library's stage that could not be made, so that the rest of the stack runs.
template <class Floor>
struct IdleStep final : Step<Floor> {
  explicit IdleStep(const std::string& why) { this->notes.warn("cannot start: " + why); }
  void run(const typename Floor::Inputs&, const void*) noexcept override {}
};

/// Passes on the exceptions of built-in stages' constructors.
template <class Floor>
std::unique_ptr<Step<Floor>> make_step(const BasicStageType<Floor>& type) {
  if (type.library.empty()) return type.create();
  try {
    return type.create();
  } catch (const std::exception& error) {
    return std::make_unique<IdleStep<Floor>>(error.what());
  } catch (...) {
    return std::make_unique<IdleStep<Floor>>("it throws");
  }
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
RunningStack running_stack(std::span<const BasicStageType<Floor>> table,
                           const std::vector<std::string>& stack, const std::string& path,
                           MissingStages missing, std::vector<RefusedStage> refused) {
  RunningStack out;
  PartSet have = Floor::kProvided;
  bool is_whole = true;
  for (const std::string& name : stack) {
    const auto found = std::ranges::find(table, name, &BasicStageType<Floor>::name);
    if (found == table.end()) {
      out.missing.push_back(name);
      is_whole = false;
    } else if (std::ranges::find(refused, name, &RefusedStage::name) != refused.end()) {
      is_whole = false;
    } else if ((found->reads & ~have).any() && !is_whole) {
      out.idle.push_back(name);
    } else {
      out.stages.push_back(name);
      have |= found->writes;
    }
  }
  out.refused = std::move(refused);
  // Unless stages were left out, checks the stack as in the settings, so that messages have its stage
  // numbers.
  check_stack<Floor>(table, missing == MissingStages::kRefused || is_whole ? stack : out.stages, path);
  return out;
}

template <class Floor>
BasicPipeline<Floor>::Running::Running(const StageType& stage_type)
    : type(&stage_type), step(make_step(stage_type)), changes(stage_type.writes | stage_type.updates) {}

template <class Floor>
BasicPipeline<Floor>::BasicPipeline(std::span<const StageType> table, const std::vector<std::string>& stack,
                                    const std::string& path)
    : table_(table), stack_(stack) {
  for (const StageType* type : check_stack<Floor>(table, stack, path)) {
    steps_.push_back(std::make_unique<Running>(*type));
    for (const OwnPartUse& use : type->own_parts) own_parts_.emplace_back(*use.place, use.type);
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
    InvalidCounts left_out = guard_.take_left_out();
    if (running.changes.any()) left_out += Floor::drop_invalid(inputs, running.changes, guard_);
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
std::size_t BasicPipeline<Floor>::save(std::span<std::byte> room) const noexcept {
  ByteWriter to(room);
  for (const auto& running : steps_) to.whole([&] { running->step->save(to); });
  return to.fits() ? to.written() : 0;
}

template <class Floor>
std::vector<std::string> BasicPipeline<Floor>::restore(std::span<const std::byte> saved) {
  constexpr bool kRefusesNan = true;  // stages sort and compare their state
  ByteReader from(saved, kRefusesNan);
  std::vector<std::string> not_understood;
  for (std::size_t i = 0; i < steps_.size(); ++i) {
    auto one = from.whole();
    if (!one || !steps_[i]->step->restore(*one)) not_understood.push_back(stack_[i]);
  }
  return not_understood;
}

template <class Floor>
StageSettings read_stages(std::span<const BasicStageType<Floor>> table, const Json& stages,
                          const std::string& path, MissingStages missing) {
  if (!stages.is_object()) refuse(path, stages, "an object of stages");
  StageSettings out{Json::object(), {}};
  for (const auto& item : stages.items()) {
    if (item.key() == kCommentKey) continue;
    if (missing == MissingStages::kLeftOut && !is_in(table, item.key())) {
      out.complete[item.key()] = item.value();
    } else {
      find_stage<Floor>(table, item.key(), path + "/" + shortened(item.key()));
    }
  }
  for (const auto& type : table) {
    const auto take = [&](typename BasicStageType<Floor>::Parsed parsed) {
      out.complete[type.name] = std::move(parsed.complete);
      out.params.push_back(std::move(parsed.params));
    };
    const std::string here = path + "/" + type.name;
    const Json given = stages.contains(type.name) ? stages.at(type.name) : Json::object();
    const bool is_outside = !type.library.empty() && missing == MissingStages::kLeftOut;
    try {
      take(type.parse(given, here));
    } catch (const SettingsError& error) {
      // Another version of the library may have other parameters; this must not invalidate all other
      // settings.
      if (!is_outside) throw;
      take(type.parse(Json::object(), here));
      out.complete[type.name] = given;
      out.refused.push_back({type.name, error.what()});
    }
  }
  return out;
}

template class BasicPipeline<CameraFloor>;
template StageSettings read_stages<CameraFloor>(std::span<const StageType>, const Json&, const std::string&,
                                                MissingStages);
template std::vector<const StageType*> check_stack<CameraFloor>(std::span<const StageType>,
                                                                const std::vector<std::string>&,
                                                                const std::string&);
template RunningStack running_stack<CameraFloor>(std::span<const StageType>, const std::vector<std::string>&,
                                                 const std::string&, MissingStages,
                                                 std::vector<RefusedStage>);

template class BasicPipeline<FieldFloor>;
template StageSettings read_stages<FieldFloor>(std::span<const FieldStageType>, const Json&,
                                               const std::string&, MissingStages);
template std::vector<const FieldStageType*> check_stack<FieldFloor>(std::span<const FieldStageType>,
                                                                    const std::vector<std::string>&,
                                                                    const std::string&);
template RunningStack running_stack<FieldFloor>(std::span<const FieldStageType>,
                                                const std::vector<std::string>&, const std::string&,
                                                MissingStages, std::vector<RefusedStage>);

}  // namespace sslv
