// SPDX-License-Identifier: Apache-2.0
#include "pipeline/pipeline.h"

#include "base/clock.h"

#include <algorithm>
#include <array>

#include <fmt/format.h>

namespace sslv {
namespace {

std::string part_name(std::size_t index) {
  static constexpr auto kNames =
      std::apply([](const auto&... part) { return std::array{part.name...}; }, kParts);
  return std::string(kNames[index]);
}

const StageType& find_stage(std::span<const StageType> table, const std::string& name,
                            const std::string& path) {
  const auto found =
      std::find_if(table.begin(), table.end(), [&](const StageType& type) { return type.name == name; });
  if (found != table.end()) return *found;
  std::string known;
  for (const StageType& type : table) known += (known.empty() ? "" : ", ") + std::string(type.name);
  throw SettingsError(fmt::format("{}: unknown stage '{}'; known: {}", path, shortened(name), known));
}

}  // namespace

std::vector<const StageType*> check_stack(std::span<const StageType> table,
                                          const std::vector<std::string>& stack, const std::string& path) {
  // Capture provides these two.
  PartSet have = PartSet{}.set(part_index<FrameInfo>()).set(part_index<Image>());
  std::array<std::string, kPartCount> writer;
  std::vector<const StageType*> stages;
  for (std::size_t s = 0; s < stack.size(); ++s) {
    const std::string here = fmt::format("{}/{}", path, s);
    const StageType& type = find_stage(table, stack[s], here);
    if (std::count(stack.begin(), stack.end(), stack[s]) > 1) {
      throw SettingsError(fmt::format("{}: stage '{}' is in the stack twice", here, stack[s]));
    }
    for (std::size_t i = 0; i < kPartCount; ++i) {
      if (type.reads[i] && !have[i]) {
        throw SettingsError(fmt::format("{}: stage '{}' needs '{}', which no earlier stage provides", here,
                                        type.name, part_name(i)));
      }
      if (type.writes[i] && have[i]) {
        throw SettingsError(fmt::format("{}: stage '{}' would overwrite '{}', which {} provides", here,
                                        type.name, part_name(i),
                                        writer[i].empty() ? "the camera" : "'" + writer[i] + "'"));
      }
      if (type.writes[i]) writer[i] = type.name;
    }
    have |= type.writes;
    stages.push_back(&type);
  }
  return stages;
}

Pipeline::Pipeline(std::span<const StageType> table, const std::vector<std::string>& stack,
                   const std::string& path)
    : table_(table), stack_(stack) {
  for (const StageType* type : check_stack(table, stack, path))
    steps_.push_back(std::make_unique<Running>(*type));
}

Pipeline::Parameters Pipeline::parameters_of(const std::vector<StageParams>& params) const {
  Parameters parameters;
  for (const auto& step : steps_)
    parameters.push_back(params[static_cast<std::size_t>(step->type - table_.data())]);
  return parameters;
}

Pipeline::Parameters Pipeline::make_parameters(const Json& stages, const std::string& path) const {
  return parameters_of(read_stages(table_, stages, path).params);
}

void Pipeline::run(Frame& frame, const CameraContext& context, DetectionSink& sink,
                   const Parameters& parameters) noexcept {
  const Inputs inputs{frame, context, sink};
  frame.stage_ns.resize(steps_.size());
  std::int64_t before = steady_ns();
  for (std::size_t i = 0; i < steps_.size(); ++i) {
    steps_[i]->step->run(inputs, parameters[i].get());
    const std::int64_t after = steady_ns();
    frame.stage_ns[i] = after - before;
    steps_[i]->durations.add_ns(after - before);
    sink.stage_took(static_cast<std::size_t>(steps_[i]->type - table_.data()), after - before);
    before = after;
  }
}

StageSettings read_stages(std::span<const StageType> table, const Json& stages, const std::string& path) {
  if (!stages.is_object()) refuse(path, stages, "an object of stages");
  for (const auto& item : stages.items()) {
    if (item.key() != kCommentKey) find_stage(table, item.key(), path + "/" + shortened(item.key()));
  }
  StageSettings out{Json::object(), {}};
  for (const StageType& type : table) {
    const std::string name(type.name);
    StageType::Parsed parsed =
        type.parse(stages.contains(name) ? stages.at(name) : Json::object(), path + "/" + name);
    out.complete[name] = std::move(parsed.complete);
    out.params.push_back(std::move(parsed.params));
  }
  return out;
}

}  // namespace sslv
