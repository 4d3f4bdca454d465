// SPDX-License-Identifier: Apache-2.0
#include "net/group_socket.h"

#include <array>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <system_error>

#include <boost/asio/ip/multicast.hpp>
#include <linux/filter.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

namespace sslv {
namespace {

namespace asio = boost::asio;
using asio::ip::address_v4;
using asio::ip::udp;

constexpr std::size_t kUdpHeaderBytes = 8;

template <class T>
void set_option(int socket, int level, int option, const T& value) {
  if (setsockopt(socket, level, option, &value, sizeof value) != 0)
    throw std::system_error(errno, std::generic_category(), "cannot set an option of a socket");
}

/// Passes datagrams to this port only. Without this filter the socket would receive those to all ports of its
/// group.
void keep_only(int socket, int port) {
  constexpr std::uint32_t kPortOffset = 2;  // in the UDP header
  std::array<sock_filter, 5> program{{
      {BPF_LDX | BPF_B | BPF_MSH, 0, 0, 0},  // x = length of the IP header
      {BPF_LD | BPF_H | BPF_IND, 0, 0, kPortOffset},
      {BPF_JMP | BPF_JEQ | BPF_K, 0, 1, static_cast<std::uint32_t>(port)},
      {BPF_RET | BPF_K, 0, 0, UINT32_MAX},
      {BPF_RET | BPF_K, 0, 0, 0},
  }};
  set_option(socket, SOL_SOCKET, SO_ATTACH_FILTER,
             sock_fprog{static_cast<unsigned short>(program.size()), program.data()});
}

/// A raw socket, or -1 if this process may not have one.
int raw_socket(int port) {
  const int socket = ::socket(AF_INET, SOCK_RAW | SOCK_CLOEXEC, IPPROTO_UDP);
  if (socket < 0) return -1;
  try {
    keep_only(socket, port);
  } catch (const std::system_error&) {
    ::close(socket);
    return -1;
  }
  return socket;
}

std::uint16_t number_at(std::span<const std::byte> bytes, std::size_t offset) {
  return static_cast<std::uint16_t>(std::to_integer<unsigned>(bytes[offset]) << 8 |
                                    std::to_integer<unsigned>(bytes[offset + 1]));
}

/// The sum of 16-bit words that IP and UDP use.
std::uint32_t sum_of(std::span<const std::byte> bytes, std::uint32_t sum = 0) {
  for (std::size_t i = 0; i + 1 < bytes.size(); i += 2) {
    sum += number_at(bytes, i);
    sum = (sum & 0xFFFF) + (sum >> 16);
  }
  if (bytes.size() % 2 == 1) sum += std::to_integer<std::uint32_t>(bytes.back()) << 8;
  return (sum & 0xFFFF) + (sum >> 16);
}

/// Whether a UDP datagram's checksum is right, missing, or not complete yet, as in packets of this computer
/// and of virtual machines: those have only the sum of the addresses, protocol and length.
bool is_intact(std::span<const std::byte> ip_header, std::span<const std::byte> datagram) {
  constexpr std::size_t kAddressesOffset = 12, kAddressesBytes = 8, kSumOffset = 6;
  const std::uint32_t sum = number_at(datagram, kSumOffset);
  const std::uint32_t partial = sum_of(ip_header.subspan(kAddressesOffset, kAddressesBytes),
                                       IPPROTO_UDP + static_cast<std::uint32_t>(datagram.size()));
  return sum == 0 || sum == partial || sum_of(datagram, partial) == 0xFFFF;
}

/// Removes the IP and UDP headers from a packet. None if it is damaged, or is to another address or port:
/// such packets arrive before a raw socket has its filter.
std::optional<GroupSocket::Datagram> without_headers(std::span<const std::byte> packet, const address_v4& to,
                                                     int port) {
  constexpr std::size_t kWordBytes = 4, kFromOffset = 12, kToOffset = 16, kLeastIpBytes = 20;
  if (packet.empty()) return std::nullopt;
  const std::size_t ip_bytes = (std::to_integer<std::size_t>(packet[0]) & 0xF) * kWordBytes;
  if (ip_bytes < kLeastIpBytes || packet.size() < ip_bytes + kUdpHeaderBytes) return std::nullopt;
  const auto address_at = [&](std::size_t offset) {
    return address_v4(std::uint32_t{number_at(packet, offset)} << 16 | number_at(packet, offset + 2));
  };
  std::span<const std::byte> datagram = packet.subspan(ip_bytes);
  const std::size_t bytes = number_at(datagram, 4);
  if (address_at(kToOffset) != to || number_at(datagram, 2) != port || bytes < kUdpHeaderBytes ||
      bytes > datagram.size())
    return std::nullopt;
  datagram = datagram.first(bytes);
  if (!is_intact(packet, datagram)) return std::nullopt;
  return GroupSocket::Datagram{datagram.subspan(kUdpHeaderBytes),
                               udp::endpoint(address_at(kFromOffset), number_at(datagram, 0))};
}

unsigned card_in(msghdr& message) {
  for (cmsghdr* one = CMSG_FIRSTHDR(&message); one != nullptr; one = CMSG_NXTHDR(&message, one)) {
    if (one->cmsg_level != IPPROTO_IP || one->cmsg_type != IP_PKTINFO) continue;
    in_pktinfo info{};
    std::memcpy(&info, CMSG_DATA(one), sizeof info);
    return static_cast<unsigned>(info.ipi_ifindex);
  }
  return 0;
}

}  // namespace

GroupSocket::GroupSocket(asio::io_context& io, const address_v4& address, int port, const std::string& card)
    : address_(address), port_(port), socket_(io) {
  const int raw = raw_socket(port);
  is_raw_ = raw >= 0;
  if (is_raw_) {
    socket_.assign(udp::v4(), raw);
  } else {
    socket_.open(udp::v4());
    socket_.set_option(udp::socket::reuse_address(true));
  }
  const int number = socket_.native_handle();
  const int off = 0, on = 1;  // some emulators know neither option
  setsockopt(number, IPPROTO_IP, IP_MULTICAST_ALL, &off, sizeof off);
  setsockopt(number, IPPROTO_IP, IP_PKTINFO, &on, sizeof on);
  if (!card.empty() &&
      setsockopt(number, SOL_SOCKET, SO_BINDTODEVICE, card.c_str(), static_cast<socklen_t>(card.size())) != 0)
    throw std::system_error(errno, std::generic_category(), card);
  // Excludes packets of other groups and unicast. A raw socket ignores the port.
  boost::system::error_code error;
  socket_.bind({address, static_cast<std::uint16_t>(port)}, error);
  if (error == asio::error::address_in_use) {
    throw std::runtime_error(
        "another program uses this port without SO_REUSEADDR; end it, or give the service the right "
        "CAP_NET_RAW, with which it does not need the port");
  }
  if (error) throw boost::system::system_error(error, "cannot bind a socket");
  socket_.non_blocking(true);
}

void GroupSocket::close() {
  boost::system::error_code ignored;
  socket_.close(ignored);
}

void GroupSocket::join(const address_v4& card, boost::system::error_code& error) {
  if (card.is_unspecified()) {
    socket_.set_option(asio::ip::multicast::join_group(address_), error);
  } else {
    socket_.set_option(asio::ip::multicast::join_group(address_, card), error);
  }
}

std::optional<GroupSocket::Datagram> GroupSocket::read(std::span<std::byte> buffer,
                                                       boost::system::error_code& error) {
  sockaddr_in from{};
  alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof(in_pktinfo))> control;
  iovec part{buffer.data(), buffer.size()};
  msghdr message{};
  message.msg_name = &from;
  message.msg_namelen = sizeof from;
  message.msg_iov = &part;
  message.msg_iovlen = 1;
  message.msg_control = control.data();
  message.msg_controllen = control.size();
  const ssize_t bytes = ::recvmsg(socket_.native_handle(), &message, 0);
  error = bytes < 0 ? boost::system::error_code(errno, boost::system::system_category())
                    : boost::system::error_code();
  if (bytes < 0) return std::nullopt;
  const std::span<const std::byte> received = buffer.first(static_cast<std::size_t>(bytes));
  auto datagram =
      is_raw_
          ? without_headers(received, address_, port_)
          : Datagram{received, udp::endpoint(address_v4(ntohl(from.sin_addr.s_addr)), ntohs(from.sin_port))};
  if (datagram) datagram->card = card_in(message);
  return datagram;
}

}  // namespace sslv
