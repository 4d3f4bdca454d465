// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"
#include "base/params.h"
#include "capture/dc1394/dc1394_camera.h"

#include <array>
#include <cstddef>
#include <optional>
#include <string>

namespace sslv::iidc {

/// The choices of an option: "auto", which means nullopt, and the names of the table.
template <class T, std::size_t N>
constexpr auto auto_or(const std::array<Named<T>, N>& table) {
  std::array<Choice<std::optional<T>>, N + 1> choices{};
  choices[0] = {"auto", std::nullopt};
  for (std::size_t i = 0; i < N; ++i) choices[i + 1] = {table[i].name, table[i].value};
  return choices;
}

struct Options {
  std::string camera;
  std::optional<dc1394video_mode_t> mode;
  std::optional<dc1394color_coding_t> pixel_format;
  std::optional<dc1394color_filter_t> bayer_order;
  int width = 0, height = 0, offset_x = 0, offset_y = 0;
  int packet_size_bytes = 0;
  std::optional<double> frame_rate_hz;
  std::optional<dc1394speed_t> iso_speed;
  int ring_frames = 12;
  double silence_s = 2;
  bool reset_bus = false;
  Json controls = Json::object();

  static constexpr auto fields() {
    using O = Options;
    return std::tuple{
        text("camera", &O::camera, "the camera's GUID, 16 hexadecimal digits; empty: the first camera found"),
        choice("mode", &O::mode, auto_or(kModes),
               "auto: the first Format7 mode, else the mode with the largest image"),
        choice("pixel_format", &O::pixel_format, auto_or(kCodings), "auto: the best format of the mode"),
        choice("bayer_order", &O::bayer_order, auto_or(kBayerOrders),
               "order of the colours in raw images, also in those that the camera calls mono; auto: as the "
               "camera reports it"),
        number(
            "width", &O::width, 0, 16384, "px",
            "width of the part of the sensor that is read, Format7 only; 0: everything right of the offset"),
        number("height", &O::height, 0, 16384, "px",
               "height of the part of the sensor that is read, Format7 only; 0: everything below the offset"),
        number("offset_x", &O::offset_x, 0, 16384, "px", "left edge of that part"),
        number("offset_y", &O::offset_y, 0, 16384, "px", "upper edge of that part"),
        number("packet_size_bytes", &O::packet_size_bytes, 0, 65535, "bytes",
               "Format7 only: sets the share of the bus, and so the images per second; 0: as the camera "
               "recommends"),
        number("frame_rate_hz", &O::frame_rate_hz, 0.1, 1000.0, "Hz",
               "null: the fastest rate of the mode; with Format7, the rate that packet_size_bytes gives"),
        choice("iso_speed", &O::iso_speed, auto_or(kSpeeds),
               "Mbit/s; auto: 800 if the camera supports it, else 400. Cables and card must support it too"),
        number("ring_frames", &O::ring_frames, 3, 100, "",
               "number of image buffers that the card fills in advance"),
        number("silence_s", &O::silence_s, 0.1, 3600.0, "s",
               "a camera that sends nothing for this long, without waiting for a trigger, counts as lost"),
        flag("reset_bus", &O::reset_bus,
             "reset the bus when the camera is first opened: this frees what a crashed program has reserved, "
             "but disturbs all other cameras on the bus"),
        object("controls", &O::controls,
               "the camera's own settings, such as \"shutter\" or \"gain_mode\", set when it is opened"),
    };
  }
};

}  // namespace sslv::iidc
