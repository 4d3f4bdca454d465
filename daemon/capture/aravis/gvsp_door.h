// SPDX-License-Identifier: Apache-2.0
#pragma once

// Validates a GigE camera's packets before the library sees them. Aravis 0.8 trusts the numbers in packets:
// it allocates memory for any number of packets that a packet announces, and copies bytes beyond the end of a
// buffer. Therefore the functions below attach a kernel filter (BPF) to the stream's sockets. The filter
// passes only packets of GigE Vision's streaming protocol (GVSP) whose numbers fit the buffers.

#include <cstddef>
#include <cstdint>
#include <vector>

#include <linux/filter.h>

namespace sslv {

/// Bounds of a camera's stream.
struct GvspBounds {
  std::uint32_t camera = 0, own = 0;  // IPv4 addresses in host byte order: 127.0.0.1 is 0x7f000001
  std::uint16_t port = 0;             // our UDP port
  std::size_t buffer_bytes = 0;       // size of the buffer of an image
  std::size_t packet_bytes = 0;       // maximum size of an IP packet, as configured in the camera
};

/// Maximum bytes of headers in a packet: IP and UDP, extended GVSP header, and multipart header. The filter
/// drops all packets of a header type that leaves no space for data.
inline constexpr std::size_t kGvspHeaderBytes = 28 + 20 + 8;

using GvspFilter = std::vector<sock_filter>;

/// For a UDP socket: passes packets from the camera's address that are within `bounds`.
GvspFilter gvsp_udp_filter(const GvspBounds& bounds);

/// For a packet socket (AF_PACKET, SOCK_RAW), which receives all packets of the computer: also requires our
/// address and port, and rejects packets with IP options and fragments.
GvspFilter gvsp_packet_filter(const GvspBounds& bounds);

/// Whether this process may open packet sockets (CAP_NET_RAW). If so, the library receives through a packet
/// socket, and still has its UDP socket open.
bool may_open_packet_sockets();

/// Attaches the filters to the sockets of this process that receive the stream; finds them by the stream's
/// port. Returns the number of guarded sockets; 0: none found. May be called repeatedly.
int guard_gvsp_sockets(const GvspBounds& bounds);

}  // namespace sslv
