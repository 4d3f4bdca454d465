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

/// An image as the camera gave it.
struct CapturedImage {
  Image image;           // borrows the driver's buffer
  CaptureTimes times{};  // arrived_ns is the camera thread's work
  WholePicture whole{};
  bool is_damaged = false;  // parts of it are missing, and it is wanted all the same
  std::string name{};       // file stem of a recorded frame; empty (no allocation) for live ones
};

/// What became of one attempt to get an image.
enum class CaptureStatus {
  kImage,       // `image` is filled
  kTimeout,     // nothing came; try again
  kIncomplete,  // an image came damaged (lost packets, unreadable file): counted and skipped
  kEnd,         // a recording has ended
  kLost,        // the camera is gone: close it and reopen it
};

/// Packets of a camera that sends over a network, since the opening.
struct PacketCounts {
  std::uint64_t missing = 0;  // never came; Aravis counts all of an image from the first gap on
  std::uint64_t resent = 0;   // came when they were asked for again
};

/// An open camera. One thread uses it. Opening is the constructor's work and reports failure by throwing
/// CaptureError; closing is the destructor's and may block on dead hardware, so keep it off critical threads.
class Source {
 public:
  virtual ~Source() = default;

  /// Waits up to `timeout` for the next image. Never throws; says why in `problem` for kIncomplete and
  /// kLost.
  virtual CaptureStatus next(CapturedImage& image, std::string& problem,
                             std::chrono::milliseconds timeout) = 0;

  /// Images since the opening that were never handed over, because nobody took them in time.
  virtual std::uint64_t dropped() const noexcept { return 0; }

  /// None: it does not send over a network.
  virtual std::optional<PacketCounts> packets() const noexcept { return std::nullopt; }

  /// What can be set on the camera itself; none: nothing.
  virtual std::shared_ptr<Controls> controls() { return nullptr; }

  /// What the admin should know of the opening, a line for each: settings that the camera refused.
  virtual std::vector<std::string> warnings() const { return {}; }
};

/// A camera that cannot be opened; one line for the admin.
struct CaptureError : std::runtime_error {
  using runtime_error::runtime_error;
};

/// What a backend may need to know of the rest.
struct SourceContext {
  std::uint32_t camera_id = 0;
  Scene scene;  // the simulator draws it; real cameras do not look at it
};

/// A camera that could be opened.
struct FoundCamera {
  std::string name;               // with model and serial, for people
  Json source;                    // settings lines to paste
  std::string model{}, serial{};  // empty: not known
  std::vector<std::string>
      formats{};  // of pixels that it offers and we take; empty: not known before it is opened
  std::vector<std::string> other_names{};  // by which settings may call it too
};

/// A row of the table of capture backends. `options` are the keys beside "backend" in a camera's "source".
struct Backend {
  std::string_view name, help;
  /// Options with defaults filled in; throws SettingsError, beginning with `path`.
  Json (*complete)(const Json& options, const std::string& path);
  Json (*schema)();
  /// Opens the camera; throws CaptureError. `options` have passed `complete`.
  std::unique_ptr<Source> (*open)(const Json& options, const SourceContext& context);
  std::vector<FoundCamera> (*list)();  // cameras found now
};

}  // namespace sslv
