// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/params.h"
#include "image/image.h"

#include <array>
#include <optional>

namespace sslv {

/// A backend's pixel_format option; nothing stands for "auto".
using PixelFormatOrAuto = std::optional<PixelFormat>;

inline constexpr std::array kPixelFormatChoices{
    Choice<PixelFormatOrAuto>{"auto", std::nullopt},
    Choice<PixelFormatOrAuto>{"uyvy", PixelFormat::kUyvy},
    Choice<PixelFormatOrAuto>{"yuyv", PixelFormat::kYuyv},
    Choice<PixelFormatOrAuto>{"rgb24", PixelFormat::kRgb24},
    Choice<PixelFormatOrAuto>{"bgr24", PixelFormat::kBgr24},
    Choice<PixelFormatOrAuto>{"mono8", PixelFormat::kMono8},
    Choice<PixelFormatOrAuto>{"bayer_rg8", PixelFormat::kBayerRg8},
    Choice<PixelFormatOrAuto>{"bayer_gr8", PixelFormat::kBayerGr8},
    Choice<PixelFormatOrAuto>{"bayer_gb8", PixelFormat::kBayerGb8},
    Choice<PixelFormatOrAuto>{"bayer_bg8", PixelFormat::kBayerBg8},
};

}  // namespace sslv
