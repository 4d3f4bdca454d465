// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "web/camera_feeds.h"
#include "web/connections.h"
#include "web/counters.h"
#include "web/gate.h"
#include "web/route.h"

#include <chrono>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <utility>  // Boost 1.74's asio uses std::exchange without it
#include <vector>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/message.hpp>

namespace sslv {

class WebSocketSession;

/// Answers plain requests at the WebSocket's address.
std::vector<Route> websocket_routes();

/// All WebSocket viewers and their messages. Except for the counters, everything runs on the one thread of
/// `io`.
class WebSocketHub {
 public:
  using UpgradeRequest = boost::beast::http::request<boost::beast::http::empty_body>;
  /// kSecondPath: another connection of a client that counts as a viewer already.
  static constexpr std::string_view kPath = "/api/ws", kSecondPath = "/api/ws?second";

  /// All references and topics must outlive the hub. Topics are made on `workers`.
  WebSocketHub(boost::asio::io_context& io, boost::asio::io_context& workers, ViewSource& views,
               std::vector<Topic*> topics, CameraFeeds& feeds, WebCounters& counters);

  /// Completes the upgrade and serves the viewer until it disconnects or loses its access. `connection` holds
  /// `seat`.
  void accept(boost::asio::ip::tcp::socket socket, ScopedCount connection, Connections::Seat& seat,
              const UpgradeRequest& request, MayLook may_look);

 private:
  friend class WebSocketSession;

  void joined(WebSocketSession& session);
  void left(WebSocketSession& session);
  /// Returns why detections of some cameras are unavailable at present; empty: all are available. A tick
  /// retries.
  std::string follow_detections(WebSocketSession& session);

  void tick();                     // runs while there are viewers, whenever a wanted topic is due
  std::string look_at_sessions();  // returns the problem from follow_detections()
  /// By topic; null: nobody wants it, or it could not be made.
  using TopicMessages = std::vector<CameraFeed::Message>;
  TopicMessages make_messages(const std::vector<bool>& wanted) const;
  void send_topics(TopicMessages messages);
  void send_topic_soon(WebSocketSession& session, std::size_t topic);

  boost::asio::io_context& io_;
  boost::asio::io_context& workers_;
  ViewSource& views_;
  const std::vector<Topic*> topics_;
  CameraFeeds& feeds_;
  WebCounters& counters_;
  boost::asio::steady_timer timer_;
  using Clock = std::chrono::steady_clock;
  bool ticking_ = false;
  Clock::time_point look_due_{}, next_tick_{};
  std::string last_problem_;     // from the last look_at_sessions()
  TopicMessages last_messages_;  // at most one period old
  std::vector<Clock::time_point> topic_due_;
  std::map<CameraFeed::ViewerId, WebSocketSession*> sessions_;
};

}  // namespace sslv
