// SPDX-License-Identifier: Apache-2.0
#include "image/image.h"

#include <array>

namespace sslv {
namespace {

struct Named {
  PixelFormat format;
  std::string_view name;
};
constexpr std::array kNames{
    Named{PixelFormat::kUyvy, "uyvy"},          Named{PixelFormat::kYuyv, "yuyv"},
    Named{PixelFormat::kRgb24, "rgb24"},        Named{PixelFormat::kBgr24, "bgr24"},
    Named{PixelFormat::kMono8, "mono8"},        Named{PixelFormat::kBayerRg8, "bayer_rg8"},
    Named{PixelFormat::kBayerGr8, "bayer_gr8"}, Named{PixelFormat::kBayerGb8, "bayer_gb8"},
    Named{PixelFormat::kBayerBg8, "bayer_bg8"},
};

}  // namespace

std::string_view name_of(PixelFormat format) {
  for (const Named& named : kNames) {
    if (named.format == format) return named.name;
  }
  return "unknown";
}

std::optional<PixelFormat> pixel_format_named(std::string_view name) {
  for (const Named& named : kNames) {
    if (named.name == name) return named.format;
  }
  return std::nullopt;
}

bool is_valid_size(PixelFormat format, int width, int height) {
  constexpr int kMaxSide = 16384;
  if (width < 2 || height < 2 || width > kMaxSide || height > kMaxSide) return false;
  if ((is_yuv422(format) || is_bayer(format)) && width % 2 != 0) return false;
  return !is_bayer(format) || height % 2 == 0;
}

}  // namespace sslv
