// SPDX-License-Identifier: Apache-2.0
#include "capture/dc1394/dc1394_video.h"

#include "capture/source.h"
#include "capture/unpack.h"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include <fmt/format.h>

namespace sslv::iidc {
namespace {

bool is_raw(dc1394color_coding_t coding) {
  return coding == DC1394_COLOR_CODING_RAW8 || coding == DC1394_COLOR_CODING_RAW16;
}

PixelFormat bayer_format(dc1394color_filter_t order) {
  switch (order) {
    case DC1394_COLOR_FILTER_RGGB: return PixelFormat::kBayerRg8;
    case DC1394_COLOR_FILTER_GBRG: return PixelFormat::kBayerGb8;
    case DC1394_COLOR_FILTER_GRBG: return PixelFormat::kBayerGr8;
    case DC1394_COLOR_FILTER_BGGR: break;
  }
  return PixelFormat::kBayerBg8;
}

/// Maximum packet size (IEEE 1394-1995 and 1394b: 1024 bytes at S100, doubling with the speed).
std::uint32_t largest_packet_bytes(dc1394speed_t speed) {
  return 1024u << static_cast<unsigned>(speed);
}

/// Packet size in the modes of fixed size: IIDC 1.31 distributes an image at 30 Hz over 240 of the 267 bus
/// cycles.
double packet_bytes(std::uint32_t picture_bytes, double rate_hz) {
  return picture_bytes * rate_hz / 7200;
}

class Setup {
 public:
  Setup(dc1394camera_t* camera, const Options& options, const std::string& label)
      : camera_(camera), options_(options), label_(label) {}

  Video run() {
    // The camera may still be sending for a program that crashed.
    must(dc1394_video_set_transmission(camera_, DC1394_OFF), "does not stop sending");
    set_speed();
    choose_mode();
    must(dc1394_video_set_mode(camera_, mode_), "mode", mode_name());
    Video video = is_format7(mode_) ? set_format7() : set_native();
    dc1394video_mode_t now{};
    must(dc1394_video_get_mode(camera_, &now), "mode", mode_name());
    if (now != mode_)
      refuse("mode", mode_name(), fmt::format("the camera set {} instead", name_in(kModes, now)));
    finish(video);
    return video;
  }

 private:
  template <class V>
  [[noreturn]] void refuse(std::string_view key, const V& value, std::string_view why) const {
    throw CaptureError(fmt::format("camera \"{}\": {} {} refused: {}", label_, key, value, why));
  }
  void must(dc1394error_t error, std::string_view what) const { check(error, label_, what); }
  template <class V>
  void must(dc1394error_t error, std::string_view key, const V& value) const {
    if (error != DC1394_SUCCESS) refuse(key, value, dc1394_error_get_string(error));
  }
  std::string_view mode_name() const { return name_in(kModes, mode_); }

  // ---- speed

  void set_speed() {
    const bool fast = camera_->bmode_capable == DC1394_TRUE;
    speed_ = options_.iso_speed.value_or(fast ? DC1394_ISO_SPEED_800 : DC1394_ISO_SPEED_400);
    if (speed_ > DC1394_ISO_SPEED_400 && !fast)
      refuse("iso_speed", speed_name(), "the camera allows 100, 200, 400; it has no 1394b");
    if (fast) {
      const bool needs_b = speed_ > DC1394_ISO_SPEED_400;
      must(dc1394_video_set_operation_mode(
               camera_, needs_b ? DC1394_OPERATION_MODE_1394B : DC1394_OPERATION_MODE_LEGACY),
           "iso_speed", speed_name());
    }
    must(dc1394_video_set_iso_speed(camera_, speed_), "iso_speed", speed_name());
  }
  std::string_view speed_name() const { return name_in(kSpeeds, speed_); }

  // ---- mode and pixel format

  void choose_mode() {
    const std::vector<dc1394video_mode_t> modes = modes_of(camera_, label_);
    if (options_.mode) {
      mode_ = *options_.mode;
      if (std::find(modes.begin(), modes.end(), mode_) == modes.end())
        refuse("mode", mode_name(), "the camera has " + names_of(kModes, modes));
      const auto coding = choose_coding(mode_);
      if (!coding) {
        refuse("pixel_format", wanted_format(),
               fmt::format("{} has {}", mode_name(), names_of(kCodings, codings_of(camera_, mode_, label_))));
      }
      coding_ = *coding;
      return;
    }
    std::tuple<bool, long, long> best;  // Format7 or not; mode number or image size; rank of the coding
    bool found = false;
    for (const dc1394video_mode_t mode : modes) {
      const auto coding = choose_coding(mode);
      if (!coding) continue;
      const bool format7 = is_format7(mode);
      // The first Format7 mode shows the whole sensor; the other Format7 modes bin or skip pixels.
      const std::tuple<bool, long, long> merit{format7, format7 ? -long{mode} : area(mode), -rank(*coding)};
      if (found && merit <= best) continue;
      found = true;
      best = merit;
      mode_ = mode;
      coding_ = *coding;
    }
    if (!found)
      refuse("pixel_format", wanted_format(),
             "no mode of the camera has it; it has " + names_of(kModes, modes));
  }

  std::string_view wanted_format() const {
    return options_.pixel_format ? name_in(kCodings, *options_.pixel_format) : "auto";
  }
  std::optional<dc1394color_coding_t> choose_coding(dc1394video_mode_t mode) const {
    for (const dc1394color_coding_t coding : codings_of(camera_, mode, label_)) {
      if (options_.pixel_format ? coding == *options_.pixel_format : !is_raw(coding) || bayer_order(mode))
        return coding;
    }
    return std::nullopt;
  }
  static long rank(dc1394color_coding_t coding) {
    return std::find_if(kCodings.begin(), kCodings.end(),
                        [=](const auto& row) { return row.value == coding; }) -
           kCodings.begin();
  }
  long area(dc1394video_mode_t mode) const {
    std::uint32_t width = 0, height = 0;
    must(dc1394_get_image_size_from_video_mode(camera_, mode, &width, &height), "its modes cannot be read");
    return long{width} * long{height};
  }
  /// The Bayer order of raw images. Cameras before IIDC 1.31 do not report it.
  std::optional<dc1394color_filter_t> bayer_order(dc1394video_mode_t mode) const {
    if (options_.bayer_order) return options_.bayer_order;
    dc1394color_filter_t order{};
    if (!is_format7(mode) || dc1394_format7_get_color_filter(camera_, mode, &order) != DC1394_SUCCESS ||
        name_in(kBayerOrders, order) == "unknown") {
      return std::nullopt;
    }
    return order;
  }

  // ---- modes of fixed size

  Video set_native() {
    for (const auto& [key, value] : {std::pair{"width", options_.width},
                                     {"height", options_.height},
                                     {"offset_x", options_.offset_x},
                                     {"offset_y", options_.offset_y},
                                     {"packet_size_bytes", options_.packet_size_bytes}}) {
      if (value != 0) refuse(key, value, fmt::format("only Format7 modes have it; {} is fixed", mode_name()));
    }
    Video video;
    std::uint32_t width = 0, height = 0, bits = 0;
    must(dc1394_get_image_size_from_video_mode(camera_, mode_, &width, &height), "mode", mode_name());
    must(dc1394_get_color_coding_bit_size(coding_, &bits), "mode", mode_name());
    video.layout.width = static_cast<int>(width);
    video.layout.height = static_cast<int>(height);
    video.interval_s = 1 / set_native_rate(width * height * bits / 8);
    return video;
  }

  double set_native_rate(std::uint32_t picture_bytes) {
    dc1394framerates_t all{};
    must(dc1394_video_get_supported_framerates(camera_, mode_, &all), "its frame rates cannot be read");
    std::string there;
    std::optional<dc1394framerate_t> chosen;
    double chosen_hz = 0;
    for (std::uint32_t i = 0; i < all.num; ++i) {
      float rate_hz = 0;
      must(dc1394_framerate_as_float(all.framerates[i], &rate_hz), "its frame rates cannot be read");
      if (packet_bytes(picture_bytes, rate_hz) > largest_packet_bytes(speed_)) continue;
      there += fmt::format("{}{:g}", there.empty() ? "" : ", ", rate_hz);
      const bool fits = options_.frame_rate_hz ? std::abs(rate_hz - *options_.frame_rate_hz) < 0.01 * rate_hz
                                               : rate_hz > chosen_hz;
      if (!fits) continue;
      chosen = all.framerates[i];
      chosen_hz = rate_hz;
    }
    const std::string allowed = fmt::format("{} at iso_speed {} allows {}", mode_name(), speed_name(),
                                            there.empty() ? "none" : there);
    if (!chosen) {
      if (options_.frame_rate_hz) refuse("frame_rate_hz", *options_.frame_rate_hz, allowed);
      refuse("mode", mode_name(), allowed + " of the frame rates");
    }
    must(dc1394_video_set_framerate(camera_, *chosen), "frame_rate_hz", chosen_hz);
    dc1394framerate_t now{};
    must(dc1394_video_get_framerate(camera_, &now), "frame_rate_hz", chosen_hz);
    if (now != *chosen) refuse("frame_rate_hz", chosen_hz, allowed);
    return chosen_hz;
  }

  // ---- Format7

  struct Side {
    const char *size_key, *offset_key;
    int size, offset;
    std::uint32_t most = 0, unit = 0, offset_unit = 0;
  };

  /// The size of this side. Throws if the size or the offset does not suit the mode.
  int checked(const Side& side) const {
    const int most = static_cast<int>(side.most), unit = std::max(1, static_cast<int>(side.unit));
    // A camera without a position unit uses the size unit.
    const int offset_unit = side.offset_unit > 0 ? static_cast<int>(side.offset_unit) : unit;
    const int size = side.size > 0 ? side.size : (most - side.offset) / unit * unit;
    if (size % unit != 0 || size < unit || size > most) {
      refuse(
          side.size > 0 ? side.size_key : side.offset_key, side.size > 0 ? side.size : side.offset,
          fmt::format("{} allows {} .. {} in steps of {}", mode_name(), side.size > 0 ? unit : 0,
                      side.size > 0 ? most / unit * unit : most - unit, side.size > 0 ? unit : offset_unit));
    }
    if (side.offset % offset_unit != 0 || side.offset + size > most) {
      refuse(side.offset_key, side.offset,
             fmt::format("{} of {} {} allows 0 .. {} in steps of {}", mode_name(), side.size_key, size,
                         (most - size) / offset_unit * offset_unit, offset_unit));
    }
    return size;
  }

  Video set_format7() {
    // The permitted sizes may depend on the pixel format.
    must(dc1394_format7_set_color_coding(camera_, mode_, coding_), "pixel_format",
         name_in(kCodings, coding_));
    Side x{"width", "offset_x", options_.width, options_.offset_x};
    Side y{"height", "offset_y", options_.height, options_.offset_y};
    must(dc1394_format7_get_max_image_size(camera_, mode_, &x.most, &y.most), "mode", mode_name());
    must(dc1394_format7_get_unit_size(camera_, mode_, &x.unit, &y.unit), "mode", mode_name());
    if (dc1394_format7_get_unit_position(camera_, mode_, &x.offset_unit, &y.offset_unit) != DC1394_SUCCESS)
      x.offset_unit = y.offset_unit = 0;
    Video video;
    video.layout.width = checked(x);
    video.layout.height = checked(y);
    must(dc1394_format7_set_roi(camera_, mode_, coding_, DC1394_USE_RECOMMENDED, x.offset, y.offset,
                                video.layout.width, video.layout.height),
         "mode", mode_name());
    std::uint32_t width = 0, height = 0;
    must(dc1394_format7_get_image_size(camera_, mode_, &width, &height), "mode", mode_name());
    if (std::cmp_not_equal(width, video.layout.width) || std::cmp_not_equal(height, video.layout.height)) {
      refuse("width and height", fmt::format("{}x{}", video.layout.width, video.layout.height),
             fmt::format("the camera set {}x{} instead", width, height));
    }
    set_packet_size();
    set_format7_rate();
    float interval_s = 0;
    std::uint32_t packets = 0;
    if (dc1394_format7_get_frame_interval(camera_, mode_, &interval_s) == DC1394_SUCCESS && interval_s > 0) {
      video.interval_s = interval_s;
    } else if (options_.frame_rate_hz) {
      video.interval_s = 1 / *options_.frame_rate_hz;
    } else if (dc1394_format7_get_packets_per_frame(camera_, mode_, &packets) == DC1394_SUCCESS) {
      video.interval_s = packets * kCycleSeconds;
    }
    return video;
  }

  void set_packet_size() {
    std::uint32_t unit = 0, most = 0, now = 0;
    must(dc1394_format7_get_packet_parameters(camera_, mode_, &unit, &most), "packet sizes cannot be read");
    must(dc1394_format7_get_packet_size(camera_, mode_, &now), "packet sizes cannot be read");
    if (unit == 0) unit = most;
    if (unit == 0) return;  // the camera supports only one size
    most = std::min(most, largest_packet_bytes(speed_)) / unit * unit;
    const auto wanted = options_.packet_size_bytes > 0
                            ? static_cast<std::uint32_t>(options_.packet_size_bytes)
                            : std::min(now, most);
    if (wanted % unit != 0 || wanted < unit || wanted > most) {
      refuse("packet_size_bytes", wanted,
             fmt::format("{} at iso_speed {} allows {} .. {} in steps of {}", mode_name(), speed_name(), unit,
                         most, unit));
    }
    if (wanted == now) return;
    must(dc1394_format7_set_packet_size(camera_, mode_, wanted), "packet_size_bytes", wanted);
    must(dc1394_format7_get_packet_size(camera_, mode_, &now), "packet_size_bytes", wanted);
    if (now != wanted) refuse("packet_size_bytes", wanted, fmt::format("the camera set {} instead", now));
  }

  void set_format7_rate() {
    if (!options_.frame_rate_hz) return;
    const double wanted = *options_.frame_rate_hz;
    constexpr dc1394feature_t kRate = DC1394_FEATURE_FRAME_RATE;
    dc1394bool_t is_there = DC1394_FALSE, is_absolute = DC1394_FALSE, is_switch = DC1394_FALSE;
    dc1394_feature_is_present(camera_, kRate, &is_there);
    if (is_there == DC1394_TRUE) dc1394_feature_has_absolute_control(camera_, kRate, &is_absolute);
    if (is_absolute != DC1394_TRUE)
      refuse("frame_rate_hz", wanted, "in Format7, packet_size_bytes sets it on this camera");
    dc1394_feature_is_switchable(camera_, kRate, &is_switch);
    if (is_switch == DC1394_TRUE)
      must(dc1394_feature_set_power(camera_, kRate, DC1394_ON), "frame_rate_hz", wanted);
    must(dc1394_feature_set_mode(camera_, kRate, DC1394_FEATURE_MODE_MANUAL), "frame_rate_hz", wanted);
    float least = 0, most = 0;
    must(dc1394_feature_get_absolute_boundaries(camera_, kRate, &least, &most), "frame_rate_hz", wanted);
    if (wanted < least || wanted > most)
      refuse("frame_rate_hz", wanted, fmt::format("the camera allows {:g} .. {:g} now", least, most));
    must(dc1394_feature_set_absolute_control(camera_, kRate, DC1394_ON), "frame_rate_hz", wanted);
    must(dc1394_feature_set_absolute_value(camera_, kRate, static_cast<float>(wanted)), "frame_rate_hz",
         wanted);
  }

  // ---- the resulting stream

  void finish(Video& video) const {
    video.coding = coding_;
    ImageView& layout = video.layout;
    layout.format = pixel_format();
    layout.stride_bytes = std::ptrdiff_t{layout.width} * bytes_per_pixel(layout.format);
    if (!is_valid_size(layout.format, layout.width, layout.height)) {
      refuse("width and height", fmt::format("{}x{}", layout.width, layout.height),
             fmt::format("{} needs even values", name_of(layout.format)));
    }
    if (coding_ == DC1394_COLOR_CODING_MONO16 || coding_ == DC1394_COLOR_CODING_RAW16)
      layout.to_low_bits = layout.stride_bytes * layout.height;
    if (coding_ == DC1394_COLOR_CODING_YUV411 && layout.width % 4 != 0)
      refuse("width", layout.width, "yuv411 needs a multiple of 4");
    video.summary = is_format7(mode_) ? fmt::format("{} {} {}x{}", mode_name(), name_in(kCodings, coding_),
                                                    layout.width, layout.height)
                                      : fmt::format("{} at {:g} Hz", mode_name(), 1 / video.interval_s);
    video.summary += fmt::format(", iso_speed {}", speed_name());
  }

  PixelFormat pixel_format() const {
    switch (coding_) {
      case DC1394_COLOR_CODING_RGB8: return PixelFormat::kRgb24;
      case DC1394_COLOR_CODING_MONO8:
      case DC1394_COLOR_CODING_MONO16:
        return options_.bayer_order ? bayer_format(*options_.bayer_order) : PixelFormat::kMono8;
      case DC1394_COLOR_CODING_RAW8:
      case DC1394_COLOR_CODING_RAW16: {
        const auto order = bayer_order(mode_);
        if (!order)
          refuse("bayer_order", "auto", "the camera does not report it; set one of rggb, gbrg, grbg, bggr");
        return bayer_format(*order);
      }
      default: return PixelFormat::kUyvy;
    }
  }

  template <class Table, class T>
  static std::string names_of(const Table& table, const std::vector<T>& values) {
    std::string out;
    for (const T value : values) out += (out.empty() ? "" : ", ") + std::string(name_in(table, value));
    return out.empty() ? "none that is supported" : out;
  }

  dc1394camera_t* camera_;
  const Options& options_;
  const std::string& label_;
  dc1394speed_t speed_ = DC1394_ISO_SPEED_400;
  dc1394video_mode_t mode_ = DC1394_VIDEO_MODE_FORMAT7_0;
  dc1394color_coding_t coding_ = DC1394_COLOR_CODING_YUV422;
};

}  // namespace

Video set_up_video(dc1394camera_t* camera, const Options& options, const std::string& label) {
  return Setup(camera, options, label).run();
}

bool needs_unpacking(dc1394color_coding_t coding) {
  return coding == DC1394_COLOR_CODING_YUV411 || coding == DC1394_COLOR_CODING_YUV444 ||
         coding == DC1394_COLOR_CODING_MONO16 || coding == DC1394_COLOR_CODING_RAW16;
}

void unpack(const dc1394video_frame_t& frame, const ImageView& layout, std::uint8_t* to) noexcept {
  const std::size_t pixels = std::size_t{frame.size[0]} * frame.size[1];
  if (frame.color_coding == DC1394_COLOR_CODING_YUV411) return yuv411_to_uyvy(frame.image, pixels, to);
  if (frame.color_coding == DC1394_COLOR_CODING_YUV444) return yuv444_to_uyvy(frame.image, pixels, to);
  split_big_endian(frame.image, pixels, static_cast<int>(frame.data_depth), to, to + layout.to_low_bits);
}

}  // namespace sslv::iidc
