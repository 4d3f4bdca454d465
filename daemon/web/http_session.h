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

/// What every connection needs of its server, which outlives it.
struct HttpContext {
  Gate& gate;
  const Router& router;
  WebSocketHub& websockets;
  CameraFeeds& feeds;
  boost::asio::io_context& workers;  // handlers run here
  boost::asio::io_context& quick;    // those that wait for nothing here
  /// And those that take much memory by one worker, one after the other.
  boost::asio::strand<boost::asio::io_context::executor_type>& one_by_one;
  std::atomic<int>& large_bytes;  // of large requests that are received and answered now
  std::atomic<int>& sent_files;   // that are sent now
};

/// Serves one connection until it ends: requests one after the other, or a WebSocket or
/// a stream of images once it asks for that.
/// Reading and writing take place on the socket's own thread and wait for nobody; a worker sees complete
/// requests only, so slow, idle and half-open clients cost memory but never a thread.
/// `connection` holds `seat`.
void serve_http(boost::asio::ip::tcp::socket socket, ScopedCount connection, Connections::Seat& seat,
                const HttpContext& context);

}  // namespace sslv
