// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "capture/source.h"

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace sslv {

/// Every capture backend a camera's "source" may name.
std::span<const Backend> backend_table();

/// A backend that this program was built without, for want of a library.
struct MissingBackend {
  std::string_view name;
  std::string_view package;  // of Debian, that brings the library when building
};
std::span<const MissingBackend> missing_backends();

/// The named backend; throws SettingsError, beginning with `path`, that lists the known ones or says what a
/// missing one needs.
const Backend& find_backend(const std::string& name, const std::string& path);
const Backend& find_backend(std::span<const Backend> backends, std::span<const MissingBackend> missing,
                            const std::string& name, const std::string& path);

/// A camera's "source" with its backend's defaults written out. Throws SettingsError, beginning with `path`.
Json complete_source(const Json& source, const std::string& path);

/// The camera of a complete "source": itself, or that of which a tile shows a part.
const Json& camera_source(const Json& source);

/// What tells the camera or folder of a complete "source" from others; one of its controls does not.
std::string device_of(const Json& source);

/// Opens what a complete "source" says. Throws CaptureError.
std::unique_ptr<Source> open_source(const Json& source, const SourceContext& context);

/// Cameras that could be opened now, of all backends. Takes about a second.
std::vector<FoundCamera> found_cameras();
/// One as docs/openapi.json has it, but for what uses it.
Json found_camera_json(const FoundCamera& found);
/// All names by which the settings may call the camera that this source opens, those of `found` among them. A
/// source without a name opens the first one that is found.
std::vector<std::string> names_of_camera(const Json& source, std::span<const FoundCamera> found);
/// Those for a terminal, with the settings lines to paste.
std::string found_cameras_text(const Json& found);

}  // namespace sslv
