// SPDX-License-Identifier: Apache-2.0
#include "capture/aravis/aravis.h"

#include "base/background.h"
#include "base/clock.h"
#include "base/params_json.h"
#include "capture/aravis/aravis_controls.h"
#include "capture/aravis/aravis_devices.h"
#include "capture/aravis/aravis_formats.h"
#include "capture/aravis/aravis_library.h"
#include "capture/aravis/aravis_options.h"
#include "capture/aravis/aravis_setup.h"
#include "capture/buffer_pool.h"
#include "capture/picture_times.h"

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <mutex>
#include <stop_token>
#include <thread>
#include <utility>

#include <fmt/format.h>

namespace sslv {
namespace {

using Clock = std::chrono::steady_clock;

std::string_view text_of(ArvBufferStatus status) {
  switch (status) {
    case ARV_BUFFER_STATUS_TIMEOUT: return "its last packets did not come";
    case ARV_BUFFER_STATUS_MISSING_PACKETS: return "packets are missing";
    case ARV_BUFFER_STATUS_WRONG_PACKET_ID: return "a packet has a wrong number";
    case ARV_BUFFER_STATUS_SIZE_MISMATCH: return "more bytes came than announced";
    case ARV_BUFFER_STATUS_FILLING: return "it was still being filled";
    case ARV_BUFFER_STATUS_ABORTED: return "it was aborted";
    default: return "it was not filled";
  }
}

// ---- images

constexpr std::chrono::milliseconds kForeignPackets(100);
/// Nothing of its own for this long after the opening although something came: foreign packets, all the same.
constexpr std::chrono::milliseconds kFirstPicture(500);
/// The best of what came since the opening.
enum class Beginning { kNothing, kForeign, kOwn };

/// What the source, the library's threads and the images still out share.
struct Link {
  std::mutex mutex;
  ArvStream* stream = nullptr;  // guarded; null once the source is closed
  std::atomic<bool> control_lost{false};
};

/// Hangs on each buffer; holds the link while the buffer is out. Written under the link's mutex.
struct Lease {
  std::shared_ptr<Link> link{};
};

Lease& lease_of(ArvBuffer* buffer) {
  return *static_cast<Lease*>(const_cast<void*>(arv_buffer_get_user_data(buffer)));
}

/// Gives the buffer back to the stream, or frees it when that has been closed.
void give_back(void*, void* lent) noexcept {
  auto* buffer = static_cast<ArvBuffer*>(lent);
  const std::shared_ptr<Link> link = lease_of(buffer).link;
  const std::lock_guard lock(link->mutex);
  lease_of(buffer).link.reset();
  if (link->stream != nullptr) {
    arv_stream_push_buffer(link->stream, buffer);
  } else {
    g_object_unref(buffer);
  }
}

/// A sound image in the library's buffer.
struct SentPicture {
  const AravisFormat* format = nullptr;
  const std::uint8_t* data = nullptr;
  int width = 0, height = 0;
  std::size_t padding_bytes = 0;  // at the end of each row
};

/// Rows without padding follow each other bit by bit.
std::size_t bytes_of(const AravisFormat& format, const SentPicture& sent) {
  const auto width = static_cast<std::size_t>(sent.width), height = static_cast<std::size_t>(sent.height);
  if (sent.padding_bytes == 0) return sent_bytes(format, width * height);
  return (sent_bytes(format, width) + sent.padding_bytes) * height - sent.padding_bytes;
}

/// The view of an image that needs no unpacking.
ImageView view_of(const SentPicture& sent) {
  const auto row_bytes = sent_bytes(*sent.format, static_cast<std::size_t>(sent.width));
  return {sent.data, sent.width, sent.height, static_cast<std::ptrdiff_t>(row_bytes + sent.padding_bytes),
          sent.format->format};
}

void unpack_pixels(const SentPicture& sent, const ImageView& layout, std::uint8_t* to) {
  const auto width = static_cast<std::size_t>(sent.width), height = static_cast<std::size_t>(sent.height);
  const auto unpack = [&](const std::uint8_t* from, std::size_t pixels, std::uint8_t* row) {
    if (sent.format->unpack != nullptr) return sent.format->unpack(from, pixels, row);
    sent.format->split(from, pixels, row, row + layout.to_low_bits);
  };
  if (sent.padding_bytes == 0) return unpack(sent.data, width * height, to);
  const std::size_t from_bytes = sent_bytes(*sent.format, width) + sent.padding_bytes;
  const auto to_bytes = static_cast<std::size_t>(layout.stride_bytes);
  for (std::size_t y = 0; y < height; ++y) unpack(sent.data + y * from_bytes, width, to + y * to_bytes);
}

class AravisSource final : public Source {
 public:
  explicit AravisSource(const AravisOptions& options) : options_(options) {
    Failure failure;
    const AravisHandle handle = resolve_aravis_camera(options_.camera);
    shared_->camera.reset(arv_camera_new(handle.name.c_str(), failure));
    label_ = !options_.camera.empty() || !shared_->camera
                 ? options_.camera
                 : text_or_empty(arv_camera_get_device_serial_number(camera(), nullptr));
    if (!shared_->camera)
      throw CaptureError(fmt::format("camera \"{}\": cannot be opened: {}", label_, failure.text()));
    check_aravis_serial(camera(), handle);
    warnings_ = apply_controls(*controls_, options_.controls);
    {
      const std::lock_guard lock(shared_->mutex);
      set_up_aravis(camera(), options_, label_, warnings_);
      prepare_times();
      watch_control();
      start_stream();
    }
    exposure_follower_ = std::jthread([this](const std::stop_token& stop) { follow_exposure(stop); });
  }

  ~AravisSource() override {
    exposure_follower_ = {};  // waits for an answer that is under way
    {
      const std::lock_guard lock(shared_->mutex);
      // A dead camera would only make us wait for its answers.
      if (!link_->control_lost) arv_camera_stop_acquisition(camera(), nullptr);
      shared_->is_closed = true;
    }
    {
      const std::lock_guard lock(link_->mutex);
      link_->stream = nullptr;
    }
    stream_.reset();
    const std::lock_guard lock(shared_->mutex);
    shared_->camera.reset();  // controls that somebody still holds must not keep it
  }

  std::shared_ptr<Controls> controls() override { return controls_; }
  std::vector<std::string> warnings() const override { return warnings_; }

  std::uint64_t dropped() const noexcept override {
    guint64 completed = 0, failed = 0, without_buffer = 0;
    arv_stream_get_statistics(stream_.get(), &completed, &failed, &without_buffer);
    return without_buffer + dropped_;
  }

  std::optional<PacketCounts> packets() const noexcept override {
    if (!ARV_IS_GV_STREAM(stream_.get())) return std::nullopt;
    guint64 resent = 0, missing = 0;
    arv_gv_stream_get_statistics(ARV_GV_STREAM(stream_.get()), &resent, &missing);
    return PacketCounts{missing, resent};
  }

  CaptureStatus next(CapturedImage& image, std::string& problem, std::chrono::milliseconds timeout) override {
    const auto wait_us = std::chrono::duration_cast<std::chrono::microseconds>(timeout).count();
    ArvBuffer* buffer = arv_stream_timeout_pop_buffer(stream_.get(), static_cast<guint64>(wait_us));
    if (link_->control_lost) {
      if (buffer != nullptr) g_object_unref(buffer);
      problem = fmt::format("camera \"{}\": no longer answers", label_);
      return CaptureStatus::kLost;
    }
    const Clock::time_point now = Clock::now();
    if (buffer == nullptr) {
      if (beginning_ == Beginning::kForeign && now - started_ > kFirstPicture) return bad_beginning(problem);
      if (now - last_buffer_ < std::chrono::duration<double>(options_.silence_s))
        return CaptureStatus::kTimeout;
      problem = fmt::format("camera \"{}\": no image for {} s", label_, options_.silence_s);
      return CaptureStatus::kLost;
    }
    last_buffer_ = now;
    const SentPicture sent = picture_in(buffer, problem);
    if (sent.format == nullptr) {
      // Of foreign packets not even an image's beginning is understood.
      const bool is_foreign = arv_buffer_get_status(buffer) == ARV_BUFFER_STATUS_CLEARED;
      arv_stream_push_buffer(stream_.get(), buffer);
      if (beginning_ != Beginning::kOwn) beginning_ = is_foreign ? Beginning::kForeign : Beginning::kOwn;
      const bool is_bad = beginning_ == Beginning::kForeign && now - started_ > kFirstPicture;
      return is_bad ? bad_beginning(problem) : CaptureStatus::kIncomplete;
    }
    beginning_ = Beginning::kOwn;
    image.is_damaged = arv_buffer_get_status(buffer) != ARV_BUFFER_STATUS_SUCCESS;
    image.times = times_of(buffer);
    image.whole = whole_;
    if (sent.format->is_copied()) return unpack(sent, buffer, image);
    {
      const std::lock_guard lock(link_->mutex);
      lease_of(buffer).link = link_;
    }
    image.image = Image(view_of(sent), nullptr, buffer, &give_back);
    return CaptureStatus::kImage;
  }

 private:
  CaptureStatus bad_beginning(std::string& problem) const {
    problem = fmt::format("camera \"{}\": none of its first images can be read", label_);
    return CaptureStatus::kLost;
  }

  ArvCamera* camera() const { return shared_->camera.get(); }

  CaptureTimes times_of(ArvBuffer* buffer) {
    picture_ns_.store(steady_ns(), std::memory_order_relaxed);
    PictureStamps stamps;
    stamps.exposure_s = shared_->exposure_s;
    stamps.has_ptp = has_ptp_;
    // The moment the image's first packet came.
    const guint64 system_ns = arv_buffer_get_system_timestamp(buffer);
    stamps.arrival_s = system_ns != 0 ? static_cast<double>(system_ns) * 1e-9 : unix_time_s();
    const guint64 camera_ns = arv_buffer_get_timestamp(buffer);
    // A damaged image may lack the packet that has its time; the buffer then holds an older one.
    const bool is_damaged = arv_buffer_get_status(buffer) != ARV_BUFFER_STATUS_SUCCESS;
    if (camera_ns != 0 && !is_damaged) stamps.camera_s = static_cast<double>(camera_ns) * 1e-9;
    if (chunks_ && arv_buffer_has_chunks(buffer)) read_chunks(buffer, stamps);
    return times_.of(stamps, unix_time_s(), static_cast<double>(steady_ns()) * 1e-9);
  }

  void read_chunks(ArvBuffer* buffer, PictureStamps& stamps) {
    Failure failure;
    const double exposure_us =
        arv_chunk_parser_get_float_value(chunks_.get(), buffer, "ChunkExposureTime", failure);
    if (!failure.failed()) stamps.exposure_s = exposure_us * 1e-6;
    const gint64 ticks = arv_chunk_parser_get_integer_value(chunks_.get(), buffer, "ChunkTimestamp", failure);
    if (!failure.failed()) stamps.camera_s = static_cast<double>(ticks) / ticks_per_s_;
  }

  /// An automatic exposure changes by itself. The camera answers when it likes, so a thread of its own asks,
  /// and only while images come: a dead camera would keep it, and the closing, waiting.
  void follow_exposure(const std::stop_token& stop) {
    become_background_thread("exposure");
    constexpr std::chrono::seconds kEvery(2);
    std::mutex idle;
    std::condition_variable_any alarm;
    std::unique_lock idle_lock(idle);
    while (!alarm.wait_for(idle_lock, stop, kEvery, [&] { return stop.stop_requested(); })) {
      const auto silence =
          std::chrono::nanoseconds(steady_ns() - picture_ns_.load(std::memory_order_relaxed));
      if (!shared_->is_exposure_auto || silence > kEvery || link_->control_lost) continue;
      const std::lock_guard lock(shared_->mutex);
      read_exposure(*shared_);
    }
  }

  /// What the times of images depend on.
  void prepare_times() {
    read_exposure(*shared_);
    Failure failure;
    for (const char* feature : {"PtpEnable", "GevIEEE1588"}) {
      const bool is_on = arv_camera_is_feature_available(camera(), feature, nullptr) != FALSE &&
                         arv_camera_get_boolean(camera(), feature, failure) != FALSE && !failure.failed();
      has_ptp_ = has_ptp_ || is_on;
    }
    if (!options_.chunks) return;
    chunks_.reset(arv_camera_create_chunk_parser(camera()));
    // In nanoseconds, unless an older GigE camera says otherwise.
    if (arv_camera_is_feature_available(camera(), "GevTimestampTickFrequency", nullptr) == FALSE) return;
    const gint64 per_s = arv_camera_get_integer(camera(), "GevTimestampTickFrequency", failure);
    if (!failure.failed() && per_s > 0) ticks_per_s_ = static_cast<double>(per_s);
  }

  /// The library reports the loss from a thread of its own, possibly while we are closing: the handler works
  /// on the link only and holds it.
  void watch_control() {
    const auto on_lost =
        +[](ArvDevice*, gpointer link) { (*static_cast<std::shared_ptr<Link>*>(link))->control_lost = true; };
    const auto forget = +[](gpointer link, GClosure*) { delete static_cast<std::shared_ptr<Link>*>(link); };
    g_signal_connect_data(arv_camera_get_device(camera()), "control-lost", G_CALLBACK(on_lost),
                          new std::shared_ptr<Link>(link_), forget, static_cast<GConnectFlags>(0));
  }

  /// Of the sensor, when only a part of it is read. Cameras that do not tell are taken for whole.
  void find_whole() {
    Failure failure;
    gint sensor_width = 0, sensor_height = 0, x = 0, y = 0, width = 0, height = 0, bin_x = 1, bin_y = 1;
    arv_camera_get_sensor_size(camera(), &sensor_width, &sensor_height, failure);
    if (failure.failed()) return;
    arv_camera_get_region(camera(), &x, &y, &width, &height, failure);
    if (failure.failed()) return;
    arv_camera_get_binning(camera(), &bin_x, &bin_y, nullptr);
    const WholePicture sensor{sensor_width / std::max(1, bin_x), sensor_height / std::max(1, bin_y), x, y};
    const bool is_part = width < sensor.width || height < sensor.height;
    const bool is_within = x + width <= sensor.width && y + height <= sensor.height;
    if (is_part && is_within) whole_ = sensor;
  }

  void start_stream() {
    Failure failure;
    find_whole();
    const guint payload = arv_camera_get_payload(camera(), failure);
    if (!failure.failed()) stream_.reset(arv_camera_create_stream(camera(), nullptr, nullptr, failure));
    if (!stream_) throw CaptureError(fmt::format("camera \"{}\": no stream: {}", label_, failure.text()));
    if (ARV_IS_GV_STREAM(stream_.get())) {
      g_object_set(stream_.get(), "socket-buffer", ARV_GV_STREAM_SOCKET_BUFFER_FIXED, "socket-buffer-size",
                   options_.socket_buffer_bytes, "packet-resend",
                   options_.resend ? ARV_GV_STREAM_PACKET_RESEND_ALWAYS : ARV_GV_STREAM_PACKET_RESEND_NEVER,
                   nullptr);
      // The packet socket takes in what is meant for others until its filter is set, and such packets'
      // numbers would make the camera's own images look late. Without buffers the library throws them away.
      std::this_thread::sleep_for(kForeignPackets);
    }
    for (int i = 0; i < options_.buffers; ++i) {
      const auto destroy = [](gpointer lease) { delete static_cast<Lease*>(lease); };
      arv_stream_push_buffer(stream_.get(), arv_buffer_new_full(payload, nullptr, new Lease, destroy));
    }
    link_->stream = stream_.get();
    arv_camera_start_acquisition(camera(), failure);
    if (failure.failed())
      throw CaptureError(fmt::format("camera \"{}\": does not start: {}", label_, failure.text()));
    shared_->is_streaming = true;
    started_ = last_buffer_ = Clock::now();
  }

  /// The library does not say how a damaged image lies in its buffer: as the last whole one did.
  SentPicture damaged_picture_in(ArvBuffer* buffer) const {
    SentPicture sent = last_whole_;
    std::size_t size = 0;
    sent.data = static_cast<const std::uint8_t*>(arv_buffer_get_data(buffer, &size)) + last_whole_offset_;
    return sent;
  }

  /// No format, with the reason, when the buffer holds no sound image.
  SentPicture picture_in(ArvBuffer* buffer, std::string& problem) {
    const ArvBufferStatus status = arv_buffer_get_status(buffer);
    const bool lacks_packets =
        status == ARV_BUFFER_STATUS_TIMEOUT || status == ARV_BUFFER_STATUS_MISSING_PACKETS;
    if (status != ARV_BUFFER_STATUS_SUCCESS) {
      problem = text_of(status);
      return lacks_packets && options_.use_incomplete ? damaged_picture_in(buffer) : SentPicture{};
    }
    const ArvBufferPayloadType payload = arv_buffer_get_payload_type(buffer);
    if (payload != ARV_BUFFER_PAYLOAD_TYPE_IMAGE && payload != ARV_BUFFER_PAYLOAD_TYPE_EXTENDED_CHUNK_DATA &&
        payload != ARV_BUFFER_PAYLOAD_TYPE_MULTIPART) {
      problem = fmt::format("it holds no image but payload type {}", static_cast<int>(payload));
      return {};
    }
    SentPicture sent;
    sent.width = arv_buffer_get_image_width(buffer);
    sent.height = arv_buffer_get_image_height(buffer);
    const AravisFormat* format = find_aravis_format(arv_buffer_get_image_pixel_format(buffer));
    if (format == nullptr || !is_valid_size(format->format, sent.width, sent.height)) {
      problem = fmt::format("{}x{} pixels of format 0x{:08x} are not supported", sent.width, sent.height,
                            arv_buffer_get_image_pixel_format(buffer));
      return {};
    }
    gint x_padding = 0, y_padding = 0;
    arv_buffer_get_image_padding(buffer, &x_padding, &y_padding);
    sent.padding_bytes = static_cast<std::size_t>(x_padding);
    std::size_t size = 0;
    sent.data = static_cast<const std::uint8_t*>(arv_buffer_get_image_data(buffer, &size));
    const std::size_t needed = bytes_of(*format, sent);
    if (size < needed) {
      problem = fmt::format("{} bytes came; {}x{} of format 0x{:08x} needs {}", size, sent.width, sent.height,
                            format->arv, needed);
      return {};
    }
    sent.format = format;
    last_whole_ = sent;
    last_whole_offset_ = sent.data - static_cast<const std::uint8_t*>(arv_buffer_get_data(buffer, &size));
    return sent;
  }

  /// Into a buffer of ours, so that the camera has its own back at once.
  CaptureStatus unpack(const SentPicture& sent, ArvBuffer* buffer, CapturedImage& image) {
    ImageView layout{nullptr, sent.width, sent.height, 0, sent.format->format};
    layout.stride_bytes = std::ptrdiff_t{sent.width} * bytes_per_pixel(layout.format);
    const std::ptrdiff_t plane_bytes = layout.stride_bytes * sent.height;
    if (sent.format->split != nullptr) layout.to_low_bits = plane_bytes;
    const auto picture_bytes = static_cast<std::size_t>(plane_bytes + layout.to_low_bits);
    if (picture_bytes > pool_bytes_) {
      pool_.emplace(static_cast<std::size_t>(options_.buffers), picture_bytes);
      pool_bytes_ = picture_bytes;
    }
    std::uint8_t* to = nullptr;
    image.image = pool_->take(layout, to);
    if (to != nullptr) unpack_pixels(sent, layout, to);
    arv_stream_push_buffer(stream_.get(), buffer);
    if (to != nullptr) return CaptureStatus::kImage;
    ++dropped_;  // viewers hold all our buffers
    return CaptureStatus::kTimeout;
  }

  const AravisOptions options_;
  std::string label_;  // as the admin calls the camera
  const std::shared_ptr<Link> link_ = std::make_shared<Link>();
  const std::shared_ptr<AravisCamera> shared_ = std::make_shared<AravisCamera>();
  const std::shared_ptr<Controls> controls_ = aravis_controls(shared_);
  Object<ArvStream> stream_;  // goes before the camera
  std::vector<std::string> warnings_;
  PictureTimes times_;
  bool has_ptp_ = false;
  Object<ArvChunkParser> chunks_;            // null: images carry none
  double ticks_per_s_ = 1e9;                 // of ChunkTimestamp
  std::atomic<std::int64_t> picture_ns_{0};  // steady_ns() of the newest image
  std::optional<BufferPool> pool_;           // of images that are unpacked
  std::size_t pool_bytes_ = 0;               // of each
  std::uint64_t dropped_ = 0;
  WholePicture whole_;
  SentPicture last_whole_;                // its data is not used
  std::ptrdiff_t last_whole_offset_ = 0;  // of the image in its buffer
  Clock::time_point started_{}, last_buffer_{};
  Beginning beginning_ = Beginning::kNothing;
  std::jthread exposure_follower_;
};

}  // namespace

Backend aravis_backend() {
  return {
      "aravis",
      "GigE Vision and USB3 Vision cameras",
      [](const Json& options, const std::string& path) {
        return params_to_json(params_from_json<AravisOptions>(options, path));
      },
      [] { return params_schema<AravisOptions>(); },
      [](const Json& options, const SourceContext&) -> std::unique_ptr<Source> {
        return std::make_unique<AravisSource>(params_from_json<AravisOptions>(options, ""));
      },
      list_aravis_cameras,
  };
}

}  // namespace sslv
