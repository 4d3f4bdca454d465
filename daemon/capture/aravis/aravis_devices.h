// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "capture/aravis/aravis_library.h"
#include "capture/source.h"

#include <string>
#include <vector>

namespace sslv {

struct AravisHandle {
  std::string name;      // for opening the camera with Aravis
  std::string serial{};  // only for GigE cameras found by a search
};

/// Finds the camera that the admin named by serial number, IP address or Aravis id; an empty name means the
/// first camera. Throws CaptureError that lists the existing cameras.
AravisHandle resolve_aravis_camera(const std::string& camera);

/// Throws CaptureError if another camera has received the camera's address since resolve_aravis_camera().
void check_aravis_serial(ArvCamera* camera, const AravisHandle& handle);

std::vector<FoundCamera> list_aravis_cameras();

}  // namespace sslv
