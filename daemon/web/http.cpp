// SPDX-License-Identifier: Apache-2.0
#include "web/http.h"

#include "base/plain_text.h"
#include "web/route.h"

#include <algorithm>
#include <cstdint>
#include <optional>
#include <sstream>
#include <utility>  // Boost 1.74's asio uses std::exchange without it

#include <arpa/inet.h>
#include <boost/asio/ip/address.hpp>
#include <boost/beast/http/message.hpp>
#include <boost/beast/http/string_body.hpp>
#include <boost/beast/http/write.hpp>
#include <fmt/format.h>
#include <unistd.h>

namespace sslv {
namespace {

std::string lower(std::string_view text) {
  std::string out(text);
  for (char& c : out) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return out;
}

struct HostParts {
  std::string name;  // lower case; an IPv6 address without its brackets
  bool is_bracketed;
};

/// Parses "name", "name:port", "[address]" or "[address]:port"; nothing for any other text.
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
  // The scheme is https if the panel is behind a proxy with TLS.
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
      "\"{}\" is not a name of this computer; use its address, or add the name to the setting /panel/names",
      escaped_text(host.substr(0, 80)));
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

std::string network_of(const std::string& address) {
  in6_addr parsed{};
  const std::string bare = address.substr(0, address.find('%'));  // without a scope, as in fe80::1%eth0
  if (inet_pton(AF_INET6, bare.c_str(), &parsed) != 1 || IN6_IS_ADDR_V4MAPPED(&parsed)) return address;
  std::fill(std::begin(parsed.s6_addr) + 8, std::end(parsed.s6_addr), std::uint8_t{0});
  std::array<char, INET6_ADDRSTRLEN> text{};
  inet_ntop(AF_INET6, &parsed, text.data(), text.size());
  return text.data();
}

}  // namespace sslv
