// SPDX-License-Identifier: Apache-2.0
#pragma once

// Packets of GigE Vision's streaming protocol, which anyone can forge, and a socket that sends them.

#include "support/patience.h"

#include <cstdint>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

namespace sslv::test {

/// Most significant byte first, as in all of GigE Vision.
inline std::string big_endian(std::uint64_t number, int bytes) {
  std::string out;
  for (int i = bytes - 1; i >= 0; --i) out += i < 8 ? static_cast<char>(number >> (8 * i) & 0xff) : '\0';
  return out;
}

enum class GvspKind : std::uint8_t { kLeader = 1, kTrailer = 2, kPayload = 3, kAllIn = 4, kMultipart = 7 };

inline std::string gvsp_packet(GvspKind kind, std::uint16_t frame, std::uint32_t id,
                               std::string_view data = {}) {
  return big_endian(0, 2) + big_endian(frame, 2) +
         big_endian(std::uint32_t{static_cast<std::uint8_t>(kind)} << 24 | (id & 0xffffff), 4) +
         std::string(data);
}

/// With extended ids. `parts`: for a multipart leader.
inline std::string gvsp_extended_packet(GvspKind kind, std::uint64_t frame, std::uint32_t id,
                                        std::string_view data = {}, std::uint8_t parts = 0) {
  return big_endian(0, 4) + big_endian(0x80000000U | static_cast<std::uint32_t>(kind) << 24 | parts, 4) +
         big_endian(frame, 8) + big_endian(id, 4) + std::string(data);
}

constexpr std::uint32_t kGvspMono8 = 0x01080001;
constexpr std::uint16_t kGvspImage = 1, kGvspExtendedChunk = 5, kGvspMultipartImage = 10,
                        kGvspWithChunks = 0x4000;

inline std::string gvsp_image_leader(std::uint32_t width, std::uint32_t height,
                                     std::uint32_t format = kGvspMono8, std::uint16_t type = kGvspImage,
                                     std::uint16_t padding = 0) {
  return big_endian(0, 2) + big_endian(type, 2) + big_endian(0, 8) + big_endian(format, 4) +
         big_endian(width, 4) + big_endian(height, 4) + big_endian(0, 8) + big_endian(padding, 2) +
         big_endian(0, 2);
}

struct GvspPart {
  std::uint32_t width, height;
  std::uint64_t bytes;
  std::uint32_t format = kGvspMono8;
  std::uint16_t type = 1;  // a two-dimensional image
};
inline std::string gvsp_multipart_leader(const std::vector<GvspPart>& parts,
                                         std::uint16_t type = kGvspMultipartImage) {
  std::string out = big_endian(0, 2) + big_endian(type, 2) + big_endian(0, 8);
  for (const GvspPart& part : parts) {
    out += big_endian(part.type, 2) + big_endian(part.bytes, 6) + big_endian(part.format, 4) +
           big_endian(0, 12) + big_endian(part.width, 4) + big_endian(part.height, 4) + big_endian(0, 16);
  }
  return out;
}

/// A block of a part's data.
inline std::string gvsp_piece(std::uint64_t offset, std::string_view data) {
  return big_endian(0, 2) + big_endian(offset, 6) + std::string(data);
}

/// Sends datagrams from an address of this computer.
class UdpForger {
 public:
  explicit UdpForger(const std::string& from = "127.0.0.1")
      : socket_(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
    const sockaddr_in name = address_of(from, 0);
    const timeval patience{kPatience.count(), 0};
    ::setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    if (socket_ < 0 || ::bind(socket_, reinterpret_cast<const sockaddr*>(&name), sizeof name) != 0)
      throw std::runtime_error("no socket at " + from);
  }
  UdpForger(const UdpForger&) = delete;
  UdpForger& operator=(const UdpForger&) = delete;
  ~UdpForger() { ::close(socket_); }

  void send(std::uint16_t port, std::string_view bytes, const std::string& to = "127.0.0.1") const {
    const sockaddr_in name = address_of(to, port);
    ::sendto(socket_, bytes.data(), bytes.size(), 0, reinterpret_cast<const sockaddr*>(&name), sizeof name);
  }

  /// The port that a camera sends images to; it answers anyone who asks.
  std::uint16_t stream_port_of(const std::string& camera) const {
    constexpr std::uint16_t kControlPort = 3956;
    send(kControlPort, big_endian(0x42010080, 4) + big_endian(4, 2) + big_endian(1, 2) + big_endian(0xd00, 4),
         camera);
    unsigned char answer[64];
    if (::recv(socket_, answer, sizeof answer, 0) < 12) throw std::runtime_error(camera + " does not answer");
    return static_cast<std::uint16_t>(answer[10] << 8 | answer[11]);
  }

 private:
  static sockaddr_in address_of(const std::string& address, std::uint16_t port) {
    sockaddr_in name{};
    name.sin_family = AF_INET;
    name.sin_port = htons(port);
    inet_pton(AF_INET, address.c_str(), &name.sin_addr);
    return name;
  }

  const int socket_;
};

}  // namespace sslv::test
