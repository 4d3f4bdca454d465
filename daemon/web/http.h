// SPDX-License-Identifier: Apache-2.0
#pragma once

// Requests and answers as handlers see them: plain values, no sockets and no HTTP library.

#include "base/json.h"

#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace sslv {

struct Request {
  std::string method;             // "GET", "PATCH"...
  std::vector<std::string> path;  // percent-decoded parts: /api/cameras/0 is {"api", "cameras", "0"}
  std::map<std::string, std::string> query;    // percent-decoded; the first of equal names
  std::map<std::string, std::string> headers;  // names in lower case; the first of equal names
  std::string body;
  std::string remote_address;
  std::vector<std::string> captures;  // what stands for each {name} of the route's pattern, in order
};

struct Response {
  int status = 200;
  std::string content_type;
  std::string body;
  std::vector<std::pair<std::string, std::string>> headers;
};

/// Thrown by a handler to answer {"error": what()} with this status.
struct HttpError : std::runtime_error {
  HttpError(int http_status, const std::string& text) : runtime_error(text), status(http_status) {}
  int status;
};

/// Fills path and query from the target of a request line. False when it is no valid target of this server:
/// not starting with "/", a bad escape, or a part that is "..", "." or hides "/" or NUL behind an escape.
bool parse_target(std::string_view target, Request& request);

/// False when a browser sent the request from a page of another site: its Origin is not this server's Host.
/// Other clients send no Origin.
bool is_same_origin(const Request& request);

/// The request's header, by its name in lower case.
std::optional<std::string> header(const Request& request, const std::string& name);

/// A whole number in min .. max from a path part or the query. Throws HttpError 400 naming `name`.
int read_whole_number(std::string_view name, std::string_view text, int min, int max);

/// Strict JSON of limited depth, so that no client can exhaust the stack of whoever walks through it.
/// Throws HttpError 400.
Json parse_json(std::string_view text);

/// Never throws for text that is not UTF-8 (a driver's message, say): such bytes are replaced.
std::string to_text(const Json& json);

Response json_response(const Json& json);
Response error_response(int status, std::string_view text);

}  // namespace sslv
