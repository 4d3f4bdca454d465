// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "web/access.h"
#include "web/camera_feeds.h"
#include "web/counters.h"
#include "web/host.h"

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <utility>  // Boost 1.74's asio uses std::exchange without it

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/message.hpp>

namespace sslv {

class WebSocketSession;

/// All WebSocket viewers and what they are sent. Except for the counters and stop(), everything runs on the
/// one thread of `io`.
class WebSocketHub {
 public:
  using UpgradeRequest = boost::beast::http::request<boost::beast::http::empty_body>;
  static constexpr std::string_view kPath = "/api/ws";

  /// All five must outlive the hub. The status is asked for on `workers`.
  WebSocketHub(boost::asio::io_context& io, boost::asio::io_context& workers, const WebHost& host,
               CameraFeeds& feeds, WebCounters& counters);

  /// Answers the request to upgrade and serves the viewer until it goes or may not look any more.
  void accept(boost::asio::ip::tcp::socket socket, ScopedCount connection, const UpgradeRequest& request,
              MayLook may_look);

 private:
  friend class WebSocketSession;

  void joined(WebSocketSession& session);
  void left(WebSocketSession& session);
  void follow_detections(WebSocketSession& session);

  void tick();  // every half second while there are viewers
  void look_at_sessions();
  void complain(const std::string& problem);  // once, however often it comes again
  void send_status(const CameraFeed::Message& status);
  void send_status_soon(WebSocketSession& session);

  boost::asio::io_context& io_;
  boost::asio::io_context& workers_;
  const WebHost& host_;
  CameraFeeds& feeds_;
  WebCounters& counters_;
  boost::asio::steady_timer timer_;
  bool ticking_ = false;
  std::string last_problem_;
  CameraFeed::Message last_status_;  // at most one period old, or null
  std::map<CameraFeed::ViewerId, WebSocketSession*> sessions_;
};

}  // namespace sslv
