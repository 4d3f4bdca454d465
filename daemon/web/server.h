// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "web/counters.h"
#include "web/gate.h"
#include "web/route.h"
#include "web/view.h"

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace sslv {

struct WebOptions {
  std::string address = "127.0.0.1";  // IPv4 or IPv6; "0.0.0.0" or "::" for all
  int port = 8090;                    // 0: any free port
  std::filesystem::path panel_directory;
  int max_connections = 512;
};

/// The objects that the server uses.
struct WebParts {
  Gate& gate;
  ViewSource& views;
  std::vector<Topic*> topics;
  std::vector<Route> routes;
};

/// The panel's HTTP and WebSocket server (docs/api.md), on one port and on threads of its own.
class WebServer {
 public:
  /// Listens on return. `parts` and `counters`, which it updates, must outlive it. Throws SettingsError
  /// naming /panel/address or /panel/port if it cannot listen there.
  WebServer(const WebParts& parts, const WebOptions& options, WebCounters& counters);
  ~WebServer();  // stop()

  /// Finishes the requests being handled, then closes all connections. Must not be called by a handler.
  void stop();
  /// Starts stopping without waiting: no further request is handled, and requests in progress may end early
  /// (Request::stop).
  void ask_to_stop();

  /// Opens a socket at another address. The returned function, which cannot fail, then listens on it instead
  /// of the current one. Connections stay open. One move at a time, and none after stop(). Throws
  /// SettingsError like the constructor.
  std::function<void()> move_to(const std::string& address, int port);

  /// The port it listens on.
  std::uint16_t port() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace sslv
