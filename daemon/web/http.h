// SPDX-License-Identifier: Apache-2.0
#pragma once

// What handlers and viewers' messages share: reading what clients send, and answering in JSON.

#include "base/json.h"

#include <array>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace httplib {
struct Request;
struct Response;
}  // namespace httplib

namespace sslv {

/// Thrown by a handler to answer {"error": what()} with this status.
struct HttpError : std::runtime_error {
  HttpError(int http_status, const std::string& text) : runtime_error(text), status(http_status) {}
  int status;
};

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

/// A whole number in min .. max from a path part or the query. Throws HttpError 400 naming `name`.
int read_whole_number(std::string_view name, std::string_view text, int min, int max);
/// Likewise, with a fraction.
double read_number(std::string_view name, std::string_view text, double min, double max);
/// Likewise from the query; `fallback` when it does not say.
int query_number(const httplib::Request& request, const std::string& name, int fallback, int min, int max);

/// Strict JSON of limited depth, so that no client can exhaust the stack of whoever walks through it.
/// Throws HttpError 400.
Json parse_json(std::string_view text);

/// Never throws for text that is not UTF-8 (a driver's message, say): such bytes are replaced.
std::string to_text(const Json& json);

/// A whole answer {"error": text} that closes the connection, for what is refused before it is known to be a
/// request.
std::string refusal_text(unsigned status, std::string_view text);

void set_json(httplib::Response& response, const Json& json);
void set_error(httplib::Response& response, int status, std::string_view text);

}  // namespace sslv
