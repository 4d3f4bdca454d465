// SPDX-License-Identifier: Apache-2.0
#include "web/api.h"
#include "web/http.h"

#include <httplib.h>

namespace sslv {

void get_websocket(const WebHost&, const httplib::Request&, httplib::Response& response) {
  response.set_header("Upgrade", "websocket");
  set_error(response, 426, "this address speaks WebSocket only");
}

}  // namespace sslv
