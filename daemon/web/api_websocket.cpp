// SPDX-License-Identifier: Apache-2.0
#include "web/api.h"

namespace sslv {

Response get_websocket(const WebHost&, const Request&) {
  Response response = error_response(426, "this address speaks WebSocket only");
  response.headers.emplace_back("Upgrade", "websocket");
  return response;
}

}  // namespace sslv
