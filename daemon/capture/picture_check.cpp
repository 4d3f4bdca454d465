// SPDX-License-Identifier: Apache-2.0
#include "capture/picture_check.h"

#include <cmath>

#include <fmt/format.h>

namespace sslv {
namespace {

constexpr double kOldestS = 10;      // no driver holds an image this long
constexpr double kEarliestS = -0.1;  // clocks synchronised to the same master differ less

}  // namespace

std::string find_fault(const ImageView& picture) {
  if (picture.empty()) return "the driver delivered no bytes";
  if (picture.format > PixelFormat::kBayerBg8)
    return fmt::format("pixel format {} does not exist", static_cast<int>(picture.format));
  if (!is_valid_size(picture.format, picture.width, picture.height)) {
    return fmt::format("{}x{} is not a valid size of a {} image", picture.width, picture.height,
                       name_of(picture.format));
  }
  if (picture.stride_bytes < std::ptrdiff_t{picture.width} * bytes_per_pixel(picture.format)) {
    return fmt::format("rows of {} bytes are too short for {} {} pixels", picture.stride_bytes, picture.width,
                       name_of(picture.format));
  }
  return {};
}

bool sanitize_times(CaptureTimes& times, double now_s) {
  if (times.t_capture_camera_s && !std::isfinite(*times.t_capture_camera_s)) times.t_capture_camera_s.reset();
  if (times.t_capture_sigma_s && !std::isfinite(*times.t_capture_sigma_s)) times.t_capture_sigma_s.reset();
  const double age_s = now_s - times.t_capture_s;
  if (age_s >= kEarliestS && age_s <= kOldestS) return false;  // the condition is false for NaN
  times.t_capture_s = now_s;
  times.t_capture_sigma_s.reset();
  times.is_by_ptp = false;
  return true;
}

}  // namespace sslv
