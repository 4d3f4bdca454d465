// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "capture/files/recording.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

namespace sslv {

/// The frames of one camera of a clip (docs/recording.md), as they were recorded. `camera_id`: none for the
/// first that has frames. Throws std::runtime_error with one line for what is no clip, and for a camera that
/// is not in it.
std::unique_ptr<Recording> open_clip(const std::string& path, std::optional<std::uint32_t> camera_id);

}  // namespace sslv
