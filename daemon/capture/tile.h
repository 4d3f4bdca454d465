// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "capture/source.h"

#include <functional>
#include <memory>
#include <string>

namespace sslv {

// A part of a big camera's images as a camera of its own, without copying. Tiles of the same camera share
// it. What kind of camera that may be is the caller's to know.

/// Options with defaults filled in; `complete_source` does that for the big camera's. Throws SettingsError,
/// beginning with `path`.
Json complete_tile(const Json& options, const std::string& path,
                   Json (*complete_source)(const Json& source, const std::string& path));
Json tile_schema();
/// `open_source` opens the big camera, when no other tile has; throws what that throws.
std::unique_ptr<Source> open_tile(
    const Json& options, const std::function<std::unique_ptr<Source>(const Json& source)>& open_source);

/// What the big camera sees, where `context` says what the tile sees: the same optics, other edges.
SourceContext whole_camera(const Json& options, SourceContext context);

}  // namespace sslv
