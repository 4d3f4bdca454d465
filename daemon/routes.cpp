// SPDX-License-Identifier: Apache-2.0
#include "routes.h"

#include "web/api.h"

namespace sslv {

std::span<const Route> routes() {
  static constexpr Route kRoutes[] = {
      {"GET", "/api/status", get_status},
      {"GET", "/api/cameras", get_cameras},
      {"GET", R"(/api/cameras/(\d+)/snapshot\.jpg)", get_snapshot},
      {"GET", R"(/api/cameras/(\d+)/lut)", get_lut},
      {"GET", R"(/api/cameras/(\d+)/controls)", get_controls},
      {"POST", R"(/api/cameras/(\d+)/controls/([^/]+))", set_control},
      {"GET", R"(/api/cameras/(\d+)/calibration)", get_calibration},
      {"POST", R"(/api/cameras/(\d+)/calibration)", start_calibration},
      {"DELETE", R"(/api/cameras/(\d+)/calibration)", cancel_calibration},
      {"POST", R"(/api/cameras/(\d+)/calibration/accept)", accept_calibration},
      {"POST", R"(/api/cameras/(\d+)/calibration/reject)", reject_calibration},
      {"POST", R"(/api/cameras/(\d+)/calibration/revert)", revert_calibration},
      {"GET", "/api/calibration", get_joint_calibration},
      {"POST", "/api/calibration", start_joint_calibration},
      {"DELETE", "/api/calibration", cancel_joint_calibration},
      {"POST", "/api/calibration/accept", accept_joint_calibration},
      {"POST", "/api/calibration/reject", reject_joint_calibration},
      {"GET", "/api/sources", get_sources},
      {"GET", "/api/settings", get_settings},
      {"PATCH", "/api/settings", patch_settings},
      {"GET", "/api/settings/history", get_settings_history},
      {"POST", "/api/settings/undo", undo_settings},
      {"GET", "/api/schema", get_schema},
      {"GET", "/api/field/presets", get_field_presets},
      {"GET", "/api/network/interfaces", get_network_interfaces},
      {"GET", "/api/ws", get_websocket},  // the upgraded connection is web/websocket.cpp's
  };
  return kRoutes;
}

}  // namespace sslv
