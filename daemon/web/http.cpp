// SPDX-License-Identifier: Apache-2.0
#include "web/http.h"

#include <algorithm>
#include <charconv>

#include <httplib.h>

namespace sslv {

bool is_same_origin(std::string_view origin, std::string_view host) {
  if (origin.empty()) return true;
  const std::size_t scheme = origin.find("://");
  if (scheme == std::string_view::npos || host.empty()) return false;
  const auto lower = [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; };
  const std::string_view site = origin.substr(scheme + 3);
  return std::equal(site.begin(), site.end(), host.begin(), host.end(),
                    [&](char a, char b) { return lower(a) == lower(b); });
}

int read_whole_number(std::string_view name, std::string_view text, int min, int max) {
  int value = 0;
  const auto [end, error] = std::from_chars(text.begin(), text.end(), value);
  if (error != std::errc() || end != text.end() || value < min || value > max) {
    throw HttpError(400, std::string(name) + ": \"" + std::string(text.substr(0, 40)) +
                             "\" is not allowed; expected a whole number " + std::to_string(min) + " .. " +
                             std::to_string(max));
  }
  return value;
}

int query_number(const httplib::Request& request, const std::string& name, int fallback, int min, int max) {
  if (!request.has_param(name)) return fallback;
  return read_whole_number(name, request.get_param_value(name), min, max);
}

Json parse_json(std::string_view text) {
  constexpr int kMaxDepth = 64;
  const auto check_depth = [](int depth, Json::parse_event_t, const Json&) {
    if (depth > kMaxDepth)
      throw HttpError(400, "JSON nested deeper than " + std::to_string(kMaxDepth) + " levels");
    return true;
  };
  try {
    return Json::parse(text, check_depth);
  } catch (const Json::exception& error) {
    throw HttpError(400, std::string("not JSON: ") + error.what());
  }
}

std::string to_text(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

void set_json(httplib::Response& response, const Json& json) {
  response.set_content(to_text(json), "application/json");
}

void set_error(httplib::Response& response, int status, std::string_view text) {
  response.status = status;
  set_json(response, {{"error", text}});
}

}  // namespace sslv
