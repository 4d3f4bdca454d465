// SPDX-License-Identifier: Apache-2.0
#pragma once

// What comes over the network as a GigE camera's images, before the library sees it. Aravis 0.8 believes what
// a packet says of itself: of one with a large number it takes memory for that many, and copies bytes beyond
// the end of a buffer. So the kernel is given a filter for the stream's socket that lets pass only packets of
// GigE Vision's streaming protocol (GVSP, GigE Vision 2.2, chapter 24) whose numbers fit into the buffers.

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

using GvspFilter = std::vector<sock_filter>;

/// For a UDP socket: packets of the camera's address that fit. The port's are those of the socket.
GvspFilter gvsp_udp_filter(const GvspBounds& bounds);

/// For a packet socket (AF_PACKET, SOCK_RAW), which sees all that comes: also only those to our address and
/// port, without IP options or fragments.
GvspFilter gvsp_packet_filter(const GvspBounds& bounds);

/// Gives the filters to the sockets of this process that receive the stream: those of its port. Returns how
/// many there are; 0 where none can be found. May be called again.
int guard_gvsp_sockets(const GvspBounds& bounds);

}  // namespace sslv
