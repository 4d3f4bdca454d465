// SPDX-License-Identifier: Apache-2.0
#include "web/http.h"

#include "base/plain_text.h"

#include <algorithm>
#include <charconv>
#include <optional>
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

std::string lower(std::string_view text) {
  std::string out(text);
  for (char& c : out) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return out;
}

struct HostParts {
  std::string name;  // in lower case, an IPv6 address without its brackets
  bool is_bracketed;
};

/// Of "name", "name:port", "[address]" or "[address]:port", and of nothing else.
std::optional<HostParts> host_parts(std::string_view host) {
  HostParts out{"", host.starts_with('[')};
  std::string_view rest;
  if (out.is_bracketed) {
    const std::size_t end = host.find(']');
    if (end == std::string_view::npos) return std::nullopt;
    out.name = lower(host.substr(1, end - 1));
    rest = host.substr(end + 1);
  } else {
    const std::size_t end = std::min(host.find(':'), host.size());
    out.name = lower(host.substr(0, end));
    rest = host.substr(end);
  }
  const std::string_view allowed =
      out.is_bracketed ? "0123456789abcdef:." : "abcdefghijklmnopqrstuvwxyz0123456789.-_";
  constexpr std::size_t kMaxPort = 6;  // with its colon
  const bool is_port = rest.empty() || (rest.size() <= kMaxPort && rest.front() == ':' &&
                                        rest.find_first_not_of("0123456789", 1) == std::string_view::npos);
  if (out.name.empty() || out.name.find_first_not_of(allowed) != std::string::npos || !is_port)
    return std::nullopt;
  return out;
}

}  // namespace

bool is_same_origin(std::string_view origin, std::string_view host) {
  if (origin.empty()) return true;
  const std::string site = lower(origin);
  // A panel behind a proxy with TLS is https.
  for (const std::string_view scheme : {"http://", "https://"}) {
    if (site.starts_with(scheme)) return !host.empty() && site.substr(scheme.size()) == lower(host);
  }
  return false;
}

bool is_own_name(std::string_view host, const std::vector<std::string>& names) {
  if (host.empty()) return true;
  const auto parts = host_parts(host);
  if (!parts) return false;
  const std::string& name = parts->name;
  boost::system::error_code error;
  if (parts->is_bracketed) {
    boost::asio::ip::make_address_v6(name, error);
    return !error;
  }
  boost::asio::ip::make_address_v4(name, error);
  if (!error || name == "localhost") return true;

  std::array<char, 256> own_text{};
  gethostname(own_text.data(), own_text.size() - 1);
  std::vector<std::string> own = names;
  own.emplace_back(own_text.data());
  const std::string first = own.back().substr(0, own.back().find('.'));
  own.insert(own.end(), {first, first + ".local"});
  return std::any_of(own.begin(), own.end(),
                     [&](const std::string& one) { return !one.empty() && lower(one) == name; });
}

std::string not_own_name(std::string_view host) {
  return fmt::format(
      "\"{}\" is no name of this computer; use its address, or add the name to the setting /panel/names",
      escaped_text(host.substr(0, 80)));
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
