// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "capture/v4l2/v4l2_device.h"

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <linux/videodev2.h>

namespace sslv {

/// Where video devices are found and how they are opened; a test has its own.
struct V4l2System {
  std::string class_folder = "/sys/class/video4linux", device_folder = "/dev";
  std::function<std::shared_ptr<V4l2Device>(const std::string& path)> open = open_v4l2_device;
};

/// A video device that delivers images. Its number (/dev/videoN) is what came first at the last start, so
/// it says nothing about which camera it is.
struct V4l2Node {
  std::string path;                // "/dev/video0"
  std::string model, driver;       // "HD Pro Webcam C920", "uvcvideo"
  std::string bus;                 // where it is plugged in: "usb-0000:00:14.0-2"
  std::string serial;              // of USB; empty: none
  std::vector<std::string> links;  // names in /dev/v4l/by-id and by-path
  std::shared_ptr<V4l2Device> device;
  v4l2_buf_type buffers = V4L2_BUF_TYPE_VIDEO_CAPTURE;  // or ..._MPLANE, as the device has it
};

/// All, opened, by their numbers. What cannot be opened is left out.
std::vector<V4l2Node> find_v4l2_nodes(const V4l2System& system);

/// The surest name that none of the others has: serial number, bus, link, path.
const std::string& known_by(const V4l2Node& node, const std::vector<V4l2Node>& all);

/// The one that `camera` names: a serial number, bus, name or path in /dev/v4l/by-id or by-path, or a path.
/// Empty: the first. Throws CaptureError, with what there is, for none and for more than one.
V4l2Node find_v4l2_node(const V4l2System& system, const std::string& camera);

}  // namespace sslv
