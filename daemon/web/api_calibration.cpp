// SPDX-License-Identifier: Apache-2.0
#include "base/params_json.h"
#include "web/api.h"
#include "web/http.h"

#include <httplib.h>

namespace sslv {
namespace {

struct ForceOption {
  bool force = false;
  static constexpr auto fields() {
    return std::tuple{flag("force", &ForceOption::force, "also where it is refused otherwise")};
  }
};

/// The request's body; nothing at all says nothing.
Json body_of(const httplib::Request& request) {
  return request.body.empty() ? Json::object() : parse_json(request.body);
}

bool force_of(const Json& body) {
  return params_from_json<ForceOption>(body, "").force;
}

/// Takes it out of a body that says more.
bool take_force(Json& body) {
  if (!body.is_object() || !body.contains("force")) return false;
  const bool force = force_of({{"force", body["force"]}});
  body.erase("force");
  return force;
}

}  // namespace

void get_field_view(const WebHost& host, const httplib::Request& request, httplib::Response& response) {
  set_json(response, host.field_view(path_camera(host, request)));
}

void get_calibration(const WebHost& host, const httplib::Request& request, httplib::Response& response) {
  set_json(response, host.calibration(path_camera(host, request)));
}

void start_calibration(const WebHost& host, const httplib::Request& request, httplib::Response& response) {
  const std::uint32_t id = path_camera(host, request);
  Json body = body_of(request);
  const bool force = take_force(body);
  set_json(response, host.start_calibration(id, body, force, request.remote_addr));
  response.status = 202;
}

void cancel_calibration(const WebHost& host, const httplib::Request& request, httplib::Response& response) {
  set_json(response, host.cancel_calibration(path_camera(host, request)));
}

void accept_calibration(const WebHost& host, const httplib::Request& request, httplib::Response& response) {
  const std::uint32_t id = path_camera(host, request);
  set_json(response, host.accept_calibration(id, force_of(body_of(request)), request.remote_addr));
}

void reject_calibration(const WebHost& host, const httplib::Request& request, httplib::Response& response) {
  set_json(response, host.reject_calibration(path_camera(host, request)));
}

void revert_calibration(const WebHost& host, const httplib::Request& request, httplib::Response& response) {
  const std::uint32_t id = path_camera(host, request);
  set_json(response, host.revert_calibration(id, force_of(body_of(request)), request.remote_addr));
}

void get_joint_calibration(const WebHost& host, const httplib::Request&, httplib::Response& response) {
  set_json(response, host.joint_calibration());
}

void start_joint_calibration(const WebHost& host, const httplib::Request& request,
                             httplib::Response& response) {
  Json body = body_of(request);
  const bool force = take_force(body);
  set_json(response, host.start_joint_calibration(body, force, request.remote_addr));
  response.status = 202;
}

void cancel_joint_calibration(const WebHost& host, const httplib::Request&, httplib::Response& response) {
  set_json(response, host.cancel_joint_calibration());
}

void accept_joint_calibration(const WebHost& host, const httplib::Request& request,
                              httplib::Response& response) {
  set_json(response, host.accept_joint_calibration(force_of(body_of(request)), request.remote_addr));
}

void reject_joint_calibration(const WebHost& host, const httplib::Request&, httplib::Response& response) {
  set_json(response, host.reject_joint_calibration());
}

}  // namespace sslv
