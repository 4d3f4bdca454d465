// SPDX-License-Identifier: Apache-2.0
#include "capture/aravis/aravis_setup.h"

#include "base/log.h"
#include "capture/aravis/aravis_formats.h"
#include "capture/aravis/gvsp_door.h"
#include "capture/source.h"

#include <fstream>
#include <utility>

#include <fmt/format.h>

namespace sslv {
namespace {

/// Sets features of an open camera; a refusal throws CaptureError naming camera, option and value.
class Setup {
 public:
  Setup(ArvCamera* camera, std::string label) : camera_(camera), label_(std::move(label)) {}

  void integer(const char* key, const char* feature, int value) const {
    Failure failure;
    if (!arv_camera_is_feature_available(camera_, feature, failure) || failure.failed())
      missing(key, feature);
    gint64 min = 0, max = 0;
    arv_camera_get_integer_bounds(camera_, feature, &min, &max, nullptr);
    if (min <= max && (value < min || value > max)) out_of_range(key, value, min, max);
    arv_camera_set_integer(camera_, feature, value, failure);
    check(failure, key, value);
    const gint64 now = arv_camera_get_integer(camera_, feature, failure);
    check(failure, key, value);
    if (now != value) refuse(key, value, fmt::format("the camera set {} instead", now));
  }

  using IsAvailable = gboolean (*)(ArvCamera*, GError**);
  using GetBounds = void (*)(ArvCamera*, double*, double*, GError**);
  using Set = void (*)(ArvCamera*, double, GError**);
  void real(const char* key, double value, IsAvailable is_available, GetBounds get_bounds, Set set) const {
    Failure failure;
    if (!is_available(camera_, failure) || failure.failed()) missing(key, key);
    double min = 0, max = 0;
    get_bounds(camera_, &min, &max, nullptr);
    if (min < max && (value < min || value > max)) out_of_range(key, value, min, max);
    set(camera_, value, failure);
    check(failure, key, value);
  }

  void region(const AravisOptions& options) const {
    if (options.width == 0 && options.height == 0) return;
    // The permitted size depends on the offset, so set the offset to 0 first.
    Failure failure;
    const bool has_offset = arv_camera_is_region_offset_available(camera_, failure);
    failure.require_answer(label_);
    if (has_offset) {
      integer("offset_x", "OffsetX", 0);
      integer("offset_y", "OffsetY", 0);
    }
    if (options.width > 0) integer("width", "Width", options.width);
    if (options.height > 0) integer("height", "Height", options.height);
    if (options.offset_x > 0) integer("offset_x", "OffsetX", options.offset_x);
    if (options.offset_y > 0) integer("offset_y", "OffsetY", options.offset_y);
  }

  void pixel_format(const PixelFormatOrAuto& wanted) const {
    Failure failure;
    if (wanted) {
      arv_camera_set_pixel_format(camera_, arv_format_of(*wanted), failure);
      if (failure.failed()) refuse("pixel_format", name_of(*wanted), "the camera has " + formats());
    }
    const ArvPixelFormat now = arv_camera_get_pixel_format(camera_, failure);
    check(failure, "pixel_format", "auto");
    const AravisFormat* ours = find_aravis_format(now);
    if (ours == nullptr)
      refuse("pixel_format", "auto", fmt::format("the camera is set to 0x{:08x}; it has {}", now, formats()));
    if (wanted && now != arv_format_of(*wanted)) {
      refuse("pixel_format", name_of(*wanted), fmt::format("the camera set 0x{:08x} instead", now));
    }
  }

  template <class V>
  void check(const Failure& failure, std::string_view key, const V& value) const {
    if (failure.failed()) refuse(key, value, failure.text());
  }

 private:
  template <class V>
  [[noreturn]] void refuse(std::string_view key, const V& value, std::string_view why) const {
    throw CaptureError(fmt::format("camera \"{}\": {} {} refused: {}", label_, key, value, why));
  }
  template <class V, class Limit>
  [[noreturn]] void out_of_range(const char* key, V value, Limit min, Limit max) const {
    refuse(key, value, fmt::format("the camera allows {} .. {}", min, max));
  }
  [[noreturn]] void missing(const char* key, const char* feature) const {
    throw CaptureError(
        fmt::format("camera \"{}\": {} cannot be set: the camera has no {}", label_, key, feature));
  }

  /// The camera's pixel formats that the option can select.
  std::string formats() const {
    guint count = 0;
    const std::unique_ptr<gint64, void (*)(void*)> available(
        arv_camera_dup_available_pixel_formats(camera_, &count, nullptr), g_free);
    std::string out;
    for (guint i = 0; available && i < count; ++i) {
      const AravisFormat* format = find_aravis_format(static_cast<ArvPixelFormat>(available.get()[i]));
      if (format != nullptr && !format->is_copied())
        out += (out.empty() ? "" : ", ") + std::string(name_of(format->format));
    }
    return out.empty() ? "none that is supported" : out;
  }

  ArvCamera* camera_;
  std::string label_;
};

/// Without CAP_NET_RAW, images are received through a UDP socket, whose buffer size the system limits.
void warn_of_small_socket_buffer(const std::string& label, int wanted_bytes) {
  if (may_open_packet_sockets()) return;
  std::ifstream file("/proc/sys/net/core/rmem_max");
  if (int allowed_bytes = 0; file >> allowed_bytes && allowed_bytes < wanted_bytes) {
    log::warning(
        "camera \"{}\": images may get lost: net.core.rmem_max is {}, but socket_buffer_bytes is {}; raise "
        "net.core.rmem_max or give the service CAP_NET_RAW",
        label, allowed_bytes, wanted_bytes);
  }
}

void ask_for_chunks(ArvCamera* camera, std::vector<std::string>& warnings) {
  Failure failure;
  const bool has_chunks = arv_camera_are_chunks_available(camera, failure);
  if (has_chunks && !failure.failed()) {
    arv_camera_set_chunk_mode(camera, TRUE, failure);
    // Cameras support different chunks, so each call may fail.
    for (const char* chunk : {"Timestamp", "ExposureTime"}) {
      Failure refusal;
      if (!failure.failed()) arv_camera_set_chunk_state(camera, chunk, TRUE, refusal);
      if (refusal.failed()) log::info("chunks: no {}: {}", chunk, refusal.text());
    }
  }
  if (!has_chunks || failure.failed())
    warnings.emplace_back(
        fmt::format("chunks: {}", failure.failed() ? failure.text() : "the camera has none"));
}

}  // namespace

void set_up_aravis(ArvCamera* camera, const AravisOptions& options, const std::string& label,
                   std::vector<std::string>& warnings) {
  const Setup setup(camera, label);
  Failure failure;
  setup.pixel_format(options.pixel_format);
  setup.region(options);
  if (options.exposure_us) {
    if (arv_camera_is_exposure_auto_available(camera, failure))
      arv_camera_set_exposure_time_auto(camera, ARV_AUTO_OFF, failure);
    failure.require_answer(label);
    setup.real("exposure_us", *options.exposure_us, arv_camera_is_exposure_time_available,
               arv_camera_get_exposure_time_bounds, arv_camera_set_exposure_time);
  }
  if (options.gain) {
    if (arv_camera_is_gain_auto_available(camera, failure))
      arv_camera_set_gain_auto(camera, ARV_AUTO_OFF, failure);
    failure.require_answer(label);
    setup.real("gain", *options.gain, arv_camera_is_gain_available, arv_camera_get_gain_bounds,
               arv_camera_set_gain);
  }
  if (options.frame_rate_hz) {
    setup.real("frame_rate_hz", *options.frame_rate_hz, arv_camera_is_frame_rate_available,
               arv_camera_get_frame_rate_bounds, arv_camera_set_frame_rate);
  }
  if (options.chunks) ask_for_chunks(camera, warnings);
  arv_camera_set_acquisition_mode(camera, ARV_ACQUISITION_MODE_CONTINUOUS, failure);
  setup.check(failure, "acquisition mode", "Continuous");
  if (!arv_camera_is_gv_device(camera)) return;
  if (options.packet_size > 0) {
    arv_camera_gv_set_packet_size(camera, options.packet_size, failure);
  } else {
    arv_camera_gv_auto_packet_size(camera, failure);
  }
  setup.check(failure, "packet_size", options.packet_size);
  warn_of_small_socket_buffer(label, options.socket_buffer_bytes);
}
}  // namespace sslv
