// SPDX-License-Identifier: Apache-2.0
#include "web/http.h"

#include "base/error.h"
#include "base/memory.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <sstream>
#include <utility>  // Boost 1.74's asio uses std::exchange without it

#include <boost/asio/ip/address.hpp>
#include <boost/beast/http/message.hpp>
#include <boost/beast/http/string_body.hpp>
#include <boost/beast/http/write.hpp>
#include <fmt/format.h>
#include <httplib.h>
#include <unistd.h>

namespace sslv {
namespace {

template <class Number>
Number read_any_number(std::string_view name, std::string_view text, Number min, Number max,
                       const char* kind) {
  Number value = 0;
  const auto [end, error] = std::from_chars(text.begin(), text.end(), value);
  if (error != std::errc() || end != text.end() || !(value >= min && value <= max)) {
    throw HttpError(400, fmt::format("{}: \"{}\" is not allowed; expected a {} {} .. {}", name,
                                     text.substr(0, 40), kind, min, max));
  }
  return value;
}

}  // namespace

bool is_same_origin(std::string_view origin, std::string_view host) {
  if (origin.empty()) return true;
  const std::size_t scheme = origin.find("://");
  if (scheme == std::string_view::npos || host.empty()) return false;
  const auto lower = [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; };
  const std::string_view site = origin.substr(scheme + 3);
  return std::equal(site.begin(), site.end(), host.begin(), host.end(),
                    [&](char a, char b) { return lower(a) == lower(b); });
}

bool is_own_name(std::string_view host, const std::vector<std::string>& names) {
  std::string name(host);
  if (name.starts_with('[')) {  // IPv6
    name = name.substr(1, name.find(']') == std::string::npos ? 0 : name.find(']') - 1);
  } else {
    name = name.substr(0, name.rfind(':'));
  }
  std::transform(name.begin(), name.end(), name.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (host.empty() || name == "localhost") return true;
  boost::system::error_code error;
  boost::asio::ip::make_address(name, error);
  if (!error) return true;

  std::array<char, 256> own_text{};
  gethostname(own_text.data(), own_text.size() - 1);
  std::vector<std::string> own = names;
  own.emplace_back(own_text.data());
  const std::string first = own.back().substr(0, own.back().find('.'));
  own.insert(own.end(), {first, first + ".local"});
  return std::any_of(own.begin(), own.end(), [&](const std::string& one) {
    return !one.empty() &&
           std::equal(one.begin(), one.end(), name.begin(), name.end(),
                      [](unsigned char a, char b) { return static_cast<char>(std::tolower(a)) == b; });
  });
}

std::string not_own_name(std::string_view host) {
  return fmt::format(
      "\"{}\" is no name of this computer; use its address, or add the name to the setting /panel/names",
      host.substr(0, 80));
}

int read_whole_number(std::string_view name, std::string_view text, int min, int max) {
  return read_any_number(name, text, min, max, "whole number");
}

double read_number(std::string_view name, std::string_view text, double min, double max) {
  return read_any_number(name, text, min, max, "number");
}

int query_number(const httplib::Request& request, const std::string& name, int fallback, int min, int max) {
  if (!request.has_param(name)) return fallback;
  return read_whole_number(name, request.get_param_value(name), min, max);
}

Json parse_json(std::string_view text) {
  constexpr std::size_t kLarge = 64 * 1024;
  if (text.size() > kLarge) memory_was_used();
  constexpr int kMaxDepth = 64;
  // An object that keeps the order of its keys looks all of them through for each new one.
  constexpr int kMaxKeys = 1000;
  std::array<int, kMaxDepth + 2> keys{};
  const auto check = [&keys](int depth, Json::parse_event_t event, const Json&) {
    if (depth > kMaxDepth)
      throw HttpError(400, "JSON nested deeper than " + std::to_string(kMaxDepth) + " levels");
    const auto place = static_cast<std::size_t>(depth);
    if (event == Json::parse_event_t::object_start) keys[place + 1] = 0;
    if (event == Json::parse_event_t::key && ++keys[place] > kMaxKeys)
      throw HttpError(400, "JSON with more than " + std::to_string(kMaxKeys) + " keys in an object");
    return true;
  };
  try {
    return Json::parse(text, check);
  } catch (const Json::exception& error) {
    throw HttpError(400, "not JSON: " + shortened(error.what(), 300));
  }
}

std::string to_text(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::string refusal_text(unsigned status, std::string_view text) {
  namespace http = boost::beast::http;
  http::response<http::string_body> answer(http::int_to_status(status), 11, to_text({{"error", text}}));
  answer.set(http::field::content_type, "application/json");
  answer.set(http::field::cache_control, "no-store");
  for (const auto& [name, value] : kSecurityHeaders) answer.set(name, value);
  answer.keep_alive(false);
  answer.prepare_payload();
  return (std::ostringstream() << answer).str();
}

void set_json(httplib::Response& response, const Json& json) {
  response.set_content(to_text(json), "application/json");
}

void set_error(httplib::Response& response, int status, std::string_view text) {
  response.status = status;
  set_json(response, {{"error", text}});
}

}  // namespace sslv
