// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "net/multicast.h"
#include "support/patience.h"

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>

#include <arpa/inet.h>
#include <fmt/format.h>
#include <sys/socket.h>
#include <unistd.h>

namespace sslv {

/// Receives packets sent to a test group through the loopback interface.
class GroupListener {
 public:
  /// A group of this process: other processes' sockets are not members.
  static inline const std::string kGroup =
      fmt::format("239.{}.{}.{}", 192 + (getpid() >> 16 & 63), getpid() >> 8 & 255, getpid() & 255);

  /// Uses a free port if `port` is 0. Throws std::runtime_error if it cannot listen.
  explicit GroupListener(std::uint16_t port = 0) : fd_(socket(AF_INET, SOCK_DGRAM, 0)) {
    // A given port is shared. A free port is bound exclusively first and shared afterwards.
    if (port != 0) set(SOL_SOCKET, SO_REUSEADDR, 1);
    sockaddr_in local{};
    local.sin_family = AF_INET;
    local.sin_port = htons(port);
    inet_pton(AF_INET, kGroup.c_str(), &local.sin_addr);
    check(bind(fd_, reinterpret_cast<const sockaddr*>(&local), sizeof local), "bind");
    if (port == 0) set(SOL_SOCKET, SO_REUSEADDR, 1);
    ip_mreq membership{local.sin_addr, {htonl(INADDR_LOOPBACK)}};
    set(IPPROTO_IP, IP_ADD_MEMBERSHIP, membership);
    set(IPPROTO_IP, IP_RECVTTL, 1);
    set(SOL_SOCKET, SO_RXQ_OVFL, 1);
    // On a busy computer tests read late.
    constexpr int kBufferBytes = 4 << 20;
    set(SOL_SOCKET, SO_RCVBUF, kBufferBytes);
    socklen_t length = sizeof local;
    check(getsockname(fd_, reinterpret_cast<sockaddr*>(&local), &length), "getsockname");
    port_ = ntohs(local.sin_port);
  }
  ~GroupListener() { close(fd_); }
  GroupListener(const GroupListener&) = delete;
  GroupListener& operator=(const GroupListener&) = delete;

  std::uint16_t port() const { return port_; }
  int fd() const { return fd_; }

  /// The next datagram; nullopt on timeout.
  std::optional<std::string> receive(int timeout_ms = int{
                                         std::chrono::milliseconds(test::kPatience).count()}) {
    const timeval timeout{timeout_ms / 1000, timeout_ms % 1000 * 1000};
    set(SOL_SOCKET, SO_RCVTIMEO, timeout);
    std::array<char, 65536> data;
    alignas(cmsghdr) std::array<char, 256> control;
    iovec part{data.data(), data.size()};
    sockaddr_in sender{};
    msghdr message{};
    message.msg_name = &sender;
    message.msg_namelen = sizeof sender;
    message.msg_iov = &part;
    message.msg_iovlen = 1;
    message.msg_control = control.data();
    message.msg_controllen = control.size();
    const ssize_t size = recvmsg(fd_, &message, 0);
    if (size < 0) return std::nullopt;
    last_sender_port_ = ntohs(sender.sin_port);
    for (const cmsghdr* item = CMSG_FIRSTHDR(&message); item;
         item = CMSG_NXTHDR(&message, const_cast<cmsghdr*>(item))) {
      if (item->cmsg_level == IPPROTO_IP && item->cmsg_type == IP_TTL) {
        last_ttl_ = *reinterpret_cast<const int*>(CMSG_DATA(item));
      }
      if (item->cmsg_level == SOL_SOCKET && item->cmsg_type == SO_RXQ_OVFL)
        overflows_ = *reinterpret_cast<const std::uint32_t*>(CMSG_DATA(item));
    }
    return std::string(data.data(), static_cast<std::size_t>(size));
  }

  int last_ttl() const { return last_ttl_; }
  std::uint16_t last_sender_port() const { return last_sender_port_; }
  /// Datagrams dropped because this was read too late.
  std::uint32_t overflows() const { return overflows_; }

 private:
  template <class T>
  void set(int level, int option, T value) {
    check(setsockopt(fd_, level, option, &value, sizeof value), "setsockopt");
  }
  static void check(int result, const char* what) {
    if (result != 0) throw std::runtime_error(what);
  }

  int fd_;
  std::uint16_t port_ = 0, last_sender_port_ = 0;
  int last_ttl_ = 0;
  std::uint32_t overflows_ = 0;
};

/// Settings of a sender to this listener.
inline MulticastSettings settings_for(const GroupListener& listener) {
  MulticastSettings settings;
  settings.group = GroupListener::kGroup;
  settings.port = listener.port();
  settings.interface = "127.0.0.1";
  return settings;
}

inline bool send(MulticastSender& sender, const std::string& datagram) {
  return sender.send(std::as_bytes(std::span(datagram)));
}

}  // namespace sslv
