// SPDX-License-Identifier: Apache-2.0
#include "routes.h"

#include "web/api.h"

namespace sslv {

std::span<const Route> routes() {
  static constexpr Route kRoutes[] = {
      {"GET", "/api/status", get_status},
      {"GET", "/api/alerts", get_alerts},
      {"GET", "/api/checks", get_checks},
      {"GET", "/api/timeline", get_timeline},
      {"GET", "/api/diagnostics", get_diagnostics},
      {"GET", "/api/log", get_log},
      {"GET", "/api/cameras", get_cameras},
      {"GET", R"(/api/cameras/(\d+)/snapshot\.jpg)", get_snapshot},
      {"GET", kStreamPattern, get_stream},  // its pictures are web/picture_stream.cpp's
      {"GET", R"(/api/cameras/(\d+)/pixels)", get_pixels},
      {"POST", R"(/api/cameras/(\d+)/stills)", take_still},
      {"GET", R"(/api/cameras/(\d+)/stills/(\d+)/picture\.jpg)", get_still_picture},
      {"GET", R"(/api/cameras/(\d+)/stills/(\d+)/labels)", get_still_labels},
      {"GET", R"(/api/cameras/(\d+)/colors)", get_colors},
      {"GET", R"(/api/cameras/(\d+)/colors/table)", get_color_table},
      {"POST", R"(/api/cameras/(\d+)/colors/edits)", edit_colors},
      {"POST", R"(/api/cameras/(\d+)/colors/undo)", undo_colors},
      {"POST", R"(/api/cameras/(\d+)/colors/redo)", redo_colors},
      {"POST", R"(/api/cameras/(\d+)/colors/reset)", reset_colors},
      {"POST", R"(/api/cameras/(\d+)/colors/copy)", copy_colors},
      {"POST", R"(/api/cameras/(\d+)/colors/import)", import_colors},
      {"GET", R"(/api/cameras/(\d+)/colors/export)", export_colors},
      {"POST", R"(/api/cameras/(\d+)/colors/light/revert)", revert_light},
      {"POST", R"(/api/cameras/(\d+)/colors/light/keep)", keep_light},
      {"GET", R"(/api/cameras/(\d+)/colors/learning)", get_learning},
      {"POST", R"(/api/cameras/(\d+)/colors/learning)", start_learning},
      {"DELETE", R"(/api/cameras/(\d+)/colors/learning)", cancel_learning},
      {"POST", R"(/api/cameras/(\d+)/colors/learning/accept)", accept_learning},
      {"POST", R"(/api/cameras/(\d+)/colors/learning/reject)", reject_learning},
      {"GET", R"(/api/cameras/(\d+)/colors/learning/pictures/(\d+))", get_learning_picture},
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
      {"POST", "/api/settings/check", check_settings},
      {"GET", "/api/settings/history", get_settings_history},
      {"POST", "/api/settings/undo", undo_settings},
      {"GET", "/api/profiles", get_profiles},
      {"POST", R"(/api/profiles/(.+)/apply)", apply_profile},
      {"GET", R"(/api/profiles/(.+))", get_profile},
      {"PUT", R"(/api/profiles/(.+))", save_profile},
      {"DELETE", R"(/api/profiles/(.+))", delete_profile},
      {"GET", "/api/support", get_support},
      {"GET", "/api/schema", get_schema},
      {"GET", "/api/field/presets", get_field_presets},
      {"GET", "/api/network/interfaces", get_network_interfaces},
      {"GET", "/metrics", get_metrics},  // this and the next two: where monitoring looks for them
      {"GET", "/healthz", get_health},
      {"GET", "/readyz", get_readiness},
      {"GET", "/api/ws", get_websocket},  // the upgraded connection is web/websocket.cpp's
  };
  return kRoutes;
}

}  // namespace sslv
