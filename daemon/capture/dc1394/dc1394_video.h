// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "capture/dc1394/dc1394_options.h"
#include "image/image.h"

#include <string>

namespace sslv::iidc {

/// Duration of a bus cycle, which carries one packet of an image.
inline constexpr double kCycleSeconds = 125e-6;

/// The configured video stream.
struct Video {
  dc1394color_coding_t coding = DC1394_COLOR_CODING_YUV422;
  ImageView layout;       // layout of the images delivered to the pipeline; without data
  double interval_s = 0;  // time between images; 0: unknown
  std::string summary;    // "640x480_yuv422 at 30 Hz, iso_speed 400"
};

/// Sets mode, region, rate and speed; stops a transmission that is still running. Throws CaptureError naming
/// camera, option, value and the allowed values.
Video set_up_video(dc1394camera_t* camera, const Options& options, const std::string& label);

/// Whether images of this coding need conversion for the pipeline.
bool needs_unpacking(dc1394color_coding_t coding);
/// Converts an image of a coding that needs unpacking; `to` has space for the layout.
void unpack(const dc1394video_frame_t& frame, const ImageView& layout, std::uint8_t* to) noexcept;

}  // namespace sslv::iidc
