// SPDX-License-Identifier: Apache-2.0
#include "replay/clip_setup.h"

#include "base/params_json.h"
#include "settings/migrations.h"
#include "vision/lut_codec.h"
#include "vision/patterns_text.h"

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include <fmt/format.h>

namespace sslv {
namespace {

/// Removes stages that do not run because their library is missing: they did not affect the detections.
template <class Part, class Table>
void keep_running(Part& part, const Table& table) {
  part.stack = part.running.stages;
  Json known = Json::object();
  for (const auto& type : table) {
    const std::string name(type.name);
    if (part.stages.contains(name)) known[name] = part.stages[name];
  }
  part.stages = std::move(known);
}

const LabelSet& labels_of(const CameraContext& context) {
  return context.labels ? *context.labels : LabelSet::built_in();
}

struct SetupTable {
  std::shared_ptr<const Lut> lut;  // null: the settings' table
  /// Whether `lut` was used live. It may then be adapted to the light and differ from the settings' table.
  bool is_live = false;
};

/// A clip's setup, validated.
struct SetupParts {
  Config config;  // with one camera
  SetupTable table;
  std::shared_ptr<const PatternTable> patterns;  // null: the league's patterns
  std::array<double, 2> robot_height_mm{};
};

std::array<double, 2> heights_in(const Json& about, const std::string& path) {
  constexpr double kMinMm = 1, kMaxMm = 10'000;
  const std::string here = path + "/robot_height_mm";
  if (!about.contains("robot_height_mm")) throw SettingsError(here + ": is missing");
  const Json& json = about.at("robot_height_mm");
  if (!json.is_array() || json.size() != 2) refuse(here, json, "two numbers");
  std::array<double, 2> out{};
  for (std::size_t i = 0; i < 2; ++i)
    out[i] = read_number<double>(json[i], here + "/" + std::to_string(i), kMinMm, kMaxMm, "mm");
  return out;
}

Config config_in(const Json& about, int camera_id) {
  if (!about.is_object() || !about.contains("settings") || !about.at("settings").is_object())
    throw SettingsError("/settings: is missing; expected an object");
  Json tree = up_to_date(about.at("settings"), settings_migrations());
  // No source is opened, and this program may have been built without the camera's backend.
  if (tree.contains("cameras") && tree["cameras"].is_array()) {
    for (Json& camera : tree["cameras"])
      if (camera.is_object()) camera.erase("source");
  }
  Config config = read_config(tree);
  if (config.cameras.size() != 1 || config.cameras[0].id != camera_id)
    throw SettingsError(fmt::format("/cameras: expected camera {} alone", camera_id));
  return config;
}

SetupParts parts_of(const ClipSetup& clip, const std::string& path) {
  // Messages about the settings begin with a place in the settings; prepend `path`.
  const auto named = [&](const auto& read) {
    try {
      return read();
    } catch (const SettingsError& error) {
      throw SettingsError(path + ": " + error.what());
    }
  };
  SetupParts out;
  out.config = named([&] { return config_in(clip.about, clip.camera_id); });
  out.robot_height_mm = named([&] { return heights_in(clip.about, ""); });
  const LabelSet labels(out.config.own_labels, path + ": /own_labels");
  if (clip.about.contains("patterns") && !clip.about.at("patterns").is_null()) {
    const Json& text = clip.about.at("patterns");
    if (!text.is_string()) named([&]() -> int { refuse("/patterns", text, "a text or null"); });
    out.patterns = std::make_shared<const PatternTable>(
        parse_patterns(text.get<std::string>(), path + ": /patterns", labels));
  } else {
    // The clip does not have the file's text. Do not read the file: it may have changed since.
    out.config.patterns_file.clear();
  }
  if (!clip.table.empty()) {
    const auto* bytes = reinterpret_cast<const std::uint8_t*>(clip.table.data());
    out.table = {
        std::make_shared<const Lut>(decode_lut({bytes, clip.table.size()}, path + ": /table", labels)), true};
  }
  return out;
}

/// `i`: index in config.cameras.
CameraSetup make_clip_setup(const Config& config, std::size_t i, const SetupTable& table,
                            std::shared_ptr<const PatternTable> patterns,
                            const std::array<double, 2>& robot_height_mm,
                            std::shared_ptr<Pipeline> pipeline) {
  const CameraSettings& camera = config.cameras[i];
  CameraSetup setup;
  if (pipeline && pipeline->stack() == camera.running.stages) {
    setup.pipeline = std::move(pipeline);
  } else {
    setup.pipeline =
        std::make_shared<Pipeline>(stage_table(), camera.running.stages, fmt::format("/cameras/{}/stack", i));
  }
  setup.parameters = setup.pipeline->parameters_of(camera.stage_params);
  setup.context = make_context(config, i, table.lut, {}, std::move(patterns));
  if (table.is_live) setup.context.adapted_lut = setup.context.accepted_lut = table.lut;
  Scene scene = *setup.context.scene;
  scene.robot_height_mm = robot_height_mm;
  setup.context.scene = std::make_shared<const Scene>(std::move(scene));
  return setup;
}

bool same_colors(const Config& a, const CameraSettings& camera_a, const Config& b,
                 const CameraSettings& camera_b) {
  const auto all_of = [](const Config& config, const CameraSettings& camera) {
    Json out{{"colors", params_to_json(camera.colors)}, {"labels", Json::array()}};
    for (const OwnLabel& label : config.own_labels) out["labels"].push_back(params_to_json(label));
    return out;
  };
  return all_of(a, camera_a) == all_of(b, camera_b);
}

}  // namespace

ClipSetup clip_setup(const Config& config, std::size_t i, const CameraSetup& setup) {
  Config alone = config;
  alone.cameras = {config.cameras[i]};
  keep_running(alone.cameras[0], stage_table());
  keep_running(alone.field, field_stage_table());
  const CameraContext& context = setup.context;
  ClipSetup out;
  out.camera_id = alone.cameras[0].id;
  Json settings{{kVersionKey, newest_version(settings_migrations())}};
  settings.update(params_to_json(alone));
  out.about = {{"settings", std::move(settings)},
               {"robot_height_mm", context.scene->robot_height_mm},
               {"patterns", nullptr}};
  // Store the patterns in use, not the file's content: the file may have changed since it was read.
  if (!config.patterns_file.empty())
    out.about["patterns"] = patterns_text(*context.patterns, labels_of(context));
  const std::vector<std::uint8_t> table = lut_file_bytes(*context.adapted_lut, labels_of(context));
  const auto* bytes = reinterpret_cast<const std::byte*>(table.data());
  out.table.assign(bytes, bytes + table.size());
  return out;
}

CameraSetup setup_of(const ClipSetup& clip, std::shared_ptr<Pipeline> pipeline, const std::string& path) {
  SetupParts parts = parts_of(clip, path);
  try {
    return make_clip_setup(parts.config, 0, parts.table, std::move(parts.patterns), parts.robot_height_mm,
                           std::move(pipeline));
  } catch (const SettingsError& error) {
    throw SettingsError(path + ": " + error.what());
  }
}

CameraSetup setup_with(const OtherSetup& other, const ClipSetup& clip, std::shared_ptr<Pipeline> pipeline,
                       const std::string& path) {
  SetupParts live = parts_of(clip, path);
  if (!other.settings) {
    try {
      return make_clip_setup(live.config, 0, other.table ? SetupTable{other.table} : live.table,
                             live.patterns, live.robot_height_mm, std::move(pipeline));
    } catch (const SettingsError& error) {
      throw SettingsError(path + ": " + error.what());
    }
  }
  const Config& config = *other.settings;
  const auto camera = std::ranges::find(config.cameras, clip.camera_id, &CameraSettings::id);
  if (camera == config.cameras.end())
    throw SettingsError(fmt::format("{}: has no camera {}, which the clip has", other.path, clip.camera_id));
  SetupTable table{other.table};
  if (!table.lut && same_colors(config, *camera, live.config, live.config.cameras[0])) table = live.table;
  std::array<double, 2> heights{config.teams.yellow.robot_height, config.teams.blue.robot_height};
  const std::array<double, 2> live_settings{live.config.teams.yellow.robot_height,
                                            live.config.teams.blue.robot_height};
  for (std::size_t team = 0; team < heights.size(); ++team) {
    const bool was_told = live.robot_height_mm[team] != live_settings[team];
    if (was_told && config.teams.height_from_referee) heights[team] = live.robot_height_mm[team];
  }
  try {
    return make_clip_setup(config, static_cast<std::size_t>(camera - config.cameras.begin()), table, nullptr,
                           heights, std::move(pipeline));
  } catch (const SettingsError& error) {
    throw SettingsError(other.path + ": " + error.what());
  }
}

}  // namespace sslv
