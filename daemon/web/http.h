// SPDX-License-Identifier: Apache-2.0
#pragma once

// Checks of every request before a handler runs, and headers of every answer.

#include <array>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace sslv {

/// Headers of every answer, refusals included.
inline constexpr std::array<std::pair<const char*, const char*>, 3> kSecurityHeaders{{
    // The panel loads nothing from other sites, and no other site may frame it or run scripts in it.
    {"Content-Security-Policy",
     "default-src 'self'; img-src 'self' blob: data:; connect-src 'self' ws: wss:; object-src 'none'; "
     "frame-ancestors 'none'; base-uri 'none'"},
    {"X-Content-Type-Options", "nosniff"},
    {"Referrer-Policy", "no-referrer"},
}};

/// False if a page of another site sent the request: its Origin is not this server's Host. `origin` is empty
/// for clients other than browsers, which send none.
bool is_same_origin(std::string_view origin, std::string_view host);
inline constexpr std::string_view kOtherSite = "this request comes from a page of another site";

/// Whether a Host header names this computer: by address, as localhost, by its host name (also with .local)
/// or by one of `names`. False for a page of another site whose name was made to resolve to this computer
/// (DNS rebinding). An empty header is allowed, because browsers never omit it.
bool is_own_name(std::string_view host, const std::vector<std::string>& names);
/// The text of the refusal if a Host header does not name this computer.
std::string not_own_name(std::string_view host);

/// Returns a complete answer {"error": text} that closes the connection, for input refused before it is known
/// to be a request.
std::string refusal_text(unsigned status, std::string_view text);

/// The unit of limits per address: an IPv6 network (/64) counts as one address, since every client
/// has many addresses.
std::string network_of(const std::string& address);

}  // namespace sslv
