// SPDX-License-Identifier: Apache-2.0
#pragma once

// Validates a GigE camera's packets before the library sees them. Aravis 0.8 believes their numbers: it
// allocates memory for as many packets as one says there are, and copies bytes beyond the end of a buffer. So
// the kernel gets a filter for the stream's socket that passes only packets of GigE Vision's streaming
// protocol (GVSP) whose numbers fit into the buffers.

#include <cstddef>
#include <cstdint>
#include <vector>

#include <linux/filter.h>

namespace sslv {

/// Of a camera's stream.
struct GvspBounds {
  std::uint32_t camera = 0, own = 0;  // IPv4 addresses, as numbers: 127.0.0.1 is 0x7f000001
  std::uint16_t port = 0;             // UDP, of ours
  std::size_t buffer_bytes = 0;       // of each image
  std::size_t packet_bytes = 0;       // of IP, as the camera is told
};

/// Of a packet, the most that headers take: of IP and UDP, extended, and before a piece of a part. The door
/// is shut to kinds of packets that have no more.
inline constexpr std::size_t kGvspHeaderBytes = 28 + 20 + 8;

using GvspFilter = std::vector<sock_filter>;

/// For a UDP socket: packets from the camera's address that fit.
GvspFilter gvsp_udp_filter(const GvspBounds& bounds);

/// For a packet socket (AF_PACKET, SOCK_RAW), which sees everything: also only packets to our address and
/// port, without IP options or fragments.
GvspFilter gvsp_packet_filter(const GvspBounds& bounds);

/// Whether this process has the right to (CAP_NET_RAW): then the library receives by such a socket and also
/// keeps its UDP socket.
bool may_open_packet_sockets();

/// Attaches the filters to the sockets of this process that receive the stream, found by its port. Returns
/// how many there are; 0: none was found. May be called again.
int guard_gvsp_sockets(const GvspBounds& bounds);

}  // namespace sslv
