// SPDX-License-Identifier: Apache-2.0
#include "web/api.h"
#include "web/http.h"

#include <charconv>

#include <httplib.h>

namespace sslv {
namespace {

/// `7`, or `"7"` as HTTP writes entity tags.
std::uint64_t read_revision(std::string_view text) {
  std::string_view digits = text;
  if (digits.size() > 2 && digits.starts_with('"') && digits.ends_with('"'))
    digits = digits.substr(1, digits.size() - 2);
  std::uint64_t revision = 0;
  const auto [end, error] = std::from_chars(digits.begin(), digits.end(), revision);
  if (error != std::errc() || end != digits.end()) {
    throw HttpError(400, "If-Match: " + std::string(text.substr(0, 40)) +
                             " is not allowed; expected the revision the change was made for");
  }
  return revision;
}

}  // namespace

std::optional<std::uint64_t> if_match(const httplib::Request& request) {
  if (!request.has_header("If-Match")) return std::nullopt;
  return read_revision(request.get_header_value("If-Match"));
}

void get_settings(const WebHost& host, const httplib::Request&, httplib::Response& response) {
  set_json(response, host.settings());
}

void patch_settings(const WebHost& host, const httplib::Request& request, httplib::Response& response) {
  set_json(response, host.patch_settings(parse_json(request.body), if_match(request), request.remote_addr));
}

void check_settings(const WebHost& host, const httplib::Request& request, httplib::Response& response) {
  set_json(response, {{"changes", host.check_settings(parse_json(request.body))}});
}

void get_settings_history(const WebHost& host, const httplib::Request&, httplib::Response& response) {
  set_json(response, host.settings_history());
}

void undo_settings(const WebHost& host, const httplib::Request& request, httplib::Response& response) {
  const Json body = parse_json(request.body);
  if (!body.is_object() || !body.contains("revision") || !body["revision"].is_number_unsigned())
    throw HttpError(400, "revision: expected the number of a step of the history");
  set_json(response, host.undo_settings(body["revision"].get<std::uint64_t>(), request.remote_addr));
}

void get_schema(const WebHost& host, const httplib::Request&, httplib::Response& response) {
  set_json(response, host.schema());
}

void get_field_presets(const WebHost& host, const httplib::Request&, httplib::Response& response) {
  set_json(response, host.field_presets());
}

}  // namespace sslv
