// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/params_json.h"
#include "capture/pixel_format_choice.h"

#include <optional>
#include <string>

namespace sslv {

/// A camera's settings besides "backend".
struct AravisOptions {
  std::string camera;
  PixelFormatOrAuto pixel_format;
  int width = 0, height = 0, offset_x = 0, offset_y = 0;
  std::optional<double> frame_rate_hz, exposure_us, gain;
  int buffers = 8;
  int packet_size = 0;
  int socket_buffer_bytes = 4 << 20;
  double silence_s = 2;
  bool resend = true, use_incomplete = false, chunks = false;
  Json controls = Json::object();
  static constexpr auto fields() {
    using O = AravisOptions;
    return std::tuple{
        text("camera", &O::camera,
             "the camera's serial number, IP address or Aravis id; empty: the first camera found"),
        choice("pixel_format", &O::pixel_format, kPixelFormatOrAutoChoices,
               "auto: the camera's current format; deeper and packed formats are selected with PixelFormat "
               "in controls, and read as their upper 8 bits"),
        number("width", &O::width, 0, 16384, "px",
               "width of the part of the sensor that is read; 0: leave as it is"),
        number("height", &O::height, 0, 16384, "px",
               "height of the part of the sensor that is read; 0: leave as it is"),
        number("offset_x", &O::offset_x, 0, 16384, "px", "left edge of that part, if width or height is set"),
        number("offset_y", &O::offset_y, 0, 16384, "px",
               "upper edge of that part, if width or height is set"),
        number("frame_rate_hz", &O::frame_rate_hz, 0.01, 10000.0, "Hz",
               "switches triggers off; null: leave as it is"),
        number("exposure_us", &O::exposure_us, 1.0, 1e7, "us",
               "switches automatic exposure off; null: leave as it is"),
        number("gain", &O::gain, -100.0, 10000.0, "",
               "in the camera's unit; switches automatic gain off; null: leave as it is"),
        number("buffers", &O::buffers, 3, 200, "", "number of buffers for images in transit"),
        number("packet_size", &O::packet_size, 0, 65535, "bytes",
               "GigE Vision; 0: the largest that the network passes"),
        number("socket_buffer_bytes", &O::socket_buffer_bytes, 65536, 1 << 30, "bytes",
               "GigE Vision: the system's receive buffer for images"),
        number("silence_s", &O::silence_s, 0.1, 3600.0, "s",
               "a camera that sends nothing for this long counts as lost"),
        flag("resend", &O::resend, "GigE Vision: request missing packets again"),
        flag("use_incomplete", &O::use_incomplete,
             "process images with missing packets too: the missing parts show an older image"),
        flag("chunks", &O::chunks,
             "let the camera send exposure time and capture time with each image (GenICam chunk data)"),
        object("controls", &O::controls,
               "settings of the camera itself, with the camera's own names (GenICam), such as {\"GainAuto\": "
               "\"Off\", \"Gain\": 6}; changed while it runs"),
    };
  }
};

}  // namespace sslv
