// SPDX-License-Identifier: Apache-2.0
#include "capture/v4l2/v4l2_format.h"

#include "capture/source.h"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <limits>
#include <utility>

#include <fmt/format.h>

namespace sslv {

namespace {

constexpr double kAnyRate = std::numeric_limits<double>::infinity();

const V4l2Format* format_of(std::uint32_t fourcc) {
  const auto* found = std::find_if(kV4l2Formats.begin(), kV4l2Formats.end(),
                                   [=](const V4l2Format& f) { return f.fourcc == fourcc; });
  return found == kV4l2Formats.end() ? nullptr : found;
}

std::string letters_of(std::uint32_t fourcc) {
  std::string out;
  for (int shift = 0; shift < 32; shift += 8) {
    const auto letter = static_cast<char>(fourcc >> shift & 0x7f);
    out += letter >= ' ' ? letter : '?';
  }
  return out;
}

struct Size {
  int width, height;
};

/// The relevant fields of a v4l2_format of either buffer type.
struct Made {
  __u32 fourcc, width, height, field, row_bytes;
  int planes;
};

Made made_of(const v4l2_format& format) {
  if (format.type == V4L2_BUF_TYPE_VIDEO_CAPTURE_MPLANE) {
    const v4l2_pix_format_mplane& pix = format.fmt.pix_mp;
    return {pix.pixelformat, pix.width, pix.height, pix.field, pix.plane_fmt[0].bytesperline, pix.num_planes};
  }
  const v4l2_pix_format& pix = format.fmt.pix;
  return {pix.pixelformat, pix.width, pix.height, pix.field, pix.bytesperline, 1};
}

v4l2_format wish_for(v4l2_buf_type buffers, const V4l2Format& format, const Size& size) {
  v4l2_format out{};
  out.type = buffers;
  const auto fill = [&](auto& pix) {
    pix.width = static_cast<__u32>(size.width);
    pix.height = static_cast<__u32>(size.height);
    pix.pixelformat = format.fourcc;
    pix.field = V4L2_FIELD_NONE;
  };
  if (buffers == V4L2_BUF_TYPE_VIDEO_CAPTURE_MPLANE) {
    fill(out.fmt.pix_mp);
    out.fmt.pix_mp.num_planes = 1;
  } else {
    fill(out.fmt.pix);
  }
  return out;
}

double rate_hz(const v4l2_fract& interval) {
  return interval.numerator == 0 ? 0 : static_cast<double>(interval.denominator) / interval.numerator;
}

/// Configures one device; a refusal throws CaptureError that begins with the label.
class FormatSetup {
 public:
  FormatSetup(V4l2Device& device, v4l2_buf_type buffers, const V4l2FormatWish& wish, const std::string& label)
      : device_(device),
        buffers_(buffers),
        wish_(wish),
        label_(label),
        formats_(v4l2_formats_of(device, buffers)) {}

  V4l2FormatSet run() {
    v4l2_format now{};
    now.type = buffers_;
    if (const int error = device_.call(VIDIOC_G_FMT, &now); error != 0)
      fail("its format cannot be read: " + errno_text(error));
    const Made was = made_of(now);
    size_ = {wish_.width > 0 ? wish_.width : static_cast<int>(was.width),
             wish_.height > 0 ? wish_.height : static_cast<int>(was.height)};
    const V4l2Format format = choose();
    now = wish_for(buffers_, format, size_);
    if (const int error = device_.call(VIDIOC_S_FMT, &now); error != 0)
      refuse("pixel_format", format.name, error == EBUSY ? "another program uses it" : errno_text(error));
    return checked(format, made_of(now));
  }

 private:
  V4l2FormatSet checked(const V4l2Format& format, const Made& made) {
    if (made.fourcc != format.fourcc)
      refuse("pixel_format", format.name, fmt::format("the camera set {} instead", letters_of(made.fourcc)));
    if (made.planes != 1)
      refuse("pixel_format", format.name, fmt::format("the camera delivers it in {} planes", made.planes));
    const Size size{static_cast<int>(made.width), static_cast<int>(made.height)};
    const auto is_other = [](int wanted, int got) { return wanted > 0 && wanted != got; };
    if (is_other(wish_.width, size.width) || is_other(wish_.height, size.height)) {
      refuse("width x height", fmt::format("{}x{}", size_.width, size_.height),
             fmt::format("the camera set {}x{} instead{}", size.width, size.height, known_sizes(format)));
    }
    size_ = size;
    constexpr std::array<__u32, 4> kWhole{V4L2_FIELD_NONE, V4L2_FIELD_INTERLACED, V4L2_FIELD_INTERLACED_TB,
                                          V4L2_FIELD_INTERLACED_BT};
    if (std::find(kWhole.begin(), kWhole.end(), made.field) == kWhole.end())
      fail("it delivers half images of every second row (interlaced)");
    // For NV12, the length of a row of Y; rows of colours are equally long.
    const bool is_nv12 = format.fourcc == V4L2_PIX_FMT_NV12;
    const PixelFormat becomes = format.pixels.value_or(PixelFormat::kUyvy);
    const bool suits = is_valid_size(becomes, size.width, size.height) && (!is_nv12 || size.height % 2 == 0);
    if ((format.pixels || is_nv12) && !suits)
      refuse("pixel_format", format.name, fmt::format("it does not support {}x{}", size.width, size.height));
    const int row_bytes = format.pixels ? size.width * bytes_per_pixel(becomes) : is_nv12 ? size.width : 0;
    return {format, size.width, size.height, std::max<std::ptrdiff_t>(row_bytes, made.row_bytes),
            set_rate(format)};
  }

  V4l2Format choose() const {
    if (wish_.fourcc != kV4l2AutoFormat) {
      const V4l2Format& wanted = *format_of(wish_.fourcc);
      const bool has = std::any_of(formats_.begin(), formats_.end(),
                                   [&](const V4l2Format& f) { return f.fourcc == wanted.fourcc; });
      if (!has) refuse("pixel_format", wanted.name, "the camera has " + known_formats());
      return wanted;
    }
    if (formats_.empty()) refuse("pixel_format", "auto", "the camera has " + known_formats());
    const double enough_hz = wish_.frame_rate_hz.value_or(kAnyRate);
    const auto speed = [&](const V4l2Format& f) { return std::min(fastest_hz(f), enough_hz); };
    return *std::max_element(
        formats_.begin(), formats_.end(),  // the first of equally fast formats
        [&](const V4l2Format& a, const V4l2Format& b) { return speed(a) < speed(b) - 0.01; });
  }

  /// The fastest rate at the wanted size; infinite if the driver reports no rates, 0 if the format lacks this
  /// size.
  double fastest_hz(const V4l2Format& format) const {
    double fastest = 0;
    const int error =
        each_interval(format, [&](const v4l2_fract& i) { fastest = std::max(fastest, rate_hz(i)); });
    return error == ENOTTY ? kAnyRate : fastest;
  }

  /// Calls `use` with each discrete interval, or with the shortest of a range. Returns the errno of the first
  /// query.
  template <class Use>
  int each_interval(const V4l2Format& format, Use&& use) const {
    for (__u32 i = 0;; ++i) {
      v4l2_frmivalenum interval{};
      interval.index = i;
      interval.pixel_format = format.fourcc;
      interval.width = static_cast<__u32>(size_.width);
      interval.height = static_cast<__u32>(size_.height);
      const int error = device_.call(VIDIOC_ENUM_FRAMEINTERVALS, &interval);
      if (error != 0) return i == 0 ? error : 0;
      use(interval.type == V4L2_FRMIVAL_TYPE_DISCRETE ? interval.discrete : interval.stepwise.min);
      if (interval.type != V4L2_FRMIVAL_TYPE_DISCRETE) return 0;
    }
  }

  /// Returns the time between images in s; 0: unknown.
  double set_rate(const V4l2Format& format) {
    v4l2_streamparm parameters{};
    parameters.type = buffers_;
    v4l2_captureparm& capture = parameters.parm.capture;
    const bool readable = device_.call(VIDIOC_G_PARM, &parameters) == 0;
    if (wish_.frame_rate_hz) {
      if (!readable || (capture.capability & V4L2_CAP_TIMEPERFRAME) == 0)
        fail("frame_rate_hz cannot be set: the camera has no such setting");
      constexpr double kParts = 10'000;  // numerator of the frame period
      capture.timeperframe = {static_cast<__u32>(kParts),
                              static_cast<__u32>(std::lround(*wish_.frame_rate_hz * kParts))};
      if (const int error = device_.call(VIDIOC_S_PARM, &parameters); error != 0)
        refuse("frame_rate_hz", *wish_.frame_rate_hz, errno_text(error));
      const double made_hz = rate_hz(capture.timeperframe);
      if (std::abs(made_hz - *wish_.frame_rate_hz) > 0.01 * *wish_.frame_rate_hz) {
        refuse("frame_rate_hz", *wish_.frame_rate_hz,
               fmt::format("the camera set {:.4g} instead{}", made_hz, known_rates(format)));
      }
    }
    const double set_hz = readable ? rate_hz(capture.timeperframe) : 0;
    return set_hz > 0 ? 1 / set_hz : 0;
  }

  std::string known_formats() const {
    std::string out;
    for (const V4l2Format& format : formats_) out += (out.empty() ? "" : ", ") + std::string(format.name);
    return out.empty() ? "none that is supported" : out;
  }

  std::string known_sizes(const V4l2Format& format) const {
    std::string out;
    for (__u32 i = 0;; ++i) {
      v4l2_frmsizeenum size{};
      size.index = i;
      size.pixel_format = format.fourcc;
      if (device_.call(VIDIOC_ENUM_FRAMESIZES, &size) != 0) break;
      if (size.type != V4L2_FRMSIZE_TYPE_DISCRETE) {
        const v4l2_frmsize_stepwise& range = size.stepwise;
        return fmt::format("; it allows {}x{} to {}x{}", range.min_width, range.min_height, range.max_width,
                           range.max_height);
      }
      out +=
          fmt::format("{}{}x{}", out.empty() ? "; it has " : ", ", size.discrete.width, size.discrete.height);
    }
    return out;
  }

  std::string known_rates(const V4l2Format& format) const {
    std::string out;
    each_interval(format, [&](const v4l2_fract& i) {
      out += fmt::format("{}{:.4g}", out.empty() ? "; it has " : ", ", rate_hz(i));
    });
    return out.empty() ? out : out + fmt::format(" for {}x{} {}", size_.width, size_.height, format.name);
  }

  template <class V>
  [[noreturn]] void refuse(std::string_view key, const V& value, std::string_view why) const {
    fail(fmt::format("{} {} refused: {}", key, value, why));
  }
  [[noreturn]] void fail(std::string_view why) const {
    throw CaptureError(fmt::format("camera \"{}\": {}", label_, why));
  }

  V4l2Device& device_;
  const v4l2_buf_type buffers_;
  const V4l2FormatWish& wish_;
  const std::string& label_;
  const std::vector<V4l2Format> formats_;
  Size size_{};  // first the wanted size, then the actual size
};

}  // namespace

std::vector<V4l2Format> v4l2_formats_of(V4l2Device& device, v4l2_buf_type buffers) {
  std::vector<V4l2Format> out;
  for (__u32 i = 0;; ++i) {
    v4l2_fmtdesc description{};
    description.index = i;
    description.type = buffers;
    if (device.call(VIDIOC_ENUM_FMT, &description) != 0) break;
    if (const V4l2Format* format = format_of(description.pixelformat)) out.push_back(*format);
  }
  const auto place = [](const V4l2Format& f) { return format_of(f.fourcc); };
  std::sort(out.begin(), out.end(),
            [&](const V4l2Format& a, const V4l2Format& b) { return place(a) < place(b); });
  return out;
}

V4l2FormatSet set_v4l2_format(V4l2Device& device, v4l2_buf_type buffers, const V4l2FormatWish& wish,
                              const std::string& label) {
  return FormatSetup(device, buffers, wish, label).run();
}

}  // namespace sslv
