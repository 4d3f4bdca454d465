// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the server looks at in every request before a handler does.

#include <array>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace sslv {

/// Every answer has these, also a refusal.
inline constexpr std::array<std::pair<const char*, const char*>, 3> kSecurityHeaders{{
    // The panel loads nothing from elsewhere, and nobody else may frame it or run script in it.
    {"Content-Security-Policy",
     "default-src 'self'; img-src 'self' blob: data:; connect-src 'self' ws: wss:; object-src 'none'; "
     "frame-ancestors 'none'; base-uri 'none'"},
    {"X-Content-Type-Options", "nosniff"},
    {"Referrer-Policy", "no-referrer"},
}};

/// False when a browser sent the request from a page of another site: its Origin is not this server's Host.
/// Other clients send no Origin; it is empty then.
bool is_same_origin(std::string_view origin, std::string_view host);
inline constexpr std::string_view kOtherSite = "this request comes from a page of another site";

/// Whether a Host header names this computer: by an address, as localhost, by its host name (also with
/// .local) or by one of `names`. A page of another site that has its own name lead here (DNS rebinding) does
/// not. Empty is allowed: browsers always send one.
bool is_own_name(std::string_view host, const std::vector<std::string>& names);
/// What is said then.
std::string not_own_name(std::string_view host);

/// A whole answer {"error": text} that closes the connection, for what is refused before it is known to be a
/// request.
std::string refusal_text(unsigned status, std::string_view text);

/// For limits by address: an IPv6 network counts as one address, since everybody has many.
std::string network_of(const std::string& address);

}  // namespace sslv
