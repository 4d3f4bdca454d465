// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/params.h"
#include "capture/v4l2/v4l2_device.h"
#include "image/image.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <linux/videodev2.h>

namespace sslv {

/// A supported pixel format of video devices.
struct V4l2Format {
  std::string_view name;              // name in settings
  std::uint32_t fourcc;               // the kernel's code
  std::optional<PixelFormat> pixels;  // empty: must be converted first
};

/// Best first: colour before grey, directly usable before compressed.
inline constexpr std::array<V4l2Format, 11> kV4l2Formats{{
    {"uyvy", V4L2_PIX_FMT_UYVY, PixelFormat::kUyvy},
    {"yuyv", V4L2_PIX_FMT_YUYV, PixelFormat::kYuyv},
    {"bayer_rg8", V4L2_PIX_FMT_SRGGB8, PixelFormat::kBayerRg8},
    {"bayer_gr8", V4L2_PIX_FMT_SGRBG8, PixelFormat::kBayerGr8},
    {"bayer_gb8", V4L2_PIX_FMT_SGBRG8, PixelFormat::kBayerGb8},
    {"bayer_bg8", V4L2_PIX_FMT_SBGGR8, PixelFormat::kBayerBg8},
    {"rgb24", V4L2_PIX_FMT_RGB24, PixelFormat::kRgb24},
    {"bgr24", V4L2_PIX_FMT_BGR24, PixelFormat::kBgr24},
    {"nv12", V4L2_PIX_FMT_NV12, std::nullopt},
    {"mjpeg", V4L2_PIX_FMT_MJPEG, std::nullopt},
    {"mono8", V4L2_PIX_FMT_GREY, PixelFormat::kMono8},
}};

/// Values of the pixel_format option.
inline constexpr std::uint32_t kV4l2AutoFormat = 0;
inline constexpr auto kV4l2FormatChoices = [] {
  std::array<Choice<std::uint32_t>, kV4l2Formats.size() + 1> choices{};
  choices[0] = {"auto", kV4l2AutoFormat};
  for (std::size_t i = 0; i < kV4l2Formats.size(); ++i)
    choices[i + 1] = {kV4l2Formats[i].name, kV4l2Formats[i].fourcc};
  return choices;
}();

struct V4l2FormatWish {
  std::uint32_t fourcc = kV4l2AutoFormat;
  int width = 0, height = 0;  // 0: keep the current size
  std::optional<double> frame_rate_hz;
};

/// The format that the device was set to.
struct V4l2FormatSet {
  V4l2Format format{};
  int width = 0, height = 0;
  std::ptrdiff_t stride_bytes = 0;
  double period_s = 0;  // time between images; 0: unknown
};

/// The supported formats of the device, best first. `buffers` is its buffer type, as in V4l2Node.
std::vector<V4l2Format> v4l2_formats_of(V4l2Device& device, v4l2_buf_type buffers);

/// Sets the format and rate. If the device refuses, throws CaptureError, beginning with `label`, that lists
/// what the device supports. "auto" chooses the best format that is fast enough, or the fastest format if
/// `wish` has no rate.
V4l2FormatSet set_v4l2_format(V4l2Device& device, v4l2_buf_type buffers, const V4l2FormatWish& wish,
                              const std::string& label);

}  // namespace sslv
