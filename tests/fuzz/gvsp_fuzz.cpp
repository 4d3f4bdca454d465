// SPDX-License-Identifier: Apache-2.0
// libFuzzer: for any packets sent as a GigE camera's images, those that pass the kernel's filters make the
// library allocate little memory and write only into its buffers. Whatever properties it then reports for an
// image, an accepted image lies within its buffer. An input is a byte that selects the sizes of buffers and
// packets, followed by the reported image properties if that byte is odd, otherwise by packets, each preceded
// by a length of two bytes. ./run test-long
#include "capture/aravis/aravis_images.h"
#include "capture/aravis/gvsp_door.h"
#include "fuzz/expect.h"
#include "fuzz/live_bytes.h"

#include <algorithm>
#include <cstring>
#include <optional>
#include <span>
#include <vector>

#include <linux/if_ether.h>

namespace sslv {

unsigned seen = 0;  // keeps the compiler from removing the reads

namespace {

using Bytes = std::span<const std::uint8_t>;

std::optional<std::uint32_t> number_at(Bytes bytes, std::uint64_t at, std::size_t size) {
  if (at + size > bytes.size()) return std::nullopt;
  std::uint32_t number = 0;
  for (const std::uint8_t byte : bytes.subspan(at, size)) number = number << 8 | byte;
  return number;
}

/// Runs a filter like the kernel. `bytes`: the packet as seen by the socket; `network`: its IP header, for
/// loads relative to SKF_NET_OFF.
bool passes(const GvspFilter& filter, Bytes bytes, Bytes network) {
  std::uint32_t a = 0, x = 0;
  for (std::size_t i = 0; i < filter.size(); ++i) {
    const sock_filter& instruction = filter[i];
    const std::uint32_t k = instruction.k;
    const auto load = [&](std::size_t size) {
      const bool is_network = k >= static_cast<std::uint32_t>(SKF_NET_OFF);
      const auto number = is_network ? number_at(network, k - static_cast<std::uint32_t>(SKF_NET_OFF), size)
                                     : number_at(bytes, k, size);
      a = number.value_or(0);
      return number.has_value();
    };
    const auto jump = [&](bool holds) { i += holds ? instruction.jt : instruction.jf; };
    switch (instruction.code) {
      case BPF_LD | BPF_W | BPF_ABS:
        if (!load(4)) return false;
        break;
      case BPF_LD | BPF_H | BPF_ABS:
        if (!load(2)) return false;
        break;
      case BPF_LD | BPF_B | BPF_ABS:
        if (!load(1)) return false;
        break;
      case BPF_LD | BPF_W | BPF_LEN: a = static_cast<std::uint32_t>(bytes.size()); break;
      case BPF_ALU | BPF_AND | BPF_K: a &= k; break;
      case BPF_ALU | BPF_SUB | BPF_K: a -= k; break;
      case BPF_MISC | BPF_TAX: x = a; break;
      case BPF_JMP | BPF_JEQ | BPF_K: jump(a == k); break;
      case BPF_JMP | BPF_JGE | BPF_K: jump(a >= k); break;
      case BPF_JMP | BPF_JGT | BPF_K: jump(a > k); break;
      case BPF_JMP | BPF_JGT | BPF_X: jump(a > x); break;
      case BPF_RET | BPF_K: return k != 0;
      default: expect(false, "an instruction that a filter has not");
    }
  }
  expect(false, "a filter without an end");
  return false;
}

/// Checks how much memory the library allocates and writes because of a packet's numbers.
void check_numbers(Bytes gvsp, const GvspBounds& bounds) {
  expect(gvsp.size() >= 8, "a packet without a header");
  const bool is_extended = (gvsp[4] & 0x80) != 0;
  const std::size_t header = is_extended ? 20 : 8;
  expect(gvsp.size() >= header, "a packet without an extended header");
  const std::uint32_t id = is_extended ? *number_at(gvsp, 16, 4) : *number_at(gvsp, 4, 4) & 0xffffff;
  const std::size_t data = gvsp.size() - header;
  const bool is_gone = (gvsp[0] & 0x80) != 0;  // error status: only the header is read
  expect(bounds.packet_bytes > 28 + header, "a packet where none fits");
  const std::size_t block = bounds.packet_bytes - 28 - header;
  const std::size_t most_packets = 4 * (bounds.buffer_bytes / (block > 8 ? block - 8 : 1) + 64);
  switch (gvsp[4] & 0x7f) {
    case 1: {
      expect(id == 0, "a leader that is not the first");
      expect(data >= 12, "a leader of nothing");
      const std::uint32_t type = *number_at(gvsp, header + 2, 2) & 0x3fff;
      if (type == 1 || type == 5) expect(data >= 36, "a leader without its image");
      if (type != 10) return;
      const std::size_t parts = gvsp[7];
      expect(data >= 12 + 48 * parts, "parts that are not there");
      std::size_t packets = 0;
      for (std::size_t i = 0; i < parts; ++i) {
        const std::size_t at = header + 12 + 48 * i;
        const std::uint64_t size =
            std::uint64_t{*number_at(gvsp, at + 2, 2)} << 32 | *number_at(gvsp, at + 4, 4);
        packets += (size + block - 9) / (block - 8);
      }
      expect(packets <= most_packets, "parts that take memory without an end");
      return;
    }
    case 2: expect(id >= 1 && id <= most_packets, "a trailer that takes memory without an end"); return;
    case 3:
      expect(id >= 1 && std::uint64_t{id - 1} * block < bounds.buffer_bytes, "a block outside of the buffer");
      expect((is_gone || data >= 1) && data <= block, "a block of another size");
      return;
    case 7: expect(id >= 1 && id <= most_packets && (is_gone || data >= 8), "a piece that is none"); return;
    default: expect(false, "a packet of a kind that is not read");
  }
}

void look_through_door(Bytes packet, const GvspBounds& bounds, const GvspFilter& udp, const GvspFilter& raw) {
  // Prepends a UDP header with a correct length, which the kernel ensures.
  std::vector<std::uint8_t> datagram(8);
  datagram.insert(datagram.end(), packet.begin(), packet.end());
  datagram[4] = static_cast<std::uint8_t>(datagram.size() >> 8);
  datagram[5] = static_cast<std::uint8_t>(datagram.size());
  std::uint8_t ip[20] = {0x45};
  const std::uint32_t camera = __builtin_bswap32(bounds.camera), own = __builtin_bswap32(bounds.own);
  std::memcpy(ip + 12, &camera, 4);
  std::memcpy(ip + 16, &own, 4);
  const bool passes_udp = passes(udp, datagram, ip);
  if (passes_udp) check_numbers(packet, bounds);
  ip[12] ^= 1;
  expect(!passes(udp, datagram, ip), "a packet of another address");

  // The input as a whole frame, with any headers.
  if (passes(raw, packet, {})) {
    expect(packet.size() >= ETH_HLEN + 28, "a packet without headers");
    const std::size_t length = *number_at(packet, ETH_HLEN + 2, 2);
    expect(ETH_HLEN + length <= packet.size() && length >= 28, "a packet that is not all there");
    expect(*number_at(packet, ETH_HLEN + 12, 4) == bounds.camera, "a packet of another address");
    expect(*number_at(packet, ETH_HLEN + 22, 2) == bounds.port, "a packet to another port");
    check_numbers(packet.subspan(ETH_HLEN + 28, length - 28), bounds);
  }
  // And with correct headers.
  ip[12] ^= 1;
  std::vector<std::uint8_t> frame(12);
  frame.insert(frame.end(), {0x08, 0x00});
  const std::size_t length = 20 + datagram.size();
  ip[2] = static_cast<std::uint8_t>(length >> 8);
  ip[3] = static_cast<std::uint8_t>(length);
  ip[9] = 17;
  frame.insert(frame.end(), std::begin(ip), std::end(ip));
  datagram[2] = static_cast<std::uint8_t>(bounds.port >> 8);
  datagram[3] = static_cast<std::uint8_t>(bounds.port);
  frame.insert(frame.end(), datagram.begin(), datagram.end());
  expect(passes(raw, frame, {}) == passes_udp, "two doors that differ");
}

/// `input`: the claimed properties of an image, chosen by an attacker. The buffer has no slack at its end.
void look_at_picture(Bytes input) {
  struct {
    std::uint16_t allocated, came;
    std::uint64_t offset, bytes;
    std::uint32_t format;
    std::int16_t width, height, padding;
  } said{};
  if (input.size() < sizeof said) return;
  std::memcpy(&said, input.data(), sizeof said);
  const std::vector<std::uint8_t> buffer(said.allocated);
  const ClaimedPicture claimed{said.format, said.width, said.height, said.padding,
                               said.offset, said.bytes, said.came,   buffer.size()};
  std::string problem;
  const SentPicture sent = sound_picture(claimed, buffer.data(), problem);
  expect((sent.format == nullptr) == !problem.empty(), "neither an image nor a reason");
  if (sent.format == nullptr) return;
  if (sent.format->is_copied()) {
    AravisUnpacker unpacker(1);
    Image image;
    expect(unpacker.unpack(sent, image), "an image that is not unpacked");
    const ImageView& view = image.view();
    expect(view.width == said.width && view.height == said.height, "another size");
    return;
  }
  const ImageView view = view_of(sent);
  for (int y = 0; y < view.height; ++y) {
    for (int x = 0; x < view.width * bytes_per_pixel(view.format); ++x) seen += view.row(y)[x];
  }
}

}  // namespace
}  // namespace sslv

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace sslv;
  if (size == 0) return 0;
  const LiveBytes live(kMaxLiveBytes);
  Bytes rest(bytes + 1, size - 1);
  if (bytes[0] % 2 == 1) {
    look_at_picture(rest);
    return 0;
  }
  struct Door {
    GvspBounds bounds;
    GvspFilter udp, raw;
  };
  static const std::vector<Door> kDoors = [] {
    std::vector<Door> doors;
    for (const std::size_t buffer : {1, 3000, 100'000, 25'000'000}) {
      for (const std::size_t packet : {40, 80, 1500, 9000}) {
        const GvspBounds bounds{0x7f000001, 0x7f000001, 40000, buffer, packet};
        doors.push_back({bounds, gvsp_udp_filter(bounds), gvsp_packet_filter(bounds)});
      }
    }
    return doors;
  }();
  const Door& door = kDoors[bytes[0] / 2 % kDoors.size()];
  while (rest.size() >= 2) {
    const std::size_t length = std::min<std::size_t>(rest[0] + 256U * rest[1], rest.size() - 2);
    look_through_door(rest.subspan(2, length), door.bounds, door.udp, door.raw);
    rest = rest.subspan(2 + length);
  }
  return 0;
}
