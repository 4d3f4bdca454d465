// SPDX-License-Identifier: Apache-2.0
#include "web/api.h"

namespace sslv {

Response get_status(const WebHost& host, const Request&) {
  return json_response(host.status());
}

Response get_cameras(const WebHost& host, const Request&) {
  return json_response(host.status().at("cameras"));
}

}  // namespace sslv
