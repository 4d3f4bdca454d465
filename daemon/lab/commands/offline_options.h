// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "config/config.h"

#include <cstddef>
#include <string>

#include <CLI/CLI.hpp>

namespace sslv {

/// Options that select a camera, for tools that work on files.
struct CameraChoice {
  std::string settings_file;
  int camera_id = 0;
  std::string lut_file;  // empty: the camera's own colours
  StageFolders stage_folders;

  void add_to(CLI::App* command);
  void add_lut_to(CLI::App* command);
  /// These throw SettingsError, beginning with the file's name. Call config() once: it loads stage libraries.
  Config config() const;
  std::size_t index_in(const Config& config) const;
};

/// --stages and --stages-apart, of every command that runs a stack.
void add_stages_options(CLI::App* command, StageFolders& folders);

/// Reads a settings file, also of an earlier version. Throws SettingsError, beginning with the file's name.
Config settings_in(const std::string& file);

/// A number of at least 0. Ranges of CLI11 accept NaN.
extern const CLI::Validator kFinite;

/// How to read raw frames.
struct RawFormat {
  std::string pixel_format, size;
  int width = 0, height = 0;  // set by parse()

  void add_to(CLI::App* command);
  /// Throws SettingsError.
  void parse();
};

}  // namespace sslv
