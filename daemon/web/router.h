// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "web/access.h"
#include "web/api.h"
#include "web/audit_log.h"
#include "web/camera_feed.h"
#include "web/host.h"

#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace sslv {

/// Called from several threads at once. May throw HttpError, SettingsError (answered with 422),
/// StorageError (507) and StaleRevision (409); anything else is answered with 500.
using Handler = void (*)(const WebHost& host, const httplib::Request& request, httplib::Response& response);

/// What a route asks of who calls it.
enum class Needs {
  kByMethod,  // GET: May::kLook; others: May::kChange, and no match that is running
  kNothing,
  kChange,  // May::kChange, also while a match runs
};

struct Route {
  const char* method;   // GET, POST, PUT, PATCH or DELETE
  const char* pattern;  // regular expression of the whole path; its groups are request.matches[1], [2]...
  Handler handler;
  Needs needs = Needs::kByMethod;
};

/// How long a connection is kept open for its next request.
inline constexpr std::chrono::seconds kKeepAliveTimeout{75};

struct HttpAnswer {
  std::string bytes;  // as they go onto the socket
  bool keep_alive = false;
  std::optional<StreamWish> stream{};  // what follows these bytes until the client goes
  MayLook may_look{};                  // or until it may not look any more
};

/// From a request's bytes to its answer's: cpp-httplib without its sockets. Routes come first to last, and
/// what none of them matches is looked for among the panel's files.
class Router {
 public:
  /// `host` and `routes` must outlive the router. Without the panel's directory its address says how to build
  /// the panel.
  Router(const WebHost& host, std::span<const Route> routes, const std::filesystem::path& panel_directory);
  ~Router();

  /// `request`: one complete request, header and body, without chunks, that passed check_header(). HEAD is
  /// answered as GET. Writes from pages of another site, and requests by a name that is not this computer's,
  /// are refused with 403. Every write is written down in the log (AuditLog). May be called from several
  /// threads at once.
  HttpAnswer answer(std::string_view request, const std::string& remote_address) const;

  /// Writes to the log what is due of requests that were refused (AuditLog): to be called now and then.
  void write_audit() const;

 private:
  class HttpServer;
  const WebHost& host_;
  const std::unique_ptr<AuditLog> audit_;
  const std::unique_ptr<HttpServer> server_;
};

}  // namespace sslv
