// SPDX-License-Identifier: Apache-2.0
#include "capture/v4l2/v4l2.h"

#include "base/clock.h"
#include "base/params_json.h"
#include "capture/buffer_pool.h"
#include "capture/control_queue.h"
#include "capture/unpack.h"
#include "capture/v4l2/v4l2_controls.h"
#include "capture/v4l2/v4l2_format.h"
#include "capture/v4l2/v4l2_stream.h"
#include "capture/v4l2/v4l2_times.h"
#include "image/jpeg_decoder.h"

#include <algorithm>
#include <cerrno>
#include <fstream>
#include <optional>
#include <span>
#include <utility>

#include <fmt/format.h>

namespace sslv {
namespace {

struct V4l2Options {
  std::string camera;
  std::uint32_t pixel_format = kV4l2AutoFormat;
  int width = 0, height = 0;
  std::optional<double> frame_rate_hz;
  int buffers = 8;
  double silence_s = 5;
  Json controls = Json::object();
  static constexpr auto fields() {
    using O = V4l2Options;
    return std::tuple{
        text("camera", &O::camera,
             "the camera's serial number, where it is plugged in (usb-0000:00:14.0-2), its name in "
             "/dev/v4l/by-id or by-path, or a path; empty: the first camera found"),
        choice("pixel_format", &O::pixel_format, kV4l2FormatChoices,
               "auto: a sufficiently fast format, preferably uncompressed"),
        number("width", &O::width, 0, 16384, "px", "0: leave as it is"),
        number("height", &O::height, 0, 16384, "px", "0: leave as it is"),
        number("frame_rate_hz", &O::frame_rate_hz, 0.01, 10000.0, "Hz", "null: leave as it is"),
        number("buffers", &O::buffers, 3, 32, "", "number of buffers for images in transit"),
        number("silence_s", &O::silence_s, 0.1, 3600.0, "s",
               "a camera that sends nothing for this long counts as lost"),
        object("controls", &O::controls, "controls set at opening, with the camera's own names and values"),
    };
  }
};

/// uvcvideo claims to stamp the start of the exposure, but stamps the arrival of the first bytes, unless it
/// is configured to trust the cameras' clocks (drivers/media/usb/uvc/uvc_video.c).
bool stamps_first_bytes(const std::string& driver) {
  std::ifstream file("/sys/module/uvcvideo/parameters/hwtimestamps");
  char trusts_cameras = '0';
  file >> trusts_cameras;
  return driver == "uvcvideo" && trusts_cameras != '1' && trusts_cameras != 'Y';
}

double seconds(const timeval& time) {
  return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

class V4l2Source final : public Source {
 public:
  V4l2Source(V4l2Options options, const V4l2System& system) : options_(std::move(options)) {
    V4l2Node node = find_v4l2_node(system, options_.camera);
    device_ = std::move(node.device);
    label_ = options_.camera.empty() ? node.path : options_.camera;
    stamps_first_bytes_ = stamps_first_bytes(node.driver);
    controls_ = std::make_shared<V4l2Controls>(device_);
    // Set controls first: some change the available sizes and rates, and some are locked while streaming.
    warnings_ = controls_->queue().open_with(options_.controls);
    format_ = set_v4l2_format(
        *device_, node.buffers,
        {options_.pixel_format, options_.width, options_.height, options_.frame_rate_hz}, label_);
    timing_.period_s = format_.period_s;
    watch_exposure();
    if (!format_.format.pixels) make_own_buffers();
    stream_ = V4l2Stream::start(device_, node.buffers, options_.buffers, label_);
    last_picture_ns_ = steady_ns();
  }

  ~V4l2Source() override {
    controls_->close();
    stream_->stop();
  }

  std::uint64_t dropped() const noexcept override { return dropped_; }
  std::shared_ptr<Controls> controls() override { return controls_; }
  std::vector<std::string> warnings() const override { return warnings_; }

  CaptureStatus next(CapturedImage& image, std::string& problem, std::chrono::milliseconds timeout) override {
    const V4l2Device::Ready ready = device_->wait(timeout);
    if (ready.event) read_events();
    if (!ready.picture && !ready.error) return nothing_came(problem);

    V4l2Stream::Filled filled;
    const int error = stream_->fetch(filled);
    if (error == EAGAIN && !ready.error) return CaptureStatus::kTimeout;
    if (error != 0) {
      return mark_lost(problem, error == ENODEV
                                    ? "it is no longer connected"
                                    : fmt::format("it delivers no more images: {}", errno_text(error)));
    }
    last_picture_ns_ = steady_ns();
    count_gap(filled.sequence);
    if ((filled.flags & V4L2_BUF_FLAG_ERROR) != 0) {
      stream_->give_back(filled);
      problem = "the driver reports it as damaged";
      return CaptureStatus::kIncomplete;
    }
    image.times = times_of(filled);
    if (format_.format.pixels) return lend(filled, image, problem);
    const CaptureStatus status = format_.format.fourcc == V4L2_PIX_FMT_NV12
                                     ? spread_colors(filled, image, problem)
                                     : decompress(filled, image, problem);
    stream_->give_back(filled);
    return status;
  }

 private:
  CaptureStatus mark_lost(std::string& problem, std::string_view why) const {
    problem = fmt::format("camera \"{}\": {}", label_, why);
    return CaptureStatus::kLost;
  }

  CaptureStatus nothing_came(std::string& problem) {
    if (const int error = stream_->queue_error(); error != 0)
      return mark_lost(problem, fmt::format("its buffers cannot be queued again: {}", errno_text(error)));
    if (!stream_->can_deliver()) last_picture_ns_ = steady_ns();  // all buffers lent: not the camera's fault
    if (static_cast<double>(steady_ns() - last_picture_ns_) * 1e-9 < options_.silence_s)
      return CaptureStatus::kTimeout;
    return mark_lost(problem, fmt::format("no image for {} s", options_.silence_s));
  }

  /// Whether all rows of the image arrived, and no more bytes than the buffer holds.
  bool is_whole(const V4l2Stream::Filled& filled, int rows, std::ptrdiff_t row_bytes,
                std::string& problem) const {
    const std::ptrdiff_t needed = format_.stride_bytes * (rows - 1) + row_bytes;
    if (static_cast<std::ptrdiff_t>(filled.bytes) >= needed && filled.bytes <= filled.most) return true;
    problem = fmt::format("{} bytes arrived; {}x{} {} needs {}", filled.bytes, format_.width, format_.height,
                          format_.format.name, needed);
    return false;
  }

  CaptureStatus lend(const V4l2Stream::Filled& filled, CapturedImage& image, std::string& problem) {
    const PixelFormat pixels = *format_.format.pixels;
    if (!is_whole(filled, format_.height, std::ptrdiff_t{format_.width} * bytes_per_pixel(pixels), problem)) {
      stream_->give_back(filled);
      return CaptureStatus::kIncomplete;
    }
    image.image =
        stream_->lend(filled, {nullptr, format_.width, format_.height, format_.stride_bytes, pixels});
    return CaptureStatus::kImage;
  }

  /// Converts NV12 to uyvy.
  CaptureStatus spread_colors(const V4l2Stream::Filled& filled, CapturedImage& image, std::string& problem) {
    const int width = format_.width, height = format_.height;
    if (!is_whole(filled, height + height / 2, width, problem)) return CaptureStatus::kIncomplete;
    std::uint8_t* pixels = nullptr;
    const ImageView layout{nullptr, width, height, std::ptrdiff_t{2} * width, PixelFormat::kUyvy};
    Image free = own_buffers_->take(layout, pixels);
    if (pixels == nullptr) {  // all buffers are lent
      ++dropped_;
      return CaptureStatus::kTimeout;
    }
    const std::uint8_t* luma = stream_->bytes_of(filled);
    const std::uint8_t* colors = luma + format_.stride_bytes * height;
    for (int y = 0; y < height; ++y) {
      nv12_row_to_uyvy(luma + y * format_.stride_bytes, colors + y / 2 * format_.stride_bytes,
                       static_cast<std::size_t>(width), pixels + y * layout.stride_bytes);
    }
    image.image = std::move(free);
    return CaptureStatus::kImage;
  }

  CaptureStatus decompress(const V4l2Stream::Filled& filled, CapturedImage& image, std::string& problem) {
    const std::span jpeg(stream_->bytes_of(filled), std::min(filled.bytes, filled.most));
    const ImageView layout = decoder_->layout(jpeg, problem);
    CaptureStatus status = CaptureStatus::kIncomplete;
    if (layout.width > 0 && (layout.width != format_.width || layout.height != format_.height)) {
      problem = fmt::format("{}x{} pixels arrived instead of {}x{}", layout.width, layout.height,
                            format_.width, format_.height);
    } else if (layout.width > 0) {
      std::uint8_t* pixels = nullptr;
      Image free = own_buffers_->take(layout, pixels);
      if (pixels == nullptr) {  // all buffers are lent
        ++dropped_;
        status = CaptureStatus::kTimeout;
      } else if (decoder_->decode(jpeg, pixels, problem)) {
        image.image = std::move(free);
        status = CaptureStatus::kImage;
      }
    }
    return status;
  }

  void make_own_buffers() {
    decoder_.emplace();
    constexpr std::size_t kMaxBytesPerPixel = 3;
    own_buffers_.emplace(static_cast<std::size_t>(options_.buffers),
                         kMaxBytesPerPixel * static_cast<std::size_t>(format_.width) *
                             static_cast<std::size_t>(format_.height));
  }

  void count_gap(std::uint32_t sequence) {
    const std::uint32_t step = sequence - last_sequence_.value_or(sequence - 1);  // also after a wrap to 0
    constexpr std::uint32_t kBackwards = 1U << 31;
    if (step > 1 && step < kBackwards) dropped_ += step - 1;
    last_sequence_ = sequence;
  }

  /// Subscribes to the driver's reports of exposure changes made by any program. Querying a USB camera would
  /// take a millisecond.
  void watch_exposure() {
    v4l2_event_subscription subscription{};
    subscription.type = V4L2_EVENT_CTRL;
    subscription.id = V4L2_CID_EXPOSURE_ABSOLUTE;
    subscription.flags = V4L2_EVENT_SUB_FL_SEND_INITIAL | V4L2_EVENT_SUB_FL_ALLOW_FEEDBACK;
    // Fails for a camera without this control, whose exposure is then unknown.
    device_->call(VIDIOC_SUBSCRIBE_EVENT, &subscription);
    read_events();
  }

  void read_events() {
    v4l2_event event{};
    while (device_->call(VIDIOC_DQEVENT, &event) == 0) {
      if (event.type != V4L2_EVENT_CTRL || event.id != V4L2_CID_EXPOSURE_ABSOLUTE) continue;
      constexpr double kUnitS = 100e-6;
      const bool automatic = (event.u.ctrl.flags & V4L2_CTRL_FLAG_INACTIVE) != 0;
      timing_.exposure_s.reset();
      if (!automatic && event.u.ctrl.value > 0) timing_.exposure_s = kUnitS * event.u.ctrl.value;
    }
  }

  CaptureTimes times_of(const V4l2Stream::Filled& filled) {
    timing_.stamped_at = stamped_at(filled.flags, stamps_first_bytes_);
    double stamp_s = unix_time_s();
    if (timing_.stamped_at != V4l2StampedAt::kArrival) {
      const double now_s = 1e-9 * static_cast<double>(steady_ns());
      stamp_s -= now_s - seconds(filled.timestamp);
    }
    return capture_times(stamp_s, timing_);
  }

  const V4l2Options options_;
  std::string label_;  // the admin's name of the camera
  bool stamps_first_bytes_ = false;
  std::vector<std::string> warnings_;
  std::shared_ptr<V4l2Device> device_;
  std::shared_ptr<V4l2Controls> controls_;
  std::shared_ptr<V4l2Stream> stream_;
  V4l2FormatSet format_;
  V4l2Timing timing_;
  std::optional<JpegDecoder> decoder_;  // like own_buffers_, only for formats that need conversion
  std::optional<BufferPool> own_buffers_;
  std::optional<std::uint32_t> last_sequence_;
  std::uint64_t dropped_ = 0;
  std::int64_t last_picture_ns_ = 0;  // steady_ns() of the last image, which may be damaged
};

}  // namespace

std::unique_ptr<Source> open_v4l2(const Json& options, const V4l2System& system) {
  return std::make_unique<V4l2Source>(params_from_json<V4l2Options>(options, ""), system);
}

std::vector<FoundCamera> list_v4l2(const V4l2System& system) {
  const std::vector<V4l2Node> nodes = find_v4l2_nodes(system);
  std::vector<FoundCamera> out;
  for (const V4l2Node& node : nodes) {
    FoundCamera found;
    found.name = fmt::format("{}{}{} ({}, {})", node.model, node.serial.empty() ? "" : " ", node.serial,
                             node.driver, node.bus);
    found.source = {{"backend", "v4l2"}, {"camera", known_by(node, nodes)}};
    found.model = node.model;
    found.serial = node.serial;
    found.other_names = node.links;
    found.other_names.insert(found.other_names.end(), {node.bus, node.path});
    for (const V4l2Format& format : v4l2_formats_of(*node.device, node.buffers))
      found.formats.emplace_back(format.name);
    out.push_back(std::move(found));
  }
  return out;
}

Backend v4l2_backend() {
  return {
      "v4l2",
      "webcams and other cameras with a kernel driver",
      [](const Json& options, const std::string& path) {
        return params_to_json(params_from_json<V4l2Options>(options, path));
      },
      [] { return params_schema<V4l2Options>(); },
      [](const Json& options, const SourceContext&) { return open_v4l2(options, {}); },
      [] { return list_v4l2({}); },
  };
}

}  // namespace sslv
