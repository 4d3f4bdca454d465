// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "capture/aravis/aravis_library.h"
#include "capture/source.h"

#include <string>
#include <vector>

namespace sslv {

struct AravisHandle {
  std::string name;      // what Aravis opens the camera by
  std::string serial{};  // of a GigE camera that a search found
};

/// How to open the camera that an admin calls by its serial number, IP address or Aravis id; empty:
/// the first. Throws CaptureError naming those that are there.
AravisHandle resolve_aravis_camera(const std::string& camera);

/// Throws CaptureError when another one has got its address since it was resolved.
void check_aravis_serial(ArvCamera* camera, const AravisHandle& handle);

std::vector<FoundCamera> list_aravis_cameras();

}  // namespace sslv
