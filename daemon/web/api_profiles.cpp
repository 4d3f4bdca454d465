// SPDX-License-Identifier: Apache-2.0
#include "web/api.h"
#include "web/http.h"

#include <httplib.h>

namespace sslv {
namespace {

/// The one member that a body may have; nothing when there is none.
std::optional<Json> only_member(const httplib::Request& request, const char* key, const char* expected) {
  if (request.body.empty()) return std::nullopt;
  const Json body = parse_json(request.body);
  if (body.is_object() && body.empty()) return std::nullopt;
  if (!body.is_object() || body.size() != 1 || !body.contains(key)) throw HttpError(400, expected);
  return body.at(key);
}

std::optional<std::vector<std::string>> read_paths(const std::optional<Json>& json) {
  if (!json) return std::nullopt;
  std::vector<std::string> paths;
  const auto refuse = [] { throw HttpError(400, "paths: expected a list of JSON Pointers"); };
  if (!json->is_array()) refuse();
  for (const Json& path : *json) {
    if (!path.is_string()) refuse();
    paths.push_back(path.get<std::string>());
  }
  return paths;
}

}  // namespace

void get_profiles(const WebHost& host, const httplib::Request&, httplib::Response& response) {
  set_json(response, {{"profiles", host.profiles()}});
}

void get_profile(const WebHost& host, const httplib::Request& request, httplib::Response& response) {
  set_json(response, host.profile(request.matches[1].str()));
}

void save_profile(const WebHost& host, const httplib::Request& request, httplib::Response& response) {
  const auto settings =
      only_member(request, "settings", R"(expected {"settings": {...}}, or nothing for those in force)");
  set_json(response, host.save_profile(request.matches[1].str(), settings, request.remote_addr));
}

void apply_profile(const WebHost& host, const httplib::Request& request, httplib::Response& response) {
  const auto paths =
      read_paths(only_member(request, "paths", R"(expected {"paths": [...]}, or nothing for all changes)"));
  set_json(response,
           host.apply_profile(request.matches[1].str(), paths, if_match(request), request.remote_addr));
}

void delete_profile(const WebHost& host, const httplib::Request& request, httplib::Response& response) {
  set_json(response, {{"profiles", host.delete_profile(request.matches[1].str())}});
}

}  // namespace sslv
