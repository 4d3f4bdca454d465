// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "capture/v4l2/v4l2_device.h"

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <linux/videodev2.h>

namespace sslv {

/// The folders in which video devices are found and the function that opens them; tests replace both.
struct V4l2System {
  std::string class_folder = "/sys/class/video4linux", device_folder = "/dev";
  std::function<std::shared_ptr<V4l2Device>(const std::string& path)> open = open_v4l2_device;
};

/// A video device that delivers images. Its number (/dev/videoN) depends on the order of detection at the
/// last start, so it does not identify the camera.
struct V4l2Node {
  std::string path;                // "/dev/video0"
  std::string model, driver;       // "HD Pro Webcam C920", "uvcvideo"
  std::string bus;                 // bus and port: "usb-0000:00:14.0-2"
  std::string serial;              // USB serial number; empty if none
  std::vector<std::string> links;  // names in /dev/v4l/by-id and by-path
  std::shared_ptr<V4l2Device> device;
  v4l2_buf_type buffers = V4L2_BUF_TYPE_VIDEO_CAPTURE;  // or ..._MPLANE, depending on the device
};

/// All video devices that deliver images and can be opened, in the order of their numbers.
std::vector<V4l2Node> find_v4l2_nodes(const V4l2System& system);

/// The most reliable unique name: serial number, bus, link or path.
const std::string& known_by(const V4l2Node& node, const std::vector<V4l2Node>& all);

/// Finds the device that `camera` names: a serial number, bus, name or path in /dev/v4l/by-id or by-path, or
/// a path. An empty text means the first device. Throws CaptureError, listing the existing devices, if none
/// or more than one matches.
V4l2Node find_v4l2_node(const V4l2System& system, const std::string& camera);

}  // namespace sslv
