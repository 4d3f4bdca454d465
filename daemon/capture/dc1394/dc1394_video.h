// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "capture/dc1394/dc1394_options.h"
#include "image/image.h"

#include <string>

namespace sslv::iidc {

/// Of the bus: one packet of an image is sent in each.
inline constexpr double kCycleSeconds = 125e-6;

/// How images will come.
struct Video {
  dc1394color_coding_t coding = DC1394_COLOR_CODING_YUV422;
  ImageView layout;       // as the pipeline gets them; no data
  double interval_s = 0;  // from one to the next, as far as the camera says; 0: not known
  std::string summary;    // "640x480_yuv422 at 30 Hz, iso_speed 400"
};

/// Sets mode, part of the sensor, rate and speed; stops what was still being sent. Throws CaptureError that
/// names camera, option, value and what is allowed.
Video set_up_video(dc1394camera_t* camera, const Options& options, const std::string& label);

/// Whether images of this coding must be converted for the pipeline.
bool needs_unpacking(dc1394color_coding_t coding);
/// Converts one of those; `to` has room for the layout.
void unpack(const dc1394video_frame_t& frame, const ImageView& layout, std::uint8_t* to) noexcept;

}  // namespace sslv::iidc
