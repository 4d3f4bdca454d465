// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "web/camera_feeds.h"
#include "web/connections.h"
#include "web/counters.h"
#include "web/gate.h"

#include <utility>  // Boost 1.74's asio uses std::exchange without it

#include <boost/asio/ip/tcp.hpp>

namespace sslv {

/// Sends images until the client goes, may not look any more or takes nothing for 30 s: the body of an
/// answer of kStreamType, whose head is on its way. The next image is asked for when the one before has
/// left, so that none waits for a slow link. Runs on the socket's thread alone; `feeds` must outlive it.
/// `connection` holds `seat`.
void stream_pictures(boost::asio::ip::tcp::socket socket, ScopedCount connection, Connections::Seat& seat,
                     CameraFeeds& feeds, const StreamWish& wish, MayLook may_look);

}  // namespace sslv
