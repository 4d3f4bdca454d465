// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "capture/source.h"

#include <filesystem>

namespace sslv {

/// The kind of a file, from the extension of its name.
enum class RecordingKind { kImage, kRaw, kVideo, kClip, kOther };
RecordingKind recording_kind(const std::filesystem::path& file);

/// "files": recorded images (PNG, JPEG, BMP, PPM), raw frames, a video or a clip as a camera.
Backend file_backend();

}  // namespace sslv
