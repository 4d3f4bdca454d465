// SPDX-License-Identifier: Apache-2.0
#pragma once

// The handlers behind the table of routes; docs/openapi.json says what each answers.

#include "web/host.h"

#include <cstdint>
#include <optional>

namespace httplib {
struct Request;
struct Response;
}  // namespace httplib

namespace sslv {

struct StreamWish;

// api_status.cpp
void get_status(const WebHost& host, const httplib::Request& request, httplib::Response& response);
void get_cameras(const WebHost& host, const httplib::Request& request, httplib::Response& response);
void get_alerts(const WebHost& host, const httplib::Request& request, httplib::Response& response);
void get_checks(const WebHost& host, const httplib::Request& request, httplib::Response& response);
void get_timeline(const WebHost& host, const httplib::Request& request, httplib::Response& response);
void get_diagnostics(const WebHost& host, const httplib::Request& request, httplib::Response& response);
void get_metrics(const WebHost& host, const httplib::Request& request, httplib::Response& response);
void get_health(const WebHost& host, const httplib::Request& request, httplib::Response& response);
void get_readiness(const WebHost& host, const httplib::Request& request, httplib::Response& response);
void get_log(const WebHost& host, const httplib::Request& request, httplib::Response& response);
void get_network_interfaces(const WebHost& host, const httplib::Request& request,
                            httplib::Response& response);

// api_cameras.cpp: the path holds the camera's id
/// The camera named in the path. Throws HttpError 404.
std::uint32_t path_camera(const WebHost& host, const httplib::Request& request);
/// A JPEG of the picture, of the width and quality that the query asks for.
void set_picture(httplib::Response& response, const LentPicture& picture, const httplib::Request& request);
void get_snapshot(const WebHost& host, const httplib::Request& request, httplib::Response& response);
/// The head alone: the pictures are web/picture_stream.cpp's.
void get_stream(const WebHost& host, const httplib::Request& request, httplib::Response& response);
inline constexpr const char* kStreamPattern = R"(/api/cameras/(\d+)/stream\.mjpg)";
/// What such a request asks for, whether or not there is such a camera. Throws HttpError 400.
StreamWish stream_wish(const httplib::Request& request);

// api_controls.cpp: the path holds the camera's id
void get_controls(const WebHost& host, const httplib::Request& request, httplib::Response& response);
void set_control(const WebHost& host, const httplib::Request& request, httplib::Response& response);
void get_sources(const WebHost& host, const httplib::Request& request, httplib::Response& response);

// api_calibration.cpp: the path holds the camera's id
void get_field_view(const WebHost& host, const httplib::Request& request, httplib::Response& response);
void get_calibration(const WebHost& host, const httplib::Request& request, httplib::Response& response);
void start_calibration(const WebHost& host, const httplib::Request& request, httplib::Response& response);
void cancel_calibration(const WebHost& host, const httplib::Request& request, httplib::Response& response);
void accept_calibration(const WebHost& host, const httplib::Request& request, httplib::Response& response);
void reject_calibration(const WebHost& host, const httplib::Request& request, httplib::Response& response);
void revert_calibration(const WebHost& host, const httplib::Request& request, httplib::Response& response);

// api_calibration.cpp: of several cameras together
void get_joint_calibration(const WebHost& host, const httplib::Request& request, httplib::Response& response);
void start_joint_calibration(const WebHost& host, const httplib::Request& request,
                             httplib::Response& response);
void cancel_joint_calibration(const WebHost& host, const httplib::Request& request,
                              httplib::Response& response);
void accept_joint_calibration(const WebHost& host, const httplib::Request& request,
                              httplib::Response& response);
void reject_joint_calibration(const WebHost& host, const httplib::Request& request,
                              httplib::Response& response);

// api_colors.cpp: the path holds the camera's id, and more
void get_colors(const WebHost& host, const httplib::Request& request, httplib::Response& response);
void get_color_table(const WebHost& host, const httplib::Request& request, httplib::Response& response);
void edit_colors(const WebHost& host, const httplib::Request& request, httplib::Response& response);
void undo_colors(const WebHost& host, const httplib::Request& request, httplib::Response& response);
void redo_colors(const WebHost& host, const httplib::Request& request, httplib::Response& response);
void reset_colors(const WebHost& host, const httplib::Request& request, httplib::Response& response);
void copy_colors(const WebHost& host, const httplib::Request& request, httplib::Response& response);
void import_colors(const WebHost& host, const httplib::Request& request, httplib::Response& response);
void export_colors(const WebHost& host, const httplib::Request& request, httplib::Response& response);
void revert_light(const WebHost& host, const httplib::Request& request, httplib::Response& response);
void keep_light(const WebHost& host, const httplib::Request& request, httplib::Response& response);
void get_learning(const WebHost& host, const httplib::Request& request, httplib::Response& response);
void start_learning(const WebHost& host, const httplib::Request& request, httplib::Response& response);
void cancel_learning(const WebHost& host, const httplib::Request& request, httplib::Response& response);
void accept_learning(const WebHost& host, const httplib::Request& request, httplib::Response& response);
void reject_learning(const WebHost& host, const httplib::Request& request, httplib::Response& response);
void get_learning_picture(const WebHost& host, const httplib::Request& request, httplib::Response& response);

// api_pixels.cpp: the path holds the camera's id, and a still's number
void get_pixels(const WebHost& host, const httplib::Request& request, httplib::Response& response);
void take_still(const WebHost& host, const httplib::Request& request, httplib::Response& response);
void get_still_picture(const WebHost& host, const httplib::Request& request, httplib::Response& response);
void get_still_labels(const WebHost& host, const httplib::Request& request, httplib::Response& response);

// api_settings.cpp
/// The revision that the request names in If-Match. Throws HttpError 400.
std::optional<std::uint64_t> if_match(const httplib::Request& request);
void get_settings(const WebHost& host, const httplib::Request& request, httplib::Response& response);
void patch_settings(const WebHost& host, const httplib::Request& request, httplib::Response& response);
void check_settings(const WebHost& host, const httplib::Request& request, httplib::Response& response);
void get_settings_history(const WebHost& host, const httplib::Request& request, httplib::Response& response);
void undo_settings(const WebHost& host, const httplib::Request& request, httplib::Response& response);
void get_schema(const WebHost& host, const httplib::Request& request, httplib::Response& response);
void get_field_presets(const WebHost& host, const httplib::Request& request, httplib::Response& response);

// api_profiles.cpp: the path holds the profile's name
void get_profiles(const WebHost& host, const httplib::Request& request, httplib::Response& response);
void get_profile(const WebHost& host, const httplib::Request& request, httplib::Response& response);
void save_profile(const WebHost& host, const httplib::Request& request, httplib::Response& response);
void apply_profile(const WebHost& host, const httplib::Request& request, httplib::Response& response);
void delete_profile(const WebHost& host, const httplib::Request& request, httplib::Response& response);

// api_session.cpp: who may do what, and whether a match forbids it
void get_session(const WebHost& host, const httplib::Request& request, httplib::Response& response);
void sign_in(const WebHost& host, const httplib::Request& request, httplib::Response& response);
void sign_out(const WebHost& host, const httplib::Request& request, httplib::Response& response);
void set_password(const WebHost& host, const httplib::Request& request, httplib::Response& response);
void open_match_lock(const WebHost& host, const httplib::Request& request, httplib::Response& response);

// api_support.cpp
void get_support(const WebHost& host, const httplib::Request& request, httplib::Response& response);

// api_websocket.cpp: a plain request where a WebSocket is expected
void get_websocket(const WebHost& host, const httplib::Request& request, httplib::Response& response);

}  // namespace sslv
