// SPDX-License-Identifier: Apache-2.0
// TABLE capture backends. To add one: a file pair in capture/, a row here (docs/extending.md).
#include "config/backends.h"

#include "base/error.h"
#include "capture/aravis/aravis.h"
#include "capture/dc1394/dc1394.h"
#include "capture/files/file.h"
#include "capture/simulator/simulator.h"
#include "capture/tile.h"
#include "capture/v4l2/v4l2.h"

#include <algorithm>
#include <utility>
#include <vector>

#include <fmt/format.h>

namespace sslv {

namespace {

/// A tile may be part of a camera of any other backend.
Backend tile_of_backends() {
  return {
      "tile",
      "a part of a big camera's images",
      [](const Json& options, const std::string& path) {
        return complete_tile(options, path, complete_source);
      },
      tile_schema,
      [](const Json& options, const SourceContext& context) {
        return open_tile(options,
                         [&](const Json& of) { return open_source(of, whole_camera(options, context)); });
      },
      [] { return std::vector<FoundCamera>{}; },
  };
}

}  // namespace

std::span<const Backend> backend_table() {
  // clang-format off
  static const std::vector<Backend> kBackends{
      aravis_backend(),
#if SSLV_HAVE_DC1394
      dc1394_backend(),
#endif
      file_backend(),
      simulator_backend(),
      tile_of_backends(),
      v4l2_backend(),
  };
  // clang-format on
  return kBackends;
}

std::span<const MissingBackend> missing_backends() {
  // clang-format off
  static const std::vector<MissingBackend> kMissing{
#if !SSLV_HAVE_DC1394
      {"dc1394", "libdc1394-dev"},
#endif
  };
  // clang-format on
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
                    path, shortened(name), backend.package, known));
  }
  throw SettingsError(fmt::format("{}: no capture backend \"{}\"; known: {}", path, shortened(name), known));
}

Json complete_source(const Json& source, const std::string& path) {
  if (!source.contains("backend") || !source["backend"].is_string()) {
    throw SettingsError(path + "/backend: is missing; expected a capture backend's name");
  }
  const std::string name = source["backend"].get<std::string>();
  Json options = source;
  options.erase("backend");
  const Json complete = find_backend(name, path + "/backend").complete(options, path);
  Json out{{"backend", name}};
  out.update(complete);
  return out;
}

const Json& camera_source(const Json& source) {
  return source.at("backend") == "tile" ? camera_source(source.at("of")) : source;
}

std::string device_of(const Json& source) {
  const Json& camera = camera_source(source);
  return fmt::format("{} {}{}", camera.at("backend").get<std::string>(), camera.value("camera", ""),
                     camera.value("path", ""));
}

std::unique_ptr<Source> open_source(const Json& source, const SourceContext& context) {
  Json options = source;
  options.erase("backend");
  return find_backend(source.at("backend").get<std::string>(), "/source").open(options, context);
}

std::vector<FoundCamera> found_cameras() {
  std::vector<FoundCamera> out;
  for (const Backend& backend : backend_table()) {
    for (FoundCamera& found : backend.list()) out.push_back(std::move(found));
  }
  return out;
}

std::vector<std::string> names_of_camera(const Json& source, std::span<const FoundCamera> found) {
  const std::string name = source.value("camera", "");
  for (const FoundCamera& one : found) {
    if (one.source.at("backend") != source.at("backend")) continue;
    std::vector<std::string> names = one.other_names;
    names.push_back(one.source.value("camera", ""));
    if (name.empty() || std::ranges::find(names, name) != names.end()) return names;
  }
  return {name};
}

Json found_camera_json(const FoundCamera& found) {
  return {{"backend", found.source.at("backend")},
          {"name", found.name},
          {"model", found.model},
          {"serial", found.serial},
          {"formats", found.formats},
          {"source", found.source}};
}

}  // namespace sslv
