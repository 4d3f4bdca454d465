// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ssl_vision_wrapper_tracked.pb.h"
#include "tracking/tracks.h"

#include <cstddef>
#include <span>
#include <string>
#include <vector>

namespace sslv {

/// Identifies the sender.
struct TrackerSource {
  std::string uuid, name;
};

/// Fills `packet` with tracks, in metres. Includes a kick while its ball is still moving. Reuses the memory
/// of `packet`.
void write_tracked(const TrackedField& tracked, const TrackerSource& source, TrackerWrapperPacket& packet);

/// The packet's bytes, stored in `buffer`, whose capacity is reused.
std::span<const std::byte> serialize(const TrackerWrapperPacket& packet, std::vector<std::byte>& buffer);

}  // namespace sslv
