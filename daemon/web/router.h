// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "web/host.h"
#include "web/http.h"
#include "web/static_files.h"

#include <filesystem>
#include <span>
#include <string_view>

namespace sslv {

/// Called from several threads at once. May throw HttpError, SettingsError (answered with 422) and
/// StaleRevision (409); anything else is answered with 500.
using Handler = Response (*)(const WebHost& host, const Request& request);

struct Route {
  std::string_view method;
  std::string_view pattern;  // "/api/cameras/{id}/lut": a {name} stands for one part of the path
  Handler handler;
};

/// From a request to its answer, without sockets.
class Router {
 public:
  /// `host` and `routes` must outlive the router.
  Router(const WebHost& host, std::span<const Route> routes, std::filesystem::path panel_directory)
      : host_(host), routes_(routes), files_(std::move(panel_directory)) {}

  /// HEAD is answered as GET. Writes from pages of another site are refused with 403.
  Response answer(Request request) const noexcept;

 private:
  Response dispatch(Request& request) const;

  const WebHost& host_;
  std::span<const Route> routes_;
  StaticFiles files_;
};

}  // namespace sslv
