// SPDX-License-Identifier: Apache-2.0
#include "capture/aravis/aravis_formats.h"

#include "capture/unpack.h"

#include <algorithm>
#include <array>

namespace sslv {
namespace {

template <int kDepthBits>
void unpacked(const std::uint8_t* from, std::size_t pixels, std::uint8_t* to, std::uint8_t* low) noexcept {
  split_little_endian(from, pixels, kDepthBits, to, low);
}

// Numbers for formats that have no name in the library.
constexpr std::array kFormats{
    AravisFormat{ARV_PIXEL_FORMAT_YUV_422_PACKED, PixelFormat::kUyvy},
    AravisFormat{ARV_PIXEL_FORMAT_YUV_422_YUYV_PACKED, PixelFormat::kYuyv},
    AravisFormat{ARV_PIXEL_FORMAT_RGB_8_PACKED, PixelFormat::kRgb24},
    AravisFormat{0x02180015, PixelFormat::kBgr24},
    AravisFormat{ARV_PIXEL_FORMAT_MONO_8, PixelFormat::kMono8},
    AravisFormat{ARV_PIXEL_FORMAT_BAYER_RG_8, PixelFormat::kBayerRg8},
    AravisFormat{ARV_PIXEL_FORMAT_BAYER_GR_8, PixelFormat::kBayerGr8},
    AravisFormat{ARV_PIXEL_FORMAT_BAYER_GB_8, PixelFormat::kBayerGb8},
    AravisFormat{ARV_PIXEL_FORMAT_BAYER_BG_8, PixelFormat::kBayerBg8},

    AravisFormat{ARV_PIXEL_FORMAT_YUV_411_PACKED, PixelFormat::kUyvy, yuv411_to_uyvy},
    AravisFormat{ARV_PIXEL_FORMAT_YUV_444_PACKED, PixelFormat::kUyvy, yuv444_to_uyvy},

    AravisFormat{ARV_PIXEL_FORMAT_MONO_10, PixelFormat::kMono8, nullptr, unpacked<10>},
    AravisFormat{ARV_PIXEL_FORMAT_MONO_12, PixelFormat::kMono8, nullptr, unpacked<12>},
    AravisFormat{ARV_PIXEL_FORMAT_MONO_14, PixelFormat::kMono8, nullptr, unpacked<14>},
    AravisFormat{ARV_PIXEL_FORMAT_MONO_16, PixelFormat::kMono8, nullptr, unpacked<16>},
    AravisFormat{ARV_PIXEL_FORMAT_MONO_10_PACKED, PixelFormat::kMono8, nullptr, split_gige_packed_10},
    AravisFormat{ARV_PIXEL_FORMAT_MONO_12_PACKED, PixelFormat::kMono8, nullptr, split_gige_packed_12},
    AravisFormat{0x010a0046, PixelFormat::kMono8, nullptr, split_packed_10p},
    AravisFormat{0x010c0047, PixelFormat::kMono8, nullptr, split_packed_12p},

    AravisFormat{ARV_PIXEL_FORMAT_BAYER_RG_10, PixelFormat::kBayerRg8, nullptr, unpacked<10>},
    AravisFormat{ARV_PIXEL_FORMAT_BAYER_GR_10, PixelFormat::kBayerGr8, nullptr, unpacked<10>},
    AravisFormat{ARV_PIXEL_FORMAT_BAYER_GB_10, PixelFormat::kBayerGb8, nullptr, unpacked<10>},
    AravisFormat{ARV_PIXEL_FORMAT_BAYER_BG_10, PixelFormat::kBayerBg8, nullptr, unpacked<10>},
    AravisFormat{ARV_PIXEL_FORMAT_BAYER_RG_12, PixelFormat::kBayerRg8, nullptr, unpacked<12>},
    AravisFormat{ARV_PIXEL_FORMAT_BAYER_GR_12, PixelFormat::kBayerGr8, nullptr, unpacked<12>},
    AravisFormat{ARV_PIXEL_FORMAT_BAYER_GB_12, PixelFormat::kBayerGb8, nullptr, unpacked<12>},
    AravisFormat{ARV_PIXEL_FORMAT_BAYER_BG_12, PixelFormat::kBayerBg8, nullptr, unpacked<12>},
    AravisFormat{ARV_PIXEL_FORMAT_BAYER_RG_16, PixelFormat::kBayerRg8, nullptr, unpacked<16>},
    AravisFormat{ARV_PIXEL_FORMAT_BAYER_GR_16, PixelFormat::kBayerGr8, nullptr, unpacked<16>},
    AravisFormat{ARV_PIXEL_FORMAT_BAYER_GB_16, PixelFormat::kBayerGb8, nullptr, unpacked<16>},
    AravisFormat{ARV_PIXEL_FORMAT_BAYER_BG_16, PixelFormat::kBayerBg8, nullptr, unpacked<16>},
    AravisFormat{ARV_PIXEL_FORMAT_BAYER_RG_10P, PixelFormat::kBayerRg8, nullptr, split_packed_10p},
    AravisFormat{ARV_PIXEL_FORMAT_BAYER_GR_10P, PixelFormat::kBayerGr8, nullptr, split_packed_10p},
    AravisFormat{ARV_PIXEL_FORMAT_BAYER_GB_10P, PixelFormat::kBayerGb8, nullptr, split_packed_10p},
    AravisFormat{ARV_PIXEL_FORMAT_BAYER_BG_10P, PixelFormat::kBayerBg8, nullptr, split_packed_10p},
    AravisFormat{ARV_PIXEL_FORMAT_BAYER_RG_12P, PixelFormat::kBayerRg8, nullptr, split_packed_12p},
    AravisFormat{ARV_PIXEL_FORMAT_BAYER_GR_12P, PixelFormat::kBayerGr8, nullptr, split_packed_12p},
    AravisFormat{ARV_PIXEL_FORMAT_BAYER_GB_12P, PixelFormat::kBayerGb8, nullptr, split_packed_12p},
    AravisFormat{ARV_PIXEL_FORMAT_BAYER_BG_12P, PixelFormat::kBayerBg8, nullptr, split_packed_12p},
    AravisFormat{ARV_PIXEL_FORMAT_BAYER_RG_10_PACKED, PixelFormat::kBayerRg8, nullptr, split_gige_packed_10},
    AravisFormat{ARV_PIXEL_FORMAT_BAYER_GR_10_PACKED, PixelFormat::kBayerGr8, nullptr, split_gige_packed_10},
    AravisFormat{ARV_PIXEL_FORMAT_BAYER_GB_10_PACKED, PixelFormat::kBayerGb8, nullptr, split_gige_packed_10},
    AravisFormat{ARV_PIXEL_FORMAT_BAYER_BG_10_PACKED, PixelFormat::kBayerBg8, nullptr, split_gige_packed_10},
    AravisFormat{ARV_PIXEL_FORMAT_BAYER_RG_12_PACKED, PixelFormat::kBayerRg8, nullptr, split_gige_packed_12},
    AravisFormat{ARV_PIXEL_FORMAT_BAYER_GR_12_PACKED, PixelFormat::kBayerGr8, nullptr, split_gige_packed_12},
    AravisFormat{ARV_PIXEL_FORMAT_BAYER_GB_12_PACKED, PixelFormat::kBayerGb8, nullptr, split_gige_packed_12},
    AravisFormat{ARV_PIXEL_FORMAT_BAYER_BG_12_PACKED, PixelFormat::kBayerBg8, nullptr, split_gige_packed_12},
};

}  // namespace

const AravisFormat* find_aravis_format(ArvPixelFormat arv) {
  const auto* found =
      std::find_if(kFormats.begin(), kFormats.end(), [=](const AravisFormat& one) { return one.arv == arv; });
  return found == kFormats.end() ? nullptr : found;
}

ArvPixelFormat arv_format_of(PixelFormat format) {
  return std::find_if(kFormats.begin(), kFormats.end(),
                      [=](const AravisFormat& one) { return one.format == format && !one.is_copied(); })
      ->arv;
}

}  // namespace sslv
