// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/address_v4.hpp>
#include <boost/asio/ip/udp.hpp>
#include <boost/system/error_code.hpp>

namespace sslv {

/// Receives the UDP datagrams to one multicast or broadcast address and port. Does not occupy the port where
/// the system permits raw sockets (CAP_NET_RAW), because some teams' programs bind it without SO_REUSEADDR.
/// Such a program and a socket that occupies the port exclude each other.
class GroupSocket {
 public:
  struct Datagram {
    std::span<const std::byte> payload;  // in the buffer given to read()
    boost::asio::ip::udp::endpoint sender;
    unsigned card = 0;  // the system's number of the network card
  };

  /// If `card` is not empty, receives from the network card with this name only. Throws std::runtime_error.
  GroupSocket(boost::asio::io_context& io, const boost::asio::ip::address_v4& address, int port,
              const std::string& card = "");

  bool is_open() const { return socket_.is_open(); }
  void close();

  /// Joins the group on the card with this address, or on the card of the system's routes if `card` is
  /// unspecified. Packets of cards that this socket did not join are not received.
  void join(const boost::asio::ip::address_v4& card, boost::system::error_code& error);

  /// Calls the handler, with an error code, as soon as a datagram can be read or the socket is closed.
  template <class Handler>
  void async_wait(Handler handler) {
    socket_.async_wait(boost::asio::ip::udp::socket::wait_read, std::move(handler));
  }

  /// Never waits. `buffer` must hold 65,536 bytes; longer datagrams do not exist. Returns nothing and sets
  /// `error` if no datagram has arrived or the socket failed; returns nothing and no error if the datagram
  /// was damaged.
  std::optional<Datagram> read(std::span<std::byte> buffer, boost::system::error_code& error);

 private:
  boost::asio::ip::address_v4 address_;
  int port_;
  boost::asio::ip::udp::socket socket_;
  bool is_raw_;  // the port is not occupied
};

}  // namespace sslv
