// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "image/image.h"

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

namespace sslv {

/// A GigE Vision camera based on Aravis' own simulation, serving our images over the real protocol. Only one
/// per machine and address, as the protocol's port is fixed. In addition to the library's features it has
/// ExposureAuto, PtpEnable and ChunkModeActive, which do not affect its images.
class GigeServer {
 public:
  /// Writes one image, rows without gaps, in the size and format that the client has set. Called in a thread
  /// of the library.
  using Fill = std::function<void(std::uint8_t* pixels, int width, int height, PixelFormat format)>;

  /// Waits for the port to become free; throws std::runtime_error with the port's number on timeout.
  GigeServer(const std::string& interface_address, const std::string& serial, Fill fill);
  /// Vanishes without notifying its client, like a camera that loses power.
  ~GigeServer();
  GigeServer(const GigeServer&) = delete;
  GigeServer& operator=(const GigeServer&) = delete;

  /// Defaults for clients that set nothing. Mono, RGB and Bayer formats; throws std::runtime_error for
  /// others.
  void set_defaults(int width, int height, PixelFormat format, double frame_rate_hz);
  /// From now on sends images in another format, given by its number in GenICam's Pixel Format Naming
  /// Convention: `pack` converts `count` pixels of one byte each.
  using Pack = std::function<void(const std::uint8_t* pixels, std::size_t count, std::uint8_t* packed)>;
  void send_packed(std::uint32_t format, Pack pack);
  /// Time after its client's last request until another client may take control.
  void set_heartbeat(double heartbeat_s);
  /// Like a value chosen by an automatic exposure.
  void set_exposure(int exposure_us);
  /// Fraction of packets that are lost from now on, 0..1.
  void lose_packets(double ratio);

 private:
  struct Library;
  std::unique_ptr<Library> library_;
};

}  // namespace sslv
