// SPDX-License-Identifier: Apache-2.0
#include "web/http.h"

#include "web/route.h"

#include <algorithm>
#include <cctype>
#include <cstdint>
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
  if (inet_pton(AF_INET6, address.c_str(), &parsed) != 1 || IN6_IS_ADDR_V4MAPPED(&parsed)) return address;
  std::fill(std::begin(parsed.s6_addr) + 8, std::end(parsed.s6_addr), std::uint8_t{0});
  std::array<char, INET6_ADDRSTRLEN> text{};
  inet_ntop(AF_INET6, &parsed, text.data(), text.size());
  return text.data();
}

}  // namespace sslv
