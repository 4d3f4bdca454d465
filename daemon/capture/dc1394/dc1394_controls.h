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

/// State shared by an open camera's source and its controls.
struct Link {
  std::mutex mutex;                   // serialises access to registers
  dc1394camera_t* camera = nullptr;   // guarded by mutex; null once the source is closed
  std::string label;                  // the admin's name; constant
  std::atomic<double> exposure_s{0};  // exposure of all images; 0: unknown
};

/// Controls for every IIDC feature of the camera: "shutter" (its raw value), "shutter_absolute" (in seconds),
/// "shutter_mode", "shutter_on", and so on.
std::shared_ptr<Controls> make_controls(std::shared_ptr<Link> link);

/// The exposure time of all images in seconds. Empty unless the shutter is manual and the camera reports its
/// time. Makes bus transactions.
std::optional<double> exposure_s_of(dc1394camera_t* camera);
/// Whether the camera takes images only when triggered.
bool waits_for_trigger(dc1394camera_t* camera);

}  // namespace sslv::iidc
