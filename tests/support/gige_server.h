// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "image/image.h"

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

namespace sslv {

/// A GigE Vision camera made of Aravis' own simulation, serving our pictures over the real protocol. One a
/// machine and address: the protocol's port is fixed. Beside the library's, it has the features ExposureAuto,
/// PtpEnable and ChunkModeActive, which change nothing in its pictures.
class GigeServer {
 public:
  /// Writes one picture, rows without gaps, as large and in the format that the client has set. Called in a
  /// thread of the library.
  using Fill = std::function<void(std::uint8_t* pixels, int width, int height, PixelFormat format)>;

  /// Waits for the port to become free; throws std::runtime_error naming it when it does not.
  GigeServer(const std::string& interface_address, const std::string& serial, Fill fill);
  /// Vanishes without a word to its client, as a camera that loses power does.
  ~GigeServer();
  GigeServer(const GigeServer&) = delete;
  GigeServer& operator=(const GigeServer&) = delete;

  /// What a client finds that sets nothing. Mono, RGB and Bayer formats; throws std::runtime_error for
  /// others.
  void set_defaults(int width, int height, PixelFormat format, double frame_rate_hz);
  /// From now on sends its pictures in another format, by its number in GenICam's Pixel Format Naming
  /// Convention: what `pack` makes of `count` pixels of one byte each.
  using Pack = std::function<void(const std::uint8_t* pixels, std::size_t count, std::uint8_t* packed)>;
  void send_packed(std::uint32_t format, Pack pack);
  /// So long after its client's last request it is another client's.
  void set_heartbeat(double heartbeat_s);
  /// As if an automatic exposure had chosen it.
  void set_exposure(int exposure_us);
  /// Share of packets that get lost from now on, 0..1.
  void lose_packets(double ratio);

 private:
  struct Library;
  std::unique_ptr<Library> library_;
};

}  // namespace sslv
