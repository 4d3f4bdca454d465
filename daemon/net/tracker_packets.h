// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ssl_vision_wrapper_tracked.pb.h"
#include "tracking/tracks.h"

#include <cstddef>
#include <span>
#include <string>
#include <vector>

namespace sslv {

/// Who says it.
struct TrackerSource {
  std::string uuid, name;
};

/// Makes `packet` the packet of tracks, in metres. A kick is told as long as its ball is under way. `packet`
/// keeps its memory.
void write_tracked(const TrackedField& tracked, const TrackerSource& source, TrackerWrapperPacket& packet);

/// The packet's bytes; they lie in `buffer`, whose capacity is kept.
std::span<const std::byte> serialize(const TrackerWrapperPacket& packet, std::vector<std::byte>& buffer);

}  // namespace sslv
