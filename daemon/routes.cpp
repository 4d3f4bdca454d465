// SPDX-License-Identifier: Apache-2.0
#include "routes.h"

#include "web/api.h"

namespace sslv {

std::span<const Route> routes() {
  static constexpr Route kRoutes[] = {
      {"GET", "/api/session", get_session, Needs::kNothing},
      {"POST", "/api/session", sign_in, Needs::kNothing},
      {"DELETE", "/api/session", sign_out, Needs::kNothing},
      {"PUT", "/api/passwords/([^/]+)", set_password, Needs::kChange},
      {"POST", "/api/match_lock", open_match_lock, Needs::kChange},
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
      {"POST", R"(/api/cameras/(\d+)/stills)", take_still, Needs::kChange},
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
      {"DELETE", R"(/api/cameras/(\d+)/colors/learning)", cancel_learning, Needs::kChange},
      {"POST", R"(/api/cameras/(\d+)/colors/learning/accept)", accept_learning},
      {"POST", R"(/api/cameras/(\d+)/colors/learning/reject)", reject_learning, Needs::kChange},
      {"GET", R"(/api/cameras/(\d+)/colors/learning/pictures/(\d+))", get_learning_picture},
      {"GET", R"(/api/cameras/(\d+)/controls)", get_controls},
      {"POST", R"(/api/cameras/(\d+)/controls/([^/]+))", set_control},
      {"GET", R"(/api/cameras/(\d+)/field_view)", get_field_view},
      {"GET", R"(/api/cameras/(\d+)/calibration)", get_calibration},
      {"POST", R"(/api/cameras/(\d+)/calibration)", start_calibration,
       Needs::kChange},  // which looks at the match lock itself
      {"DELETE", R"(/api/cameras/(\d+)/calibration)", cancel_calibration, Needs::kChange},
      {"POST", R"(/api/cameras/(\d+)/calibration/accept)", accept_calibration, Needs::kChange},
      {"POST", R"(/api/cameras/(\d+)/calibration/reject)", reject_calibration, Needs::kChange},
      {"POST", R"(/api/cameras/(\d+)/calibration/revert)", revert_calibration, Needs::kChange},
      {"GET", "/api/calibration", get_joint_calibration},
      {"POST", "/api/calibration", start_joint_calibration, Needs::kChange},
      {"DELETE", "/api/calibration", cancel_joint_calibration, Needs::kChange},
      {"POST", "/api/calibration/accept", accept_joint_calibration, Needs::kChange},
      {"POST", "/api/calibration/reject", reject_joint_calibration, Needs::kChange},
      {"GET", "/api/sources", get_sources},
      {"GET", "/api/settings", get_settings},
      {"PATCH", "/api/settings", patch_settings},
      {"POST", "/api/settings/check", check_settings, Needs::kChange},
      {"GET", "/api/settings/history", get_settings_history},
      {"POST", "/api/settings/undo", undo_settings},
      {"GET", "/api/profiles", get_profiles},
      {"POST", R"(/api/profiles/(.+)/apply)", apply_profile},
      {"GET", R"(/api/profiles/(.+))", get_profile},
      {"PUT", R"(/api/profiles/(.+))", save_profile},
      {"DELETE", R"(/api/profiles/(.+))", delete_profile},
      {"GET", "/api/support", get_support, Needs::kChange},
      {"GET", "/api/schema", get_schema},
      {"GET", "/api/field/presets", get_field_presets},
      {"GET", "/api/network/interfaces", get_network_interfaces},
      {"GET", "/metrics", get_metrics,
       Needs::kNothing},  // this and the next two: where monitoring looks for them
      {"GET", "/healthz", get_health, Needs::kNothing},
      {"GET", "/readyz", get_readiness, Needs::kNothing},
      {"GET", "/api/ws", get_websocket},  // the upgraded connection is web/websocket.cpp's
  };
  return kRoutes;
}

}  // namespace sslv
