// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "web/camera_feeds.h"
#include "web/connections.h"
#include "web/counters.h"
#include "web/gate.h"

#include <utility>  // Boost 1.74's asio uses std::exchange without it

#include <boost/asio/ip/tcp.hpp>

namespace sslv {

/// Sends images until the client disconnects, loses its access or receives nothing for 30 s. The images are
/// the body of an answer of kStreamType, whose head is already being sent. Each image is requested after the
/// previous image was sent, so that no image waits for a slow link. Runs on the socket's thread; `feeds` must
/// outlive it. `connection` holds `seat`.
void stream_pictures(boost::asio::ip::tcp::socket socket, ScopedCount connection, Connections::Seat& seat,
                     CameraFeeds& feeds, const StreamWish& wish, MayLook may_look);

}  // namespace sslv
