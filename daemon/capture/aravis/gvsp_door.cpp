// SPDX-License-Identifier: Apache-2.0
#include "capture/aravis/gvsp_door.h"

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <string>
#include <system_error>
#include <utility>

#include <linux/if_ether.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

namespace sslv {
namespace {

// The GVSP header begins with a status, whose highest bit means that the camera cannot send the packet. The
// fifth byte holds the packet type and a bit that selects the header's length, standard or extended.
constexpr std::uint32_t kStatusAt = 0, kErrorBit = 0x8000;
constexpr std::uint32_t kStandardHeader = 8, kExtendedHeader = 20;
constexpr std::uint32_t kKindAt = 4, kExtendedBit = 0x80, kKindMask = 0x7f;
constexpr std::uint32_t kLeader = 1, kTrailer = 2, kPayload = 3, kMultipart = 7;
constexpr std::uint32_t kStandardIdMask = 0x00ffffff, kExtendedIdAt = 16;
// Fields of a leader packet, counted from the end of the header.
constexpr std::uint32_t kLeaderBytes = 12, kImageLeaderBytes = 36, kPayloadTypeAt = 2,
                        kPayloadTypeMask = 0x3fff;
constexpr std::uint32_t kImageType = 1, kExtendedChunkType = 5, kMultipartType = 10;
constexpr std::uint32_t kPartCountAt = 7, kPartBytes = 48, kPartSizeHighAt = 2, kPartSizeLowAt = 4;
/// Maximum number of parts in a multipart image: 3D cameras send up to four.
constexpr std::uint32_t kMaxParts = 4;
constexpr std::uint32_t kMultipartBytes = 8;  // header before each block of a part
constexpr std::size_t kIpAndUdp = 28;
/// Packets allowed beyond the number that the image's size requires, because the last block of a part need
/// not be full.
constexpr std::uint32_t kSpareIds = 16;

constexpr std::uint32_t kWholePacket = 0x40000;

/// A sequence of BPF instructions that either passes or drops the packet, or continues with the following
/// instructions.
class Rules {
 public:
  void load(unsigned size, std::uint32_t at) { add(BPF_STMT(BPF_LD | size | BPF_ABS, at)); }
  void load_byte(std::uint32_t at) { load(BPF_B, at); }
  void load_half(std::uint32_t at) { load(BPF_H, at); }
  void load_word(std::uint32_t at) { load(BPF_W, at); }
  void load_length() { add(BPF_STMT(BPF_LD | BPF_W | BPF_LEN, 0)); }
  void mask(std::uint32_t bits) { add(BPF_STMT(BPF_ALU | BPF_AND | BPF_K, bits)); }
  void subtract(std::uint32_t number) { add(BPF_STMT(BPF_ALU | BPF_SUB | BPF_K, number)); }

  void require_equal(std::uint32_t number) { require(BPF_JEQ, number, true); }
  void require_at_least(std::uint32_t number) { require(BPF_JGE, number, true); }
  void require_at_most(std::uint32_t number) { require(BPF_JGT, number, false); }
  /// Requires at least the number of received bytes that the packet's IP header states.
  void require_has_come(std::uint32_t ip, std::uint32_t length_at) {
    load_length();
    subtract(ip);
    add(BPF_STMT(BPF_MISC | BPF_TAX, 0));
    load_half(length_at);
    add(BPF_JUMP(BPF_JMP | BPF_JGT | BPF_X, 0, 0, 1));
    drop();
  }
  void pass() { add(BPF_STMT(BPF_RET | BPF_K, kWholePacket)); }
  void drop() { add(BPF_STMT(BPF_RET | BPF_K, 0)); }

  /// Keeps the loaded value for the next when_equal().
  void when_equal(std::uint32_t number, const Rules& then) {
    // The maximum BPF jump distance.
    constexpr std::size_t kFurthest = 255;
    if (then.program_.size() > kFurthest) return drop();
    add(BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, number, 0, static_cast<std::uint8_t>(then.program_.size())));
    append(then);
  }
  void append(const Rules& then) {
    program_.insert(program_.end(), then.program_.begin(), then.program_.end());
  }

  GvspFilter take() { return std::move(program_); }

 private:
  void add(const sock_filter& instruction) { program_.push_back(instruction); }
  void require(unsigned compare, std::uint32_t number, bool wanted) {
    add(BPF_JUMP(BPF_JMP | compare | BPF_K, number, wanted ? std::uint8_t{1} : std::uint8_t{0},
                 wanted ? std::uint8_t{0} : std::uint8_t{1}));
    drop();
  }

  GvspFilter program_;
};

/// Positions in a packet as the filter sees it.
struct Place {
  std::uint32_t gvsp;
  std::uint32_t size_at, size_beyond;  // offset of a length field; its excess over GVSP's length
};

/// Rules for packets with the standard or the extended header.
class HeaderRules {
 public:
  HeaderRules(const GvspBounds& bounds, const Place& place, bool is_extended)
      : place_(place),
        is_extended_(is_extended),
        header_(is_extended ? kExtendedHeader : kStandardHeader),
        buffer_bytes_(static_cast<std::uint32_t>(std::min<std::size_t>(bounds.buffer_bytes, UINT32_MAX))),
        max_bytes_(
            static_cast<std::uint32_t>(bounds.packet_bytes - std::min(bounds.packet_bytes, kIpAndUdp))),
        block_(max_bytes_ - std::min(max_bytes_, header_)) {}

  Rules all() const {
    Rules rules;
    // Packets must have space for image data after a multipart header.
    if (block_ <= kMultipartBytes) {
      rules.drop();
      return rules;
    }
    load_size(rules);
    rules.require_at_least(header_);
    rules.require_at_most(max_bytes_);
    rules.load_byte(place_.gvsp + kKindAt);
    rules.mask(kKindMask);
    rules.when_equal(kLeader, leader());
    rules.when_equal(kTrailer, with_id(1, ids_for(block_) + 1 + kSpareIds, 0));
    rules.when_equal(kPayload, with_id(1, ids_for(block_), 1));
    if (is_extended_)
      rules.when_equal(kMultipart,
                       with_id(1, ids_for(block_ - kMultipartBytes) + kSpareIds, kMultipartBytes + 1));
    rules.drop();
    return rules;
  }

 private:
  void load_size(Rules& rules) const {
    rules.load_half(place_.size_at);
    rules.subtract(place_.size_beyond);
  }
  void require_behind_header(Rules& rules, std::uint32_t bytes) const {
    load_size(rules);
    rules.require_at_least(header_ + bytes);
  }
  void load_id(Rules& rules) const {
    rules.load_word(place_.gvsp + (is_extended_ ? kExtendedIdAt : kKindAt));
    if (!is_extended_) rules.mask(kStandardIdMask);
  }
  /// Number of packets that fill a buffer.
  std::uint32_t ids_for(std::uint32_t block) const { return (buffer_bytes_ - 1) / block + 1; }

  /// Requires an id in [least, most] and at least `bytes` after the header. A packet with the error status
  /// needs no data, because the library reads only its header and then stops requesting missing packets of
  /// this image.
  Rules with_id(std::uint32_t least, std::uint32_t most, std::uint32_t bytes) const {
    Rules rules, sent;
    require_behind_header(sent, bytes);
    rules.load_half(place_.gvsp + kStatusAt);
    rules.mask(kErrorBit);
    rules.when_equal(0, sent);
    load_id(rules);
    rules.require_at_least(least);
    rules.require_at_most(most);
    rules.pass();
    return rules;
  }

  Rules leader() const {
    Rules image;
    require_behind_header(image, kImageLeaderBytes);
    image.pass();
    Rules rules;
    require_behind_header(rules, kLeaderBytes);
    load_id(rules);
    rules.require_equal(0);
    rules.load_half(place_.gvsp + header_ + kPayloadTypeAt);
    rules.mask(kPayloadTypeMask);
    rules.when_equal(kImageType, image);
    rules.when_equal(kExtendedChunkType, image);
    rules.when_equal(kMultipartType, multipart_leader());
    rules.pass();  // the library itself rejects the other types
    return rules;
  }

  /// Only a leader with the extended header can be multipart: the number of parts is stored in bytes that the
  /// standard header uses for the packet id, which is 0 in a leader.
  Rules multipart_leader() const {
    Rules rules;
    if (!is_extended_) {
      rules.drop();
      return rules;
    }
    for (std::uint32_t count = 1; count <= kMaxParts; ++count) {
      Rules parts;
      require_behind_header(parts, kLeaderBytes + count * kPartBytes);
      for (std::uint32_t i = 0; i < count; ++i) {
        const std::uint32_t part = place_.gvsp + header_ + kLeaderBytes + i * kPartBytes;
        parts.load_half(part + kPartSizeHighAt);
        parts.require_equal(0);
        parts.load_word(part + kPartSizeLowAt);
        parts.require_at_most(buffer_bytes_);
      }
      parts.pass();
      rules.load_byte(place_.gvsp + kPartCountAt);
      rules.when_equal(count, parts);
    }
    rules.drop();
    return rules;
  }

  const Place place_;
  const bool is_extended_;
  const std::uint32_t header_;
  const std::uint32_t buffer_bytes_;
  const std::uint32_t max_bytes_;  // GVSP bytes per packet
  const std::uint32_t block_;      // image bytes per packet
};

void add_gvsp(Rules& rules, const GvspBounds& bounds, const Place& place) {
  if (bounds.buffer_bytes == 0) return rules.drop();
  rules.load_half(place.size_at);
  rules.subtract(place.size_beyond);
  rules.require_at_least(kStandardHeader);
  rules.require_at_most(UINT16_MAX);  // larger after an underflow: the field was smaller than size_beyond
  rules.load_byte(place.gvsp + kKindAt);
  rules.mask(kExtendedBit);
  rules.when_equal(0, HeaderRules(bounds, place, false).all());
  rules.append(HeaderRules(bounds, place, true).all());
}

bool attach(int socket, const GvspFilter& filter) {
  sock_fprog program{};
  program.len = static_cast<unsigned short>(filter.size());
  program.filter = const_cast<sock_filter*>(filter.data());
  return ::setsockopt(socket, SOL_SOCKET, SO_ATTACH_FILTER, &program, sizeof program) == 0;
}

int option_of(int socket, int option) {
  int value = -1;
  socklen_t size = sizeof value;
  return ::getsockopt(socket, SOL_SOCKET, option, &value, &size) == 0 ? value : -1;
}

bool is_udp_socket_at(int socket, std::uint16_t port) {
  sockaddr_in name{};
  socklen_t size = sizeof name;
  return option_of(socket, SO_DOMAIN) == AF_INET && option_of(socket, SO_TYPE) == SOCK_DGRAM &&
         ::getsockname(socket, reinterpret_cast<sockaddr*>(&name), &size) == 0 &&
         ntohs(name.sin_port) == port;
}

/// Recognises the socket by its filter: both the library's filter and ours compare with the camera's address
/// and the port.
bool is_packet_socket_for(int socket, const GvspBounds& bounds) {
  if (option_of(socket, SO_DOMAIN) != AF_PACKET) return false;
  socklen_t count = 0;  // number of instructions
  if (::getsockopt(socket, SOL_SOCKET, SO_GET_FILTER, nullptr, &count) != 0 || count == 0) return false;
  GvspFilter filter(count);
  if (::getsockopt(socket, SOL_SOCKET, SO_GET_FILTER, filter.data(), &count) != 0) return false;
  const auto asks_for = [&](std::uint32_t number) {
    return std::any_of(filter.begin(), filter.end(), [=](const sock_filter& one) {
      return one.code == (BPF_JMP | BPF_JEQ | BPF_K) && one.k == number;
    });
  };
  return asks_for(bounds.camera) && asks_for(bounds.port);
}

}  // namespace

GvspFilter gvsp_udp_filter(const GvspBounds& bounds) {
  constexpr std::uint32_t kUdpHeader = 8, kUdpLengthAt = 4, kSourceAddressAt = 12;
  Rules rules;
  rules.load_word(static_cast<std::uint32_t>(SKF_NET_OFF) + kSourceAddressAt);
  rules.require_equal(bounds.camera);
  add_gvsp(rules, bounds, {kUdpHeader, kUdpLengthAt, kUdpHeader});
  return rules.take();
}

GvspFilter gvsp_packet_filter(const GvspBounds& bounds) {
  constexpr std::uint32_t kIp = ETH_HLEN, kUdp = kIp + 20, kGvsp = kUdp + 8;
  constexpr std::uint32_t kVersion4With20Bytes = 0x45, kFragment = 0x3fff;
  Rules rules;
  rules.load_half(ETH_HLEN - 2);
  rules.require_equal(ETH_P_IP);
  rules.load_byte(kIp);
  rules.require_equal(kVersion4With20Bytes);
  rules.load_half(kIp + 6);
  rules.mask(kFragment);
  rules.require_equal(0);
  rules.load_byte(kIp + 9);
  rules.require_equal(IPPROTO_UDP);
  rules.load_word(kIp + 12);
  rules.require_equal(bounds.camera);
  rules.load_word(kIp + 16);
  rules.require_equal(bounds.own);
  rules.load_half(kUdp + 2);
  rules.require_equal(bounds.port);
  rules.require_has_come(kIp, kIp + 2);
  add_gvsp(rules, bounds, {kGvsp, kIp + 2, static_cast<std::uint32_t>(kIpAndUdp)});
  return rules.take();
}

bool may_open_packet_sockets() {
  const int socket = ::socket(AF_PACKET, SOCK_RAW | SOCK_CLOEXEC, 0);
  if (socket >= 0) ::close(socket);
  return socket >= 0;
}

int guard_gvsp_sockets(const GvspBounds& bounds) {
  const GvspFilter udp = gvsp_udp_filter(bounds), packet = gvsp_packet_filter(bounds);
  int guarded = 0;
  std::error_code error;
  for (std::filesystem::directory_iterator i("/proc/self/fd", error); !error && i != end(i);
       i.increment(error)) {
    const std::string name = i->path().filename().string();
    int socket = -1;
    std::from_chars(name.data(), name.data() + name.size(), socket);
    if (is_udp_socket_at(socket, bounds.port)) {
      guarded += attach(socket, udp) ? 1 : 0;
    } else if (is_packet_socket_for(socket, bounds)) {
      guarded += attach(socket, packet) ? 1 : 0;
    }
  }
  return guarded;
}

}  // namespace sslv
