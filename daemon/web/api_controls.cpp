// SPDX-License-Identifier: Apache-2.0
#include "web/api.h"
#include "web/http.h"

#include <httplib.h>

namespace sslv {

void get_controls(const WebHost& host, const httplib::Request& request, httplib::Response& response) {
  set_json(response, {{"controls", host.controls(path_camera(host, request))}});
}

void set_control(const WebHost& host, const httplib::Request& request, httplib::Response& response) {
  const std::uint32_t id = path_camera(host, request);
  const Json body = request.body.empty() ? Json::object() : parse_json(request.body);
  const bool is_fine = body.is_object() && (body.empty() || (body.size() == 1 && body.contains("value")));
  if (!is_fine) throw HttpError(400, R"(expected {"value": ...}, or nothing for an action)");
  const Json value = body.empty() ? Json(nullptr) : body.at("value");
  set_json(response, host.set_control(id, request.matches[2].str(), value, request.remote_addr));
}

void get_sources(const WebHost& host, const httplib::Request&, httplib::Response& response) {
  set_json(response, {{"sources", host.sources()}});
}

}  // namespace sslv
