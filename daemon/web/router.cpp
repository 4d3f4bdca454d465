// SPDX-License-Identifier: Apache-2.0
#include "web/router.h"

#include "base/error.h"
#include "base/log.h"

#include <optional>
#include <string>
#include <vector>

namespace sslv {
namespace {

/// What stands for the pattern's {names}; nothing when the path is another one.
std::optional<std::vector<std::string>> match(std::string_view pattern,
                                              const std::vector<std::string>& path) {
  std::vector<std::string> captures;
  for (const std::string& part : path) {
    if (!pattern.starts_with('/')) return std::nullopt;
    pattern.remove_prefix(1);
    const std::string_view expected = pattern.substr(0, pattern.find('/'));
    pattern.remove_prefix(expected.size());
    if (expected.starts_with('{')) {
      captures.push_back(part);
    } else if (expected != part) {
      return std::nullopt;
    }
  }
  if (!pattern.empty()) return std::nullopt;
  return captures;
}

}  // namespace

Response Router::dispatch(Request& request) const {
  if (request.method == "HEAD") request.method = "GET";
  if (request.method != "GET" && !is_same_origin(request)) {
    throw HttpError(403, "this request comes from a page of another site");
  }

  std::string allowed;
  for (const Route& route : routes_) {
    std::optional<std::vector<std::string>> captures = match(route.pattern, request.path);
    if (!captures) continue;
    if (route.method == request.method) {
      request.captures = std::move(*captures);
      return route.handler(host_, request);
    }
    allowed += (allowed.empty() ? "" : ", ") + std::string(route.method);
  }
  const bool is_api = !request.path.empty() && request.path.front() == "api";
  if (allowed.empty() && is_api) throw HttpError(404, "no such route; docs/api.md lists them");
  if (allowed.empty() && request.method == "GET") return files_.get(request.path);
  if (allowed.empty()) allowed = "GET";
  Response response = error_response(405, request.method + " is not allowed here; expected " + allowed);
  response.headers.emplace_back("Allow", allowed);
  return response;
}

Response Router::answer(Request request) const noexcept try {
  return dispatch(request);
} catch (const HttpError& error) {
  return error_response(error.status, error.what());
} catch (const StaleRevision& error) {
  return error_response(409, error.what());
} catch (const SettingsError& error) {
  return error_response(422, error.what());
} catch (const std::exception& error) {
  log::error("web: {} failed: {}", request.method, error.what());
  return error_response(500, error.what());
}

}  // namespace sslv
