// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "capture/controls.h"
#include "capture/dc1394/dc1394_camera.h"

#include <atomic>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

namespace sslv::iidc {

/// What an open camera's source and its controls share.
struct Link {
  std::mutex mutex;                   // one reads or writes registers at a time
  dc1394camera_t* camera = nullptr;   // guarded; null once the source is closed
  std::string label;                  // as the admin calls it; constant
  std::atomic<double> exposure_s{0};  // that all images have; 0: not known
};

/// Every feature of IIDC that the camera has: "shutter" (its value), "shutter_absolute" (in seconds),
/// "shutter_mode", "shutter_on", and so on.
std::shared_ptr<Controls> make_controls(std::shared_ptr<Link> link);

/// The exposure that all images have: a manual shutter whose time the camera tells. A bus transaction.
std::optional<double> exposure_s_of(dc1394camera_t* camera);
/// Whether the camera takes images only when it is told to.
bool waits_for_trigger(dc1394camera_t* camera);

}  // namespace sslv::iidc
