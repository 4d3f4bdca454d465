// SPDX-License-Identifier: Apache-2.0
#include "config/config.h"

#include "base/params_json.h"
#include "capture/simulator/simulator_options.h"
#include "config/backends.h"
#include "pipeline/pipeline.h"
#include "vision/field_view.h"

#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>
#include <map>
#include <set>
#include <utility>

#include <boost/asio/ip/address_v4.hpp>
#include <fmt/format.h>

namespace sslv {
namespace {

std::string camera_path(std::size_t i) {
  return fmt::format("/cameras/{}", i);
}

/// Throws SettingsError if simulated cameras together have more pixels than fit into a computer's memory.
/// Tiles of one camera count once.
void check_simulated(const std::vector<CameraSettings>& cameras) {
  std::set<std::string> counted;
  std::int64_t pixels = 0;
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const Json& source = cameras[i].source;
    const bool is_tile = source.at("backend") == "tile";
    const Json& whole = is_tile ? source.at("of") : source;
    if (whole.at("backend") != "simulator" || (is_tile && !counted.insert(json_text(whole)).second)) continue;
    pixels += whole.at("width").get<std::int64_t>() * whole.at("height").get<std::int64_t>();
    if (pixels <= SimulatorOptions::kMaxPixelsOfAll) continue;
    throw SettingsError(
        fmt::format("{}/source: simulated cameras of {} pixels together are not allowed; expected at most {}",
                    camera_path(i), pixels, SimulatorOptions::kMaxPixelsOfAll));
  }
}

/// From version 1 to 2: renames the limits of follow_light to max_ and min_.
void rename_light_limits(Json& tree) {
  constexpr std::array<std::pair<const char*, const char*>, 5> kNames{
      {{"most_brightness", "max_brightness"},
       {"most_balance", "max_balance"},
       {"most_brightness_per_min", "max_brightness_per_min"},
       {"most_balance_per_min", "max_balance_per_min"},
       {"least_robots", "min_robots"}}};
  if (!tree.is_object() || !tree.contains("cameras") || !tree["cameras"].is_array()) return;
  for (Json& camera : tree["cameras"]) {
    if (!camera.is_object() || !camera.contains("follow_light")) continue;
    Json& light = camera["follow_light"];
    if (!light.is_object()) continue;
    for (const auto& [old_name, new_name] : kNames) {
      // Validation refuses a tree with both keys.
      if (!light.contains(old_name) || light.contains(new_name)) continue;
      Json value = std::move(light[old_name]);
      light.erase(old_name);
      light[new_name] = std::move(value);
    }
  }
}

/// Only named computers contribute to the tracks now. The earlier setting (all or none) named no computer.
void name_other_computers(Json& tree) {
  if (!tree.is_object() || !tree.contains("field") || !tree["field"].is_object()) return;
  Json& field = tree["field"];
  if (field.contains("other_computers") && field["other_computers"].is_boolean())
    field["other_computers"] = Json::array();
}

/// The buffer of the cameras' newest images (last_seconds) no longer supports partial images.
void keep_whole_images(Json& tree) {
  const Json::json_pointer images("/recording/last_seconds/images");
  if (tree.is_object() && tree.contains(images) && tree[images] == "found") tree[images] = "whole";
}

/// Removes a width of 0: settings are stored with all keys, so 0 is the old default; in the rules, every
/// field has this area.
void forget_missing_substitution_area(Json& tree) {
  const std::string key = "goal_substitution_area_width";
  if (!tree.is_object() || !tree.contains("field") || !tree["field"].is_object()) return;
  Json& field = tree["field"];
  if (field.contains(key) && field[key] == 0) field.erase(key);
}

void to_version_3(Json& tree) {
  name_other_computers(tree);
  forget_missing_substitution_area(tree);
  keep_whole_images(tree);
}

/// Throws SettingsError, beginning with `path`, for a text that is not the IPv4 address of a computer.
void check_computers(const std::vector<std::string>& addresses, const std::string& path) {
  for (std::size_t i = 0; i < addresses.size(); ++i) {
    boost::system::error_code error;
    const auto address = boost::asio::ip::make_address_v4(addresses[i], error);
    if (error || address.is_multicast() || address.to_uint() == 0 || address.to_string() != addresses[i])
      refuse(fmt::format("{}/{}", path, i), addresses[i], "the IPv4 address of a computer, such as 10.0.0.2");
  }
}

/// Determines which stages of a camera's or the field's stack run, and their parameters.
template <class Floor, class Part>
void read_stack(Part& part, std::span<const BasicStageType<Floor>> table, const std::string& path,
                MissingStages missing) {
  StageSettings stages = read_stages(table, part.stages, path + "/stages", missing);
  part.running = running_stack(table, part.stack, path + "/stack", missing, std::move(stages.refused));
  part.stages = std::move(stages.complete);
  part.stage_params = std::move(stages.params);
}

}  // namespace

Config read_config(const Json& settings) {
  auto config = params_from_json<Config>(settings, "");
  check_field(config.field, "/field");
  check_computers(config.field.other_computers, "/field/other_computers");
  check_multicast(config.network.vision, "/network/vision");
  check_group(config.network.referee.group, "/network/referee/group");
  static_cast<void>(LabelSet(config.own_labels, "/own_labels"));  // refuses bad names
  check_group(config.network.tracker.group, "/network/tracker/group");
  const MissingStages missing = missing_stages();
  read_stack<FieldFloor>(config.field, field_stage_table(), "/field", missing);
  std::map<int, std::size_t> camera_with_id;
  for (std::size_t i = 0; i < config.cameras.size(); ++i) {
    CameraSettings& camera = config.cameras[i];
    const std::string path = camera_path(i);
    const auto [first, is_new] = camera_with_id.emplace(camera.id, i);
    if (!is_new) {
      throw SettingsError(fmt::format("{}/id: {} is the id of {} already; every camera needs its own", path,
                                      camera.id, camera_path(first->second)));
    }
    camera.source = complete_source(camera.source, path + "/source");
    check_mask(camera.mask, path + "/mask");
    if (camera.calibration) CameraModel(*camera.calibration, path + "/calibration");
    read_stack<CameraFloor>(camera, stage_table(), path, missing);
  }
  check_simulated(config.cameras);
  return config;
}

const Migrations& settings_migrations() {
  static const Migrations kMigrations{rename_light_limits, to_version_3};
  return kMigrations;
}

Json complete_settings(const Json& settings) {
  return params_to_json(read_config(settings));
}

namespace {

/// Adds the names and parameters of a table's stages to the schema, which until then allows any texts and
/// objects.
template <class Floor>
void add_stages(std::span<const BasicStageType<Floor>> table, Json& of_stack, Json& of_stages) {
  of_stages["additionalProperties"] = false;
  for (const BasicStageType<Floor>& type : table) {
    Json one = type.schema();
    one["description"] = type.help;
    of_stages["properties"][std::string(type.name)] = std::move(one);
    of_stack["items"]["enum"].push_back(type.name);
  }
}

}  // namespace

Json settings_schema() {
  Json schema = params_schema<Config>();
  schema["$schema"] = "https://json-schema.org/draft/2020-12/schema";
  schema["title"] = "ssl-visiond settings";
  Json& camera = schema["properties"]["cameras"]["items"]["properties"];
  add_stages(stage_table(), camera["stack"], camera["stages"]);
  Json& field = schema["properties"]["field"]["properties"];
  add_stages(field_stage_table(), field["stack"], field["stages"]);
  camera["source"].erase("additionalProperties");
  for (const Backend& backend : backend_table()) {
    Json one = backend.schema();
    one["title"] = backend.name;
    one["description"] = backend.help;
    one["properties"]["backend"] = {{"const", backend.name}};
    camera["source"]["oneOf"].push_back(std::move(one));
  }
  return schema;
}

BallModel ball_model_of(const Config& config) {
  BallModel out;
  out.radius_mm = config.field.ball_radius;
  out.half_length_mm = config.field.field_length / 2.0;
  out.half_width_mm = config.field.field_width / 2.0;
  if (!config.ball_models) return out;
  constexpr double kMmPerMeter = 1000;
  const BallModels& models = *config.ball_models;
  out.slides_mm_s2 = -models.acc_slide * kMmPerMeter;
  out.rolls_mm_s2 = -models.acc_roll * kMmPerMeter;
  out.rolls_from_share = models.k_switch;
  out.first_hop_xy = models.damping_xy_first_hop;
  out.later_hops_xy = models.damping_xy_other_hops;
  out.hops_z = models.damping_z;
  return out;
}

CameraContext make_context(const Config& config, std::size_t i, std::shared_ptr<const Lut> lut,
                           const LoadTable& load_table, std::shared_ptr<const PatternTable> patterns) {
  const CameraSettings& camera = config.cameras[i];
  const auto labels = std::make_shared<const LabelSet>(config.own_labels, "/own_labels");
  auto scene = std::make_shared<Scene>();
  scene->field = config.field;
  if (camera.calibration) scene->camera.emplace(*camera.calibration, camera_path(i) + "/calibration");
  for (const auto& [team, settings] :
       {std::pair{Team::kYellow, &config.teams.yellow}, {Team::kBlue, &config.teams.blue}}) {
    const auto index = static_cast<std::size_t>(team);
    scene->robot_height_mm[index] = settings->robot_height;
    for (const int id : settings->ids) scene->roster[index].set(static_cast<std::size_t>(id));
  }

  if (patterns) {
    // The caller passed them.
  } else if (config.patterns_file.empty()) {
    patterns = std::shared_ptr<const PatternTable>(&league_patterns(), [](const PatternTable*) {});
  } else {
    std::ifstream in(config.patterns_file, std::ios::binary);
    if (!in) {
      throw SettingsError(
          fmt::format("/patterns_file: cannot read \"{}\": {}", config.patterns_file, std::strerror(errno)));
    }
    const std::string text{std::istreambuf_iterator<char>(in), {}};
    patterns = std::make_shared<const PatternTable>(parse_patterns(text, config.patterns_file, *labels));
  }
  const std::string colors_path = camera_path(i) + "/colors";
  if (!lut && !camera.colors.table.empty() && !load_table) {
    throw SettingsError(
        fmt::format("{}/table: \"{}\" is stored with the settings of the service that saved it; move "
                    "settings with their tables to another computer with ssl-visionctl backup and restore, "
                    "or export the table there and name the file in lut_file or with --lut",
                    colors_path, camera.colors.table));
  }
  if (!lut && !camera.colors.table.empty())
    lut = load_table(camera.colors.table, colors_path + "/table", *labels);
  if (!lut) lut = make_lut(camera.colors, colors_path, *labels);
  lut = with_bits(std::move(lut), camera.colors.bits);
  CameraContext context{std::move(scene),    std::move(lut), std::make_shared<const Mask>(camera.mask),
                        std::move(patterns), nullptr,        labels};
  context.accepted_lut = context.adapted_lut;
  if (context.scene->camera && camera.mask.beyond_boundary) {
    context.field_view =
        std::make_shared<const FieldView>(field_view(*context.scene, *camera.mask.beyond_boundary));
    context.stage_mask = std::make_shared<const Mask>(camera.mask, *context.field_view);
  }
  return context;
}

}  // namespace sslv
