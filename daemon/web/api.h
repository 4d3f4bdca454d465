// SPDX-License-Identifier: Apache-2.0
#pragma once

// The handlers behind the table of routes; docs/openapi.json says what each answers.

#include "web/host.h"

#include <cstdint>

namespace httplib {
struct Request;
struct Response;
}  // namespace httplib

namespace sslv {

// api_status.cpp
void get_status(const WebHost& host, const httplib::Request& request, httplib::Response& response);
void get_cameras(const WebHost& host, const httplib::Request& request, httplib::Response& response);
void get_network_interfaces(const WebHost& host, const httplib::Request& request,
                            httplib::Response& response);

// api_cameras.cpp: the path holds the camera's id
/// The camera named in the path. Throws HttpError 404.
std::uint32_t path_camera(const WebHost& host, const httplib::Request& request);
void get_snapshot(const WebHost& host, const httplib::Request& request, httplib::Response& response);
void get_lut(const WebHost& host, const httplib::Request& request, httplib::Response& response);

// api_controls.cpp: the path holds the camera's id
void get_controls(const WebHost& host, const httplib::Request& request, httplib::Response& response);
void set_control(const WebHost& host, const httplib::Request& request, httplib::Response& response);
void get_sources(const WebHost& host, const httplib::Request& request, httplib::Response& response);

// api_calibration.cpp: the path holds the camera's id
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

// api_settings.cpp
void get_settings(const WebHost& host, const httplib::Request& request, httplib::Response& response);
void patch_settings(const WebHost& host, const httplib::Request& request, httplib::Response& response);
void get_settings_history(const WebHost& host, const httplib::Request& request, httplib::Response& response);
void undo_settings(const WebHost& host, const httplib::Request& request, httplib::Response& response);
void get_schema(const WebHost& host, const httplib::Request& request, httplib::Response& response);
void get_field_presets(const WebHost& host, const httplib::Request& request, httplib::Response& response);

// api_websocket.cpp: a plain request where a WebSocket is expected
void get_websocket(const WebHost& host, const httplib::Request& request, httplib::Response& response);

}  // namespace sslv
