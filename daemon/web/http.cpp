// SPDX-License-Identifier: Apache-2.0
#include "web/http.h"

#include <algorithm>
#include <charconv>

namespace sslv {
namespace {

std::optional<std::string> percent_decoded(std::string_view text, bool plus_is_space) {
  std::string out;
  out.reserve(text.size());
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '+' && plus_is_space) {
      out += ' ';
    } else if (text[i] != '%') {
      out += text[i];
    } else {
      unsigned char byte = 0;
      const std::string_view digits = text.substr(i + 1, 2);
      const auto [end, error] = std::from_chars(digits.begin(), digits.end(), byte, 16);
      if (digits.size() != 2 || error != std::errc() || end != digits.end()) return std::nullopt;
      out += static_cast<char>(byte);
      i += 2;
    }
  }
  return out;
}

/// The text before the separator; `rest` loses both.
std::string_view take_until(std::string_view& rest, char separator) {
  const std::size_t at = rest.find(separator);
  const std::string_view part = rest.substr(0, at);
  rest = at == std::string_view::npos ? std::string_view() : rest.substr(at + 1);
  return part;
}

char lower(char c) {
  return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
}

}  // namespace

bool parse_target(std::string_view target, Request& request) {
  if (!target.starts_with('/')) return false;
  std::string_view query = target.substr(std::min(target.find('?'), target.size()));
  std::string_view path = target.substr(1, target.size() - query.size() - 1);

  while (!path.empty()) {
    const std::optional<std::string> part = percent_decoded(take_until(path, '/'), false);
    if (!part || *part == ".." || *part == ".") return false;
    if (part->find('/') != std::string::npos || part->find('\0') != std::string::npos) return false;
    request.path.push_back(*part);
  }
  if (!query.empty()) query.remove_prefix(1);
  while (!query.empty()) {
    std::string_view value = take_until(query, '&');
    const std::optional<std::string> name = percent_decoded(take_until(value, '='), true);
    const std::optional<std::string> decoded = percent_decoded(value, true);
    if (!name || !decoded) return false;
    request.query.emplace(*name, *decoded);
  }
  return true;
}

std::optional<std::string> header(const Request& request, const std::string& name) {
  const auto found = request.headers.find(name);
  if (found == request.headers.end()) return std::nullopt;
  return found->second;
}

bool is_same_origin(const Request& request) {
  const std::optional<std::string> origin = header(request, "origin");
  if (!origin) return true;
  const std::string host = header(request, "host").value_or("");
  const std::size_t scheme = origin->find("://");
  if (scheme == std::string::npos || host.empty()) return false;
  const std::string_view site = std::string_view(*origin).substr(scheme + 3);
  return std::equal(site.begin(), site.end(), host.begin(), host.end(),
                    [](char a, char b) { return lower(a) == lower(b); });
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

Response json_response(const Json& json) {
  return {200, "application/json", to_text(json), {{"Cache-Control", "no-store"}}};
}

Response error_response(int status, std::string_view text) {
  Response response = json_response({{"error", text}});
  response.status = status;
  return response;
}

}  // namespace sslv
