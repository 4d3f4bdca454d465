// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"
#include "capture/controls.h"
#include "geometry/scene.h"
#include "image/frame_info.h"
#include "image/image.h"

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace sslv {

/// An image as delivered by the camera.
struct CapturedImage {
  Image image;           // borrows the driver's buffer
  CaptureTimes times{};  // arrived_ns is set by the camera thread
  WholePicture whole{};
  bool is_damaged = false;  // parts are missing, but the image is used anyway
  std::string name{};       // file stem of a recorded frame; empty (no allocation) for live frames
};

/// The result of one attempt to get an image.
enum class CaptureStatus {
  kImage,       // `image` is filled
  kTimeout,     // no image yet; try again
  kIncomplete,  // a damaged image (lost packets, unreadable file): counted and skipped
  kEnd,         // end of a recording
  kLost,        // the camera is lost: close and reopen it
};

/// Packets of a network camera since the opening.
struct PacketCounts {
  std::uint64_t missing = 0;  // never arrived; Aravis counts all packets of an image from its first gap
  std::uint64_t resent = 0;   // arrived after a resend request
};

/// An open camera, used by one thread. The constructor opens it and throws CaptureError on failure. The
/// destructor closes it and may block on dead hardware: keep it off critical threads.
class Source {
 public:
  virtual ~Source() = default;

  /// Waits up to `timeout` for the next image. Never throws; sets `problem` to the reason for kIncomplete and
  /// kLost.
  virtual CaptureStatus next(CapturedImage& image, std::string& problem,
                             std::chrono::milliseconds timeout) = 0;

  /// Number of images since the opening that were never delivered, because they were not taken in time.
  virtual std::uint64_t dropped() const noexcept { return 0; }

  /// Empty for a camera that does not use a network.
  virtual std::optional<PacketCounts> packets() const noexcept { return std::nullopt; }

  /// The camera's own controls; null if the camera has no controls.
  virtual std::shared_ptr<Controls> controls() { return nullptr; }

  /// Problems of the opening for the admin, one line each: settings that the camera refused.
  virtual std::vector<std::string> warnings() const { return {}; }
};

/// A camera that cannot be opened. The text is one line for the admin.
struct CaptureError : std::runtime_error {
  using runtime_error::runtime_error;
};

/// Information that a backend may need about its camera.
struct SourceContext {
  std::uint32_t camera_id = 0;
  Scene scene;  // drawn by the simulator; real cameras ignore it
};

/// A camera that could be opened.
struct FoundCamera {
  std::string name;               // for display, with model and serial
  Json source;                    // JSON for the settings' "source"
  std::string model{}, serial{};  // empty if unknown
  std::vector<std::string>
      formats{};  // supported pixel formats that we can use; empty if unknown until opened
  std::vector<std::string> other_names{};  // other names that settings may use
};

/// One capture backend. `options` are the keys beside "backend" in a camera's "source".
struct Backend {
  std::string_view name, help;
  /// Returns the options with defaults filled in. Throws SettingsError, beginning with `path`.
  Json (*complete)(const Json& options, const std::string& path);
  Json (*schema)();
  /// Opens the camera; throws CaptureError. `options` must be a result of `complete`.
  std::unique_ptr<Source> (*open)(const Json& options, const SourceContext& context);
  std::vector<FoundCamera> (*list)();  // the cameras found now
};

}  // namespace sslv
