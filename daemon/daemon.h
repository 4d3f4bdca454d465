// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/kept_files.h"
#include "web/route.h"

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace sslv {

/// The composition root: creates the services, connects them, and starts and stops them in order. It has no
/// logic of its own.
class Daemon {
 public:
  struct Options {
    std::filesystem::path settings_file, state_folder, panel_folder;
    std::vector<std::filesystem::path> file_folders{};  // further folders with files that the panel may name
    std::vector<KeptFile> left{};  // ring buffers of the cameras' images that a crashed run left
  };

  /// On return, sockets are bound, the panel answers, and cameras are being opened. Throws SettingsError.
  explicit Daemon(Options options);
  ~Daemon();

  int panel_port() const;
  /// One line for the service manager and the log, at most a second old: cameras, rate, latency, destination
  /// of the packets. Does not block.
  std::string summary() const;
  /// Reads the settings file again, applies it, and logs the result.
  void reload();
  /// Starts stopping all services without waiting; the destructor waits. Call only the destructor afterwards.
  void ask_to_stop();
  /// Why the watchdog must not be fed; empty while all is well. Does not block.
  std::string hanging() const;

  /// All routes of the panel's server.
  const std::vector<Route>& routes() const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace sslv
