// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <utility>  // Boost 1.74's asio uses std::exchange without it

#include <boost/asio/ip/tcp.hpp>
#include <netinet/tcp.h>
#include <sys/socket.h>

namespace sslv {

/// Bounds what the kernel may hold back for a slow link: more would only be stale pictures and detections. A
/// viewer works without it as well, just with more delay.
inline void limit_unsent_bytes(boost::asio::ip::tcp::socket& socket) {
  constexpr int kMaxUnsentBytes = 64 * 1024;
  setsockopt(socket.native_handle(), IPPROTO_TCP, TCP_NOTSENT_LOWAT, &kMaxUnsentBytes,
             sizeof(kMaxUnsentBytes));
}

}  // namespace sslv
