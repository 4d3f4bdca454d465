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

/// Larger requests count as memory-intensive: handling one may take many times its size.
inline constexpr std::size_t kLargeRequestBytes = 64 * 1024;

struct HttpAnswer {
  std::string bytes;  // as written to the socket
  bool keep_alive = false;
  std::optional<StreamWish> stream{};  // images follow these bytes until the client disconnects
  MayLook may_look{};                  // the stream also ends when this returns false
  std::optional<SentFile> file{};      // a file follows these bytes, then the connection ends
};

/// Turns the bytes of a request into the bytes of its answer: cpp-httplib without its sockets. Routes are
/// tried from first to last, then the panel's files. If the panel's build has compressed a file (NAME.gz
/// beside NAME), clients that accept gzip get the compressed file; the router compresses nothing.
class Router {
 public:
  /// `gate` must outlive the router. If the panel's directory is missing, the panel's address explains how to
  /// build the panel. `stop`: passed on with all requests.
  Router(Gate& gate, std::vector<Route> routes, const std::filesystem::path& panel_directory,
         std::stop_token stop = {});
  ~Router();

  /// `request`: one complete request, header and body, not chunked, that passed check_header(). HEAD is
  /// answered like GET. Writes from pages of other sites, and requests under a name that is not this
  /// computer's, are refused with 403. Every write is logged (AuditLog). Thread-safe.
  HttpAnswer answer(std::string_view request, const std::string& remote_address) const;

  /// Speed and body limit of the route for this method and address.
  Speed speed_of(std::string_view method, std::string_view target) const;
  std::size_t max_body_of(std::string_view method, std::string_view target) const;

  /// Logs the counts of refused requests that are due (AuditLog). Call it periodically.
  void write_audit() const { audit_->write_due(); }

 private:
  class HttpServer;
  bool streams(const std::string& path) const;
  /// Finds only routes whose pattern is a literal path; else null.
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
