// SPDX-License-Identifier: Apache-2.0
#include "routes.h"

#include "web/api.h"

namespace sslv {

std::span<const Route> routes() {
  static constexpr Route kRoutes[] = {
      {"GET", "/api/status", get_status},
      {"GET", "/api/cameras", get_cameras},
      {"GET", "/api/cameras/{id}/snapshot.jpg", get_snapshot},
      {"GET", "/api/cameras/{id}/lut", get_lut},
      {"GET", "/api/settings", get_settings},
      {"PATCH", "/api/settings", patch_settings},
      {"GET", "/api/schema", get_schema},
      {"GET", "/api/ws", get_websocket},  // the upgraded connection is web/websocket.cpp's
  };
  return kRoutes;
}

}  // namespace sslv
