// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <utility>  // Boost 1.74's asio uses std::exchange without it

#include <boost/asio/ip/tcp.hpp>
#include <netinet/tcp.h>
#include <sys/socket.h>

namespace sslv {

/// Limits the bytes the kernel buffers for a slow link: more would only be stale images and detections.
/// Viewers also work if setting this fails, with more delay.
inline void limit_unsent_bytes(boost::asio::ip::tcp::socket& socket, int max_bytes = 16 * 1024) {
  setsockopt(socket.native_handle(), IPPROTO_TCP, TCP_NOTSENT_LOWAT, &max_bytes, sizeof(max_bytes));
}

/// Address of the peer; an IPv4 address is written as such even if it arrives over an IPv6 socket.
inline std::string remote_address(const boost::asio::ip::tcp::socket& socket) {
  boost::system::error_code ignored;
  const auto address = socket.remote_endpoint(ignored).address();
  if (address.is_v6() && address.to_v6().is_v4_mapped()) {
    return boost::asio::ip::make_address_v4(boost::asio::ip::v4_mapped, address.to_v6()).to_string();
  }
  return address.to_string();
}

}  // namespace sslv
