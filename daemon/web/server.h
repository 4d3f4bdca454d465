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
  int port = 8090;                    // 0: any free one
  std::filesystem::path panel_directory;
  int max_connections = 512;
};

/// What the server asks others for.
struct WebParts {
  Gate& gate;
  ViewSource& views;
  std::vector<Topic*> topics;
  std::vector<Route> routes;
};

/// The panel's HTTP and WebSocket server (docs/api.md), on one port and on threads of its own.
class WebServer {
 public:
  /// Listens when it returns. `parts` and `counters`, which it counts in, must outlive it. Throws
  /// SettingsError naming /panel/address or /panel/port when it cannot listen there.
  WebServer(const WebParts& parts, const WebOptions& options, WebCounters& counters);
  ~WebServer();  // stop()

  /// Finishes the requests that are being handled, then closes all connections. Not for a handler.
  void stop();
  /// Begins that and does not wait for it: no request is handled any more, and those that are may end early
  /// (Request::stop).
  void ask_to_stop();

  /// Makes ready to listen elsewhere; what it returns, which cannot fail, ends listening where it did until
  /// then. Connections stay. One at a time, and not once it is stopped. Throws SettingsError as the
  /// constructor does.
  std::function<void()> move_to(const std::string& address, int port);

  /// The port it listens on.
  std::uint16_t port() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace sslv
