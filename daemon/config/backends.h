// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "capture/source.h"

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace sslv {

/// Every capture backend that a camera's "source" may name.
std::span<const Backend> backend_table();

/// A backend that this program was built without because its library was missing.
struct MissingBackend {
  std::string_view name;
  std::string_view package;  // Debian package of the library for building
};
std::span<const MissingBackend> missing_backends();

/// Returns the named backend. Throws SettingsError, beginning with `path`, that lists the known backends or
/// names the package that a missing backend needs.
const Backend& find_backend(const std::string& name, const std::string& path);
const Backend& find_backend(std::span<const Backend> backends, std::span<const MissingBackend> missing,
                            const std::string& name, const std::string& path);

/// Returns a camera's "source" with its backend's defaults filled in. Throws SettingsError, beginning with
/// `path`.
Json complete_source(const Json& source, const std::string& path);

/// Returns the camera of a complete "source": the source itself or, for a tile, the source of the whole
/// image.
const Json& camera_source(const Json& source);

/// Identifies the camera or folder of a complete "source", independently of its controls.
std::string device_of(const Json& source);

/// Opens a complete "source". Throws CaptureError.
std::unique_ptr<Source> open_source(const Json& source, const SourceContext& context);

/// Returns the cameras of all backends that could be opened now. Takes about a second.
std::vector<FoundCamera> found_cameras();
/// Returns a found camera as in docs/openapi.json, but without its users.
Json found_camera_json(const FoundCamera& found);
/// Returns all names that the settings may use for the camera that this source opens, including those in
/// `found`. A source without a name opens the first camera found.
std::vector<std::string> names_of_camera(const Json& source, std::span<const FoundCamera> found);

}  // namespace sslv
