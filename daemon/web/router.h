// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "web/audit_log.h"
#include "web/gate.h"
#include "web/route.h"

#include <chrono>
#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <regex>
#include <stop_token>
#include <string>
#include <string_view>
#include <vector>

namespace sslv {

/// How long a connection is kept open for its next request.
inline constexpr std::chrono::seconds kKeepAliveTimeout{75};

/// A request of more takes memory: many times its bytes may be made of it.
inline constexpr std::size_t kLargeRequestBytes = 64 * 1024;

struct HttpAnswer {
  std::string bytes;  // as they go onto the socket
  bool keep_alive = false;
  std::optional<StreamWish> stream{};  // what follows these bytes until the client goes
  MayLook may_look{};                  // or until it may not look any more
  std::optional<SentFile> file{};      // what follows them, before the connection ends
};

/// From a request's bytes to its answer's: cpp-httplib without its sockets. Routes come first to last, and
/// what none of them matches is looked for among the panel's files. A file that the panel's build has packed,
/// NAME.gz beside NAME, is sent so to clients that take it; nothing is packed here.
class Router {
 public:
  /// `gate` must outlive the router. Without the panel's directory its address says how to build the panel.
  /// `stop`: of all requests.
  Router(Gate& gate, std::vector<Route> routes, const std::filesystem::path& panel_directory,
         std::stop_token stop = {});
  ~Router();

  /// `request`: one complete request, header and body, without chunks, that passed check_header(). HEAD is
  /// answered as GET. Writes from pages of another site, and requests by a name that is not this computer's,
  /// are refused with 403. Every write is written down in the log (AuditLog). May be called from several
  /// threads at once.
  HttpAnswer answer(std::string_view request, const std::string& remote_address) const;

  /// Of the route that this method and address ask for.
  Speed speed_of(std::string_view method, std::string_view target) const;
  std::size_t max_body_of(std::string_view method, std::string_view target) const;

  /// Writes to the log what is due of requests that were refused (AuditLog): to be called now and then.
  void write_audit() const { audit_->write_due(); }

 private:
  class HttpServer;
  bool streams(const std::string& path) const;
  /// Null for one whose pattern is more than a path.
  const Route* find(std::string_view method, std::string_view target) const;

  Gate& gate_;
  const std::vector<Route> routes_;
  const std::filesystem::path panel_directory_;
  const std::stop_token stop_;
  std::vector<std::regex> stream_paths_;
  const std::unique_ptr<AuditLog> audit_ = std::make_unique<AuditLog>();
  const std::unique_ptr<HttpServer> server_;
};

}  // namespace sslv
