// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "capture/source.h"

#include <string>
#include <vector>

namespace sslv {

/// What Aravis opens the camera by that an admin calls by its serial number, IP address or Aravis id; empty:
/// the first. Throws CaptureError naming those that are there.
std::string resolve_aravis_camera(const std::string& camera);

std::vector<FoundCamera> list_aravis_cameras();

}  // namespace sslv
