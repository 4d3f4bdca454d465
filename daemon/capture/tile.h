// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "capture/source.h"

#include <functional>
#include <memory>
#include <string>

namespace sslv {

// A tile: a rectangle of a big camera's images, used as a camera of its own, without copying. All tiles of a
// big camera share one open camera. The caller decides which backends the big camera may use.

/// Returns the options with defaults filled in; `complete_source` does the same for the big camera's options.
/// Throws SettingsError, beginning with `path`.
Json complete_tile(const Json& options, const std::string& path,
                   Json (*complete_source)(const Json& source, const std::string& path));
Json tile_schema();
/// Opens a tile. Calls `open_source` for the big camera unless another tile has opened it, and throws the
/// exceptions of `open_source`.
std::unique_ptr<Source> open_tile(
    const Json& options, const std::function<std::unique_ptr<Source>(const Json& source)>& open_source);

/// Converts a tile's context to the big camera's: the same optics with a larger image.
SourceContext whole_camera(const Json& options, SourceContext context);

}  // namespace sslv
