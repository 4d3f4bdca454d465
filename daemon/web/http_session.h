// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "web/camera_feeds.h"
#include "web/connections.h"
#include "web/counters.h"
#include "web/gate.h"
#include "web/router.h"
#include "web/websocket.h"

#include <atomic>
#include <utility>  // Boost 1.74's asio uses std::exchange without it

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/strand.hpp>

namespace sslv {

/// The parts of the server that each connection uses; they outlive the connection.
struct HttpContext {
  Gate& gate;
  const Router& router;
  WebSocketHub& websockets;
  CameraFeeds& feeds;
  boost::asio::io_context& workers;  // for handlers
  boost::asio::io_context& quick;    // for handlers that wait for nothing
  /// For handlers that take much memory: one worker runs them one after the other.
  boost::asio::strand<boost::asio::io_context::executor_type>& one_by_one;
  std::atomic<int>& large_bytes;  // bytes of large requests being received and answered
  std::atomic<int>& sent_files;   // files being sent
};

/// Serves one connection until it ends: requests one after the other, or a WebSocket or an image stream once
/// the client asks for one.
///
/// The socket's own thread reads and writes without blocking; workers get complete requests only, so slow,
/// idle and half-open clients cost memory but never a thread. `connection` holds `seat`.
void serve_http(boost::asio::ip::tcp::socket socket, ScopedCount connection, Connections::Seat& seat,
                const HttpContext& context);

}  // namespace sslv
