// SPDX-License-Identifier: Apache-2.0
// TABLE capture backends. To add one: a file pair in capture/, a row here (docs/extending.md).
#include "cameras.h"

#include "base/error.h"
#include "capture/aravis.h"
#include "capture/file.h"
#include "capture/simulator.h"
#include "capture/v4l2.h"

#include <array>

#include <fmt/format.h>

namespace sslv {

std::span<const Backend> backend_table() {
  static const std::array kBackends{
      aravis_backend(),
      file_backend(),
      simulator_backend(),
      v4l2_backend(),
  };
  return kBackends;
}

const Backend& find_backend(const std::string& name, const std::string& path) {
  std::string known;
  for (const Backend& backend : backend_table()) {
    if (backend.name == name) return backend;
    known += (known.empty() ? "" : ", ") + std::string(backend.name);
  }
  throw SettingsError(fmt::format("{}: no capture backend \"{}\"; known: {}", path, name, known));
}

Json found_cameras_json() {
  Json out = Json::array();
  for (const Backend& backend : backend_table()) {
    for (const FoundCamera& found : backend.list()) {
      out.push_back({{"backend", backend.name},
                     {"name", found.name},
                     {"model", found.model},
                     {"serial", found.serial},
                     {"formats", found.formats},
                     {"source", found.source}});
    }
  }
  return out;
}

std::string found_cameras_text(const Json& found) {
  std::string out;
  for (const Json& source : found) {
    out += fmt::format("{}\n  \"source\": {}\n", source.at("name").get<std::string>(),
                       source.at("source").dump());
    std::string formats;
    for (const Json& format : source.at("formats"))
      formats += (formats.empty() ? "" : ", ") + format.get<std::string>();
    if (!formats.empty()) out += "  pixel formats: " + formats + "\n";
  }
  return out.empty()
             ? "No camera found. Check power, cable and network; GigE cameras must have an address of "
               "your network.\n"
             : out;
}

}  // namespace sslv
