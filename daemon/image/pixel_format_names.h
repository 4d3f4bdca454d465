// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "image/image.h"

#include <array>
#include <string_view>

namespace sslv {

struct NamedPixelFormat {
  std::string_view name;
  PixelFormat format;
};

/// Every format by the name that settings and command lines use.
inline constexpr std::array<NamedPixelFormat, 9> kPixelFormatNames{{
    {"uyvy", PixelFormat::kUyvy},
    {"yuyv", PixelFormat::kYuyv},
    {"rgb24", PixelFormat::kRgb24},
    {"bgr24", PixelFormat::kBgr24},
    {"mono8", PixelFormat::kMono8},
    {"bayer_rg8", PixelFormat::kBayerRg8},
    {"bayer_gr8", PixelFormat::kBayerGr8},
    {"bayer_gb8", PixelFormat::kBayerGb8},
    {"bayer_bg8", PixelFormat::kBayerBg8},
}};

}  // namespace sslv
