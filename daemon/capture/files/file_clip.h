// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "capture/files/recording.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

namespace sslv {

/// The frames of one camera of a clip (docs/recording.md), as recorded. Without `camera_id`: the first camera
/// that has frames. Throws std::runtime_error with one line if the file is not a clip or has no frames of the
/// camera.
std::unique_ptr<Recording> open_clip(const std::string& path, std::optional<std::uint32_t> camera_id);

}  // namespace sslv
