// SPDX-License-Identifier: Apache-2.0
#include "capture/dc1394/dc1394.h"

#include "base/clock.h"
#include "base/error.h"
#include "base/log.h"
#include "base/params_json.h"
#include "capture/buffer_pool.h"
#include "capture/control_queue.h"
#include "capture/dc1394/dc1394_camera.h"
#include "capture/dc1394/dc1394_controls.h"
#include "capture/dc1394/dc1394_options.h"
#include "capture/dc1394/dc1394_ring.h"
#include "capture/dc1394/dc1394_video.h"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <mutex>
#include <utility>

#include <fmt/format.h>
#include <poll.h>

namespace sslv {
namespace {

using namespace iidc;
using Clock = std::chrono::steady_clock;

/// Assumed standard deviation of the delay between the end of the exposure and the start of sending, which
/// differs between cameras.
constexpr double kReadoutSpreadSeconds = 500e-6;
constexpr double kLongestGapSeconds = 60;

/// Resets the bus, at most once per camera and process. A reset makes all cameras on the bus disappear for a
/// moment, so repeated resets by several cameras would never end.
void reset_bus_once(const Handle& handle, const std::string& label) {
  static std::mutex mutex;
  static std::vector<std::uint64_t> done;
  const std::lock_guard lock(mutex);
  if (std::find(done.begin(), done.end(), handle.camera->guid) != done.end()) return;
  done.push_back(handle.camera->guid);
  check(dc1394_reset_bus(handle.camera.get()), label, "the bus cannot be reset");
  throw CaptureError(fmt::format("camera \"{}\": the bus was reset; the camera is reopened", label));
}

class Dc1394Source final : public Source {
 public:
  explicit Dc1394Source(const Options& options) : silence_s_(options.silence_s) {
    Handle handle = open_camera(options.camera);
    dc1394camera_t* const camera = handle.camera.get();
    label_ = text_of(camera->guid);
    if (options.reset_bus) reset_bus_once(handle, label_);
    video_ = set_up_video(camera, options, label_);
    const char* platform = "";
    dc1394_camera_get_platform_string(camera, &platform);
    stamped_at_start_ = std::string_view(platform) == "juju";

    link_->camera = camera;
    link_->label = label_;
    controls_ = make_controls(link_);
    warnings_ = controls_->queue().open_with(options.controls);
    link_->exposure_s = exposure_s_of(camera).value_or(0);

    const auto frames = static_cast<std::size_t>(options.ring_frames);
    if (needs_unpacking(video_.coding)) {
      const ImageView& layout = video_.layout;
      pool_.emplace(frames,
                    static_cast<std::size_t>(layout.stride_bytes * layout.height + layout.to_low_bits));
    }
    ring_ = std::make_shared<Ring>(std::move(handle), static_cast<std::uint32_t>(frames), label_);
    check(dc1394_video_set_transmission(camera, DC1394_ON), label_, "does not start to send");
    last_frame_ = Clock::now();
    log::info("camera \"{}\": {} {}: {}", label_, camera->vendor != nullptr ? camera->vendor : "",
              camera->model != nullptr ? camera->model : "", video_.summary);
  }

  ~Dc1394Source() override {
    const std::lock_guard lock(link_->mutex);  // waits for a running call of a control
    // Skipped for a dead camera: waiting for its answer would only delay closing.
    if (!lost_) dc1394_video_set_transmission(link_->camera, DC1394_OFF);
    link_->camera = nullptr;
    ring_->close();
  }

  CaptureStatus next(CapturedImage& image, std::string& problem, std::chrono::milliseconds timeout) override {
    const Clock::time_point until = Clock::now() + timeout;
    for (;;) {
      const Ring::Taken taken = ring_->take();
      if (taken.error != DC1394_SUCCESS) return mark_lost(problem, dc1394_error_get_string(taken.error));
      if (taken.frame != nullptr) {
        last_frame_ = Clock::now();
        return hand_over(taken, image, problem);
      }
      const auto left = std::chrono::ceil<std::chrono::milliseconds>(until - Clock::now());
      if (left.count() <= 0) return nothing_came(problem);
      pollfd ready{ring_->fd(), POLLIN, 0};
      if (::poll(&ready, 1, static_cast<int>(left.count())) < 0 && errno != EINTR)
        return mark_lost(problem, "waiting for its images failed");
    }
  }

  std::uint64_t dropped() const noexcept override { return dropped_; }
  std::shared_ptr<Controls> controls() override { return controls_; }
  std::vector<std::string> warnings() const override { return warnings_; }

 private:
  CaptureStatus mark_lost(std::string& problem, std::string_view why) {
    lost_ = true;
    problem = fmt::format("camera \"{}\": no longer delivers: {}", label_, why);
    return CaptureStatus::kLost;
  }

  CaptureStatus nothing_came(std::string& problem) {
    if (Clock::now() - last_frame_ < std::chrono::duration<double>(silence_s_))
      return CaptureStatus::kTimeout;
    const std::lock_guard lock(link_->mutex);
    dc1394switch_t sends = DC1394_OFF;
    if (dc1394_video_get_transmission(link_->camera, &sends) != DC1394_SUCCESS)
      return mark_lost(problem, fmt::format("no image for {:g} s, and it does not answer", silence_s_));
    if (sends == DC1394_ON && waits_for_trigger(link_->camera)) {
      last_frame_ = Clock::now();
      return CaptureStatus::kTimeout;
    }
    problem = fmt::format("camera \"{}\": no image for {:g} s, although it answers ({}){}", label_,
                          silence_s_, video_.summary,
                          sends == DC1394_ON ? "; do card, cables and hubs support this iso_speed?"
                                             : "; it has stopped sending, as after a bus reset");
    return CaptureStatus::kLost;
  }

  CaptureStatus hand_over(const Ring::Taken& taken, CapturedImage& image, std::string& problem) {
    dc1394video_frame_t& frame = *taken.frame;
    count_dropped(frame, taken.queued_at_s);
    const ImageView& layout = video_.layout;
    if (ring_->is_corrupt(&frame)) {
      problem = "packets are missing";
    } else if (frame.color_coding != video_.coding || std::cmp_not_equal(frame.size[0], layout.width) ||
               std::cmp_not_equal(frame.size[1], layout.height) || frame.image_bytes > frame.total_bytes) {
      problem = fmt::format("it has {}x{} pixels instead of {}x{}", frame.size[0], frame.size[1],
                            layout.width, layout.height);
    } else {
      image.times = times_of(frame);
      return pool_ ? unpack_into(frame, image) : lend(frame, image);
    }
    ring_->put_back(&frame);
    return CaptureStatus::kIncomplete;
  }

  CaptureStatus lend(dc1394video_frame_t& frame, CapturedImage& image) {
    ImageView view = video_.layout;
    view.data = frame.image;
    image.image = ring_->lend(&frame, view);
    return CaptureStatus::kImage;
  }

  CaptureStatus unpack_into(dc1394video_frame_t& frame, CapturedImage& image) {
    std::uint8_t* bytes = nullptr;
    image.image = pool_->take(video_.layout, bytes);
    if (bytes != nullptr) unpack(frame, video_.layout, bytes);
    ring_->put_back(&frame);
    if (bytes != nullptr) return CaptureStatus::kImage;
    ++dropped_;  // viewers hold all our buffers
    return CaptureStatus::kTimeout;
  }

  CaptureTimes times_of(const dc1394video_frame_t& frame) const {
    CaptureTimes times;
    if (frame.timestamp == 0) {
      times.t_capture_s = unix_time_s();
      return times;
    }
    // The kernel's FireWire driver stamps an image's first packet, other drivers stamp the arrival of the
    // whole image. Sending begins at the end of the exposure.
    double t_s = static_cast<double>(frame.timestamp) * 1e-6;
    if (!stamped_at_start_) t_s -= frame.packets_per_frame * kCycleSeconds;
    const double exposure_s = link_->exposure_s.load(std::memory_order_relaxed);
    times.t_capture_s = t_s - exposure_s / 2;
    if (exposure_s > 0) times.t_capture_sigma_s = kReadoutSpreadSeconds;
    return times;
  }

  /// Counts lost images, which the library does not count. Images were lost if the image after the last one
  /// was already due when this image's buffer was queued.
  void count_dropped(const dc1394video_frame_t& frame, double queued_at_s) {
    if (frame.timestamp == 0 || video_.interval_s <= 0) return;
    const double t_s = static_cast<double>(frame.timestamp) * 1e-6;
    const double last_s = std::exchange(last_timestamp_s_, t_s);
    if (last_s == 0 || queued_at_s < last_s + video_.interval_s) return;
    // A camera that is silent for this long has already counted as lost. A longer gap therefore means that
    // the host's clock, the source of the time stamps, was set forward.
    if (t_s - last_s > kLongestGapSeconds) return;
    const double missed = std::round((t_s - last_s) / video_.interval_s) - 1;
    if (missed > 0) dropped_ += static_cast<std::uint64_t>(missed);
  }

  const double silence_s_;
  std::string label_;  // the camera's GUID
  Video video_;
  bool stamped_at_start_ = false;
  const std::shared_ptr<Link> link_ = std::make_shared<Link>();
  std::shared_ptr<Controls> controls_;
  std::vector<std::string> warnings_;
  std::shared_ptr<Ring> ring_;
  std::optional<BufferPool> pool_;  // only for images that need conversion
  bool lost_ = false;
  Clock::time_point last_frame_;

  std::uint64_t dropped_ = 0;
  double last_timestamp_s_ = 0;
};

/// "format7_0 yuv422", "640x480_mono8".
std::vector<std::string> formats_of(dc1394camera_t* camera, const std::string& label) {
  std::vector<std::string> out;
  for (const dc1394video_mode_t mode : modes_of(camera, label)) {
    const std::string name(name_in(kModes, mode));
    if (!is_format7(mode)) {
      out.push_back(name);
      continue;
    }
    for (const dc1394color_coding_t coding : codings_of(camera, mode, label))
      out.push_back(name + ' ' + std::string(name_in(kCodings, coding)));
  }
  return out;
}

std::vector<FoundCamera> list_cameras() {
  std::vector<FoundCamera> out;
  const Context context = new_context();
  for (const std::uint64_t guid : find_cameras(context)) {
    const std::string serial = text_of(guid);
    FoundCamera found{
        "IIDC camera " + serial, Json{{"backend", "dc1394"}, {"camera", serial}}, {}, serial, {}};
    const std::unique_ptr<dc1394camera_t, FreeCamera> camera(dc1394_camera_new(context.get(), guid));
    if (camera) {
      found.model = camera->model != nullptr ? camera->model : "";
      found.name = fmt::format("{} {} {}", camera->vendor != nullptr ? camera->vendor : "IIDC camera",
                               found.model, serial);
      try {
        found.formats = formats_of(camera.get(), serial);
      } catch (const CaptureError& error) {
        log::debug("{}", error.what());  // the camera was unplugged meanwhile
      }
    }
    out.push_back(std::move(found));
  }
  return out;
}

Options options_from(const Json& json, const std::string& path) {
  auto options = params_from_json<Options>(json, path);
  if (!options.camera.empty() && !guid_of(options.camera))
    refuse(path + "/camera", options.camera, "a GUID: up to 16 hexadecimal digits");
  return options;
}

}  // namespace

Backend dc1394_backend() {
  return {
      "dc1394",
      "IIDC cameras on IEEE 1394 (FireWire)",
      [](const Json& options, const std::string& path) {
        return params_to_json(options_from(options, path));
      },
      [] { return params_schema<Options>(); },
      [](const Json& options, const SourceContext&) -> std::unique_ptr<Source> {
        return std::make_unique<Dc1394Source>(options_from(options, ""));
      },
      list_cameras,
  };
}

}  // namespace sslv
