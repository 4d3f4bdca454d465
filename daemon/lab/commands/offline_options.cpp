// SPDX-License-Identifier: Apache-2.0
#include "lab/commands/offline_options.h"

#include "config/stages.h"
#include "settings/store.h"

#include <cmath>
#include <cstdio>

#include <fmt/format.h>

namespace sslv {

const CLI::Validator kFinite(
    [](std::string& text) {
      double value = 0;
      return CLI::detail::lexical_cast(text, value) && std::isfinite(value) && value >= 0
                 ? std::string()
                 : "expected a number of at least 0";
    },
    "");

void add_stages_options(CLI::App* command, StageFolders& folders) {
  command->add_option("--stages", folders.inside,
                      "a folder of stage libraries (*.so), whose stages a stack may name");
  command->add_option("--stages-apart", folders.sandboxed,
                      "likewise; each of these stages runs in a process of its own");
}

void CameraChoice::add_to(CLI::App* command) {
  command->add_option("--settings", settings_file, "settings file")->required();
  command->add_option("--camera", camera_id, "id of the camera in it")->capture_default_str();
  add_stages_options(command, stage_folders);
}

void CameraChoice::add_lut_to(CLI::App* command) {
  command->add_option("--lut", lut_file, "colour table (.lut) to use instead of the one in the settings");
}

Config settings_in(const std::string& file) {
  try {
    return read_config(up_to_date(read_json_file(file), settings_migrations()));
  } catch (const SettingsError& error) {
    const std::string what = error.what();
    throw SettingsError(what.starts_with(file) ? what : file + ": " + what);
  }
}

Config CameraChoice::config() const {
  add_stage_libraries(stage_folders, MissingStages::kRefused);
  Config config = settings_in(settings_file);
  if (!lut_file.empty()) {
    ColorSettings& colors = config.cameras[index_in(config)].colors;
    colors.table.clear();
    colors.lut_file = lut_file;
  }
  return config;
}

std::size_t CameraChoice::index_in(const Config& config) const {
  std::string known;
  for (std::size_t i = 0; i < config.cameras.size(); ++i) {
    if (config.cameras[i].id == camera_id) return i;
    known += (known.empty() ? "" : ", ") + std::to_string(config.cameras[i].id);
  }
  throw SettingsError(fmt::format("{}: has no camera {}; known: {}", settings_file, camera_id,
                                  known.empty() ? "none" : known));
}

void RawFormat::add_to(CLI::App* command) {
  command->add_option(
      "--pixel-format", pixel_format,
      "of raw frames, such as uyvy or bayer_rg8; default: as a frames.json beside them tells");
  command->add_option("--size", size, "of raw frames, such as 780x580; likewise");
}

void RawFormat::parse() {
  if (size.empty()) return;
  char rest = 0;
  if (std::sscanf(size.c_str(), "%dx%d%c", &width, &height, &rest) != 2) {
    throw SettingsError(fmt::format("--size: \"{}\" is not allowed; expected WIDTHxHEIGHT", size));
  }
}

}  // namespace sslv
