// SPDX-License-Identifier: Apache-2.0
// TABLE capture backends. To add one: a file pair in capture/, a row here (docs/extending.md).
#include "cameras.h"

#include "base/error.h"
#include "capture/aravis.h"
#include "capture/dc1394.h"
#include "capture/file.h"
#include "capture/simulator.h"

#include <array>
#include <vector>

#include <fmt/format.h>

namespace sslv {

std::span<const Backend> backend_table() {
  static const std::array kBackends {
    aravis_backend(),
#if SSLV_HAVE_DC1394
        dc1394_backend(),
#endif
        file_backend(), simulator_backend(),
  };
  return kBackends;
}

std::span<const MissingBackend> missing_backends() {
  static const std::vector<MissingBackend> kMissing {
#if !SSLV_HAVE_DC1394
    {"dc1394", "libdc1394-dev"},
#endif
  };
  return kMissing;
}

const Backend& find_backend(const std::string& name, const std::string& path) {
  return find_backend(backend_table(), missing_backends(), name, path);
}

const Backend& find_backend(std::span<const Backend> backends, std::span<const MissingBackend> missing,
                            const std::string& name, const std::string& path) {
  std::string known;
  for (const Backend& backend : backends) {
    if (backend.name == name) return backend;
    known += (known.empty() ? "" : ", ") + std::string(backend.name);
  }
  for (const MissingBackend& backend : missing) {
    if (backend.name != name) continue;
    throw SettingsError(
        fmt::format("{}: capture backend \"{}\" is not in this program; to build it in, install {} and build "
                    "again; known: {}",
                    path, name, backend.package, known));
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

}  // namespace sslv
