// SPDX-License-Identifier: Apache-2.0
#pragma once

// The handlers behind the table of routes; docs/api.md says what each answers.

#include "web/host.h"
#include "web/http.h"

namespace sslv {

// api_status.cpp
Response get_status(const WebHost& host, const Request& request);
Response get_cameras(const WebHost& host, const Request& request);

// api_cameras.cpp: {id} is the camera's id
Response get_snapshot(const WebHost& host, const Request& request);
Response get_lut(const WebHost& host, const Request& request);

// api_settings.cpp
Response get_settings(const WebHost& host, const Request& request);
Response patch_settings(const WebHost& host, const Request& request);
Response get_schema(const WebHost& host, const Request& request);

// api_websocket.cpp: a plain request where a WebSocket is expected
Response get_websocket(const WebHost& host, const Request& request);

}  // namespace sslv
