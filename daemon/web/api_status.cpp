// SPDX-License-Identifier: Apache-2.0
#include "web/api.h"
#include "web/http.h"

namespace sslv {

void get_status(const WebHost& host, const httplib::Request&, httplib::Response& response) {
  set_json(response, host.status());
}

void get_cameras(const WebHost& host, const httplib::Request&, httplib::Response& response) {
  set_json(response, host.status().at("cameras"));
}

void get_network_interfaces(const WebHost& host, const httplib::Request&, httplib::Response& response) {
  set_json(response, {{"interfaces", host.network_interfaces()}});
}

}  // namespace sslv
