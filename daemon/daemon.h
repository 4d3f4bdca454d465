// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/kept_files.h"
#include "web/route.h"

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace sslv {

/// The composition root: makes the services, wires them, starts and stops them in order. No logic of its own.
class Daemon {
 public:
  struct Options {
    std::filesystem::path settings_file, state_folder, panel_folder;
    std::vector<std::filesystem::path> file_folders{};  // besides its own, where the panel may name files
    std::vector<KeptFile> left{};  // cameras' last seconds of the run before, if that crashed
  };

  /// Running when it returns: sockets bound, panel answering, cameras opening. Throws SettingsError.
  explicit Daemon(Options options);
  ~Daemon();

  int panel_port() const;
  /// One line for the service manager and the log, at most a second old: cameras, rate, latency, where
  /// packets go. Does not wait for anything.
  std::string summary() const;
  /// Reads the settings file again and applies it; logs what came of it.
  void reload();
  /// Tells all that runs to end, and does not wait for it; the destructor does. Nothing is asked of it then.
  void ask_to_stop();
  /// Why the watchdog must not be fed; empty while all is well. Does not wait for anything.
  std::string hanging() const;

  /// All routes that the panel's server has.
  const std::vector<Route>& routes() const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace sslv
