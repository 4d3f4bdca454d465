// SPDX-License-Identifier: Apache-2.0
#include "capture/aravis/aravis.h"

#include "base/background.h"
#include "base/clock.h"
#include "base/log.h"
#include "base/params_json.h"
#include "capture/aravis/aravis_controls.h"
#include "capture/aravis/aravis_devices.h"
#include "capture/aravis/aravis_images.h"
#include "capture/aravis/aravis_library.h"
#include "capture/aravis/aravis_options.h"
#include "capture/aravis/aravis_setup.h"
#include "capture/aravis/gvsp_door.h"
#include "capture/control_queue.h"
#include "capture/picture_times.h"
#include "image/shared_memory.h"

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstring>
#include <memory>
#include <mutex>
#include <stop_token>
#include <string>
#include <string_view>
#include <system_error>
#include <thread>
#include <utility>

#include <fmt/format.h>

namespace sslv {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kForeignPackets(100);
/// Maximum wait for a socket that the library's thread opens late.
constexpr std::chrono::seconds kLateSocket(2);
/// The opening fails if all data received within this time after the start of the stream is foreign.
constexpr std::chrono::milliseconds kFirstPicture(500);

/// Summary of the data received since the stream was started.
struct Arrivals {
  enum class Best { kNothing, kForeign, kOwn };

  Clock::time_point started{}, last_buffer{};
  Best best = Best::kNothing;

  bool only_foreign(Clock::time_point now) const {
    return best == Best::kForeign && now - started > kFirstPicture;
  }
};

/// Shared by the source, the library's threads and the lent images.
struct Link {
  std::mutex mutex;
  ArvStream* stream = nullptr;  // guarded by mutex; null once the source is closed
  std::atomic<bool> control_lost{false};
};

/// User data of each buffer; refers to the link while the buffer is lent. Written with the link's mutex held.
struct Lease {
  std::shared_ptr<Link> link{};
  std::shared_ptr<SharedMemory> memory{};  // the buffer's memory, unless the library allocated it
};

Lease& lease_of(ArvBuffer* buffer) {
  return *static_cast<Lease*>(const_cast<void*>(arv_buffer_get_user_data(buffer)));
}

/// Returns the buffer to the stream, or frees it if the stream has been closed.
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

/// Determines capture times from the times in the camera's buffers.
class BufferTimes {
 public:
  /// Reads the camera's features that affect image times. Requires the camera's mutex. Throws CaptureError,
  /// with the camera's label, if the camera does not answer.
  void prepare(ArvCamera* camera, bool use_chunks, std::string_view label) {
    Failure failure;
    for (const char* feature : {"PtpEnable", "GevIEEE1588"}) {
      const bool is_on = arv_camera_is_feature_available(camera, feature, failure) != FALSE &&
                         arv_camera_get_boolean(camera, feature, failure) != FALSE && !failure.failed();
      failure.require_answer(label);
      has_ptp_ = has_ptp_ || is_on;
    }
    if (!use_chunks) return;
    chunks_.reset(arv_camera_create_chunk_parser(camera));
    // The camera's clock counts nanoseconds, unless an older GigE camera reports another frequency.
    const gint64 per_s =
        arv_camera_is_feature_available(camera, "GevTimestampTickFrequency", failure) != FALSE
            ? arv_camera_get_integer(camera, "GevTimestampTickFrequency", failure)
            : 0;
    failure.require_answer(label);
    if (!failure.failed() && per_s > 0) ticks_per_s_ = static_cast<double>(per_s);
  }

  /// `exposure_s`: as last read from the camera. `is_valid`: the buffer may be searched for chunks.
  CaptureTimes of(ArvBuffer* buffer, double exposure_s, bool is_valid) {
    PictureStamps stamps;
    stamps.exposure_s = exposure_s;
    stamps.has_ptp = has_ptp_;
    // Arrival of the image's first packet.
    const guint64 system_ns = arv_buffer_get_system_timestamp(buffer);
    stamps.arrival_s = system_ns != 0 ? static_cast<double>(system_ns) * 1e-9 : unix_time_s();
    const guint64 camera_ns = arv_buffer_get_timestamp(buffer);
    // A damaged image may lack the packet with its time; the buffer then holds an older time.
    const bool is_damaged = arv_buffer_get_status(buffer) != ARV_BUFFER_STATUS_SUCCESS;
    if (camera_ns != 0 && !is_damaged) stamps.camera_s = static_cast<double>(camera_ns) * 1e-9;
    if (chunks_ && is_valid && arv_buffer_has_chunks(buffer)) read_chunks(buffer, stamps);
    return times_.of(stamps, unix_time_s(), static_cast<double>(steady_ns()) * 1e-9);
  }

 private:
  void read_chunks(ArvBuffer* buffer, PictureStamps& stamps) {
    Failure failure;
    const double exposure_us =
        arv_chunk_parser_get_float_value(chunks_.get(), buffer, "ChunkExposureTime", failure);
    if (!failure.failed()) stamps.exposure_s = exposure_us * 1e-6;
    const gint64 ticks = arv_chunk_parser_get_integer_value(chunks_.get(), buffer, "ChunkTimestamp", failure);
    if (!failure.failed()) stamps.camera_s = static_cast<double>(ticks) / ticks_per_s_;
  }

  PictureTimes times_;
  bool has_ptp_ = false;
  Object<ArvChunkParser> chunks_;  // null without chunks
  double ticks_per_s_ = 1e9;       // frequency of ChunkTimestamp
};

/// Reads the exposure time regularly while it is automatic or unknown. Uses its own thread, because the
/// camera may answer slowly. Asks only while images arrive, because waiting for the answer of a dead camera
/// would delay closing.
class ExposureFollower {
 public:
  ExposureFollower(AravisCamera& camera, const Link& link) : camera_(camera), link_(link) {}

  void start() {
    thread_ = std::jthread([this](const std::stop_token& stop) { run(stop); });
  }
  /// Waits for a pending answer.
  void stop() { thread_ = {}; }

  /// Call when an image has arrived.
  void note_image() { image_ns_.store(steady_ns(), std::memory_order_relaxed); }

 private:
  void run(const std::stop_token& stop) {
    become_background_thread("exposure");
    constexpr std::chrono::seconds kEvery(2);
    std::mutex idle;
    std::condition_variable_any alarm;
    std::unique_lock idle_lock(idle);
    while (!alarm.wait_for(idle_lock, stop, kEvery, [&] { return stop.stop_requested(); })) {
      const auto silence = std::chrono::nanoseconds(steady_ns() - image_ns_.load(std::memory_order_relaxed));
      if (!camera_.may_exposure_change || silence > kEvery || link_.control_lost) continue;
      const std::lock_guard lock(camera_.mutex);
      read_exposure(camera_);
    }
  }

  AravisCamera& camera_;
  const Link& link_;
  std::atomic<std::int64_t> image_ns_{0};  // steady_ns() of the newest image
  std::jthread thread_;
};

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
    warnings_ = controls_->queue().open_with(options_.controls);
    {
      const std::lock_guard lock(shared_->mutex);
      set_up_aravis(camera(), options_, label_, warnings_);
      read_exposure(*shared_);
      times_.prepare(camera(), options_.chunks, label_);
      watch_control();
      start_stream();
    }
    exposure_.start();
  }

  ~AravisSource() override {
    exposure_.stop();
    {
      const std::lock_guard lock(shared_->mutex);
      // Skipped for a dead camera: waiting for its answer would only delay closing.
      if (!link_->control_lost) arv_camera_stop_acquisition(camera(), nullptr);
      shared_->is_closed = true;
    }
    {
      const std::lock_guard lock(link_->mutex);
      link_->stream = nullptr;
    }
    stream_.reset();
    const std::lock_guard lock(shared_->mutex);
    shared_->camera.reset();  // controls that are still held must not keep the camera open
  }

  std::shared_ptr<Controls> controls() override { return controls_; }
  std::vector<std::string> warnings() const override { return warnings_; }

  std::uint64_t dropped() const noexcept override {
    guint64 completed = 0, failed = 0, without_buffer = 0;
    arv_stream_get_statistics(stream_.get(), &completed, &failed, &without_buffer);
    return without_buffer + unpacker_.dropped();
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
      if (arrivals_.only_foreign(now)) return bad_beginning(problem);
      if (now - arrivals_.last_buffer < std::chrono::duration<double>(options_.silence_s))
        return CaptureStatus::kTimeout;
      problem = fmt::format("camera \"{}\": no image for {} s", label_, options_.silence_s);
      return CaptureStatus::kLost;
    }
    arrivals_.last_buffer = now;
    const SentPicture sent = reader_.picture_in(buffer, problem);
    if (sent.format == nullptr) {
      // A buffer that received only foreign packets does not even contain the start of an image.
      const bool is_foreign = arv_buffer_get_status(buffer) == ARV_BUFFER_STATUS_CLEARED;
      arv_stream_push_buffer(stream_.get(), buffer);
      if (arrivals_.best != Arrivals::Best::kOwn)
        arrivals_.best = is_foreign ? Arrivals::Best::kForeign : Arrivals::Best::kOwn;
      return arrivals_.only_foreign(now) ? bad_beginning(problem) : CaptureStatus::kIncomplete;
    }
    arrivals_.best = Arrivals::Best::kOwn;
    image.is_damaged = arv_buffer_get_status(buffer) != ARV_BUFFER_STATUS_SUCCESS;
    exposure_.note_image();
    image.times = times_.of(buffer, shared_->exposure_s, reader_.is_within(buffer));
    image.whole = reader_.whole();
    if (sent.format->is_copied()) {
      const bool is_unpacked = unpacker_.unpack(sent, image.image);
      arv_stream_push_buffer(stream_.get(), buffer);
      return is_unpacked ? CaptureStatus::kImage : CaptureStatus::kTimeout;
    }
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

  /// The library reports the loss of the camera on its own thread, possibly during closing. So the handler
  /// uses only the link, which it keeps alive.
  void watch_control() {
    const auto on_lost =
        +[](ArvDevice*, gpointer link) { (*static_cast<std::shared_ptr<Link>*>(link))->control_lost = true; };
    const auto forget = +[](gpointer link, GClosure*) { delete static_cast<std::shared_ptr<Link>*>(link); };
    g_signal_connect_data(arv_camera_get_device(camera()), "control-lost", G_CALLBACK(on_lost),
                          new std::shared_ptr<Link>(link_), forget, static_cast<GConnectFlags>(0));
  }

  static std::size_t in_pages(std::size_t bytes) {
    constexpr std::size_t kPage = 4096;
    return (bytes + kPage - 1) / kPage * kPage;
  }

  /// Limits for the packets that reach the library. Throws CaptureError if no packet can be within the
  /// limits.
  GvspBounds bounds(std::size_t payload) const {
    const auto number_of = [](GSocketAddress* address) {
      GInetAddress* inet = g_inet_socket_address_get_address(G_INET_SOCKET_ADDRESS(address));
      std::uint32_t number = 0;
      if (g_inet_address_get_family(inet) == G_SOCKET_FAMILY_IPV4)
        std::memcpy(&number, g_inet_address_to_bytes(inet), sizeof number);
      return GUINT32_FROM_BE(number);
    };
    Failure failure;
    const guint packet_bytes = arv_camera_gv_get_packet_size(camera(), failure);
    if (failure.failed())
      throw CaptureError(fmt::format("camera \"{}\": no packet size: {}", label_, failure.text()));
    if (packet_bytes <= kGvspHeaderBytes) {
      throw CaptureError(fmt::format("camera \"{}\": its packet size of {} bytes leaves no space for data",
                                     label_, packet_bytes));
    }
    ArvGvDevice* device = ARV_GV_DEVICE(arv_camera_get_device(camera()));
    return {number_of(arv_gv_device_get_device_address(device)),
            number_of(arv_gv_device_get_interface_address(device)),
            arv_gv_stream_get_port(ARV_GV_STREAM(stream_.get())), payload, packet_bytes};
  }

  /// Lets only packets that fit into the buffers reach the library. Until the filters are attached, the
  /// library's packet socket also receives packets for other programs, whose numbers would make the camera's
  /// own images look late. The library discards these packets, because it has no buffers yet.
  void guard(std::size_t payload) const {
    const GvspBounds known = bounds(payload);
    const int wanted = ARAVIS_HAS_PACKET_SOCKET != 0 && may_open_packet_sockets() ? 2 : 1;
    const Clock::time_point give_up = Clock::now() + kLateSocket;
    int guarded = 0;
    do {
      guarded = guard_gvsp_sockets(known);
      std::this_thread::sleep_for(kForeignPackets);
    } while (guarded < wanted && Clock::now() < give_up);
    if (guarded >= wanted) return;
    log::warning(
        "camera \"{}\": only {} of its {} sockets filter their packets, so a forged packet could crash the "
        "service",
        label_, guarded, wanted);
  }

  /// Memory for all buffers of the stream if other processes may read images, otherwise null.
  std::shared_ptr<SharedMemory> shared_buffers(std::size_t payload) const {
    if (!new_images_are_shared()) return nullptr;
    try {
      return std::make_shared<SharedMemory>(static_cast<std::size_t>(options_.buffers) * in_pages(payload));
    } catch (const std::system_error&) {
      return nullptr;  // images are then copied for other processes
    }
  }

  void start_stream() {
    Failure failure;
    reader_.read_region(camera(), label_);
    const guint payload = arv_camera_get_payload(camera(), failure);
    if (!failure.failed()) stream_.reset(arv_camera_create_stream(camera(), nullptr, nullptr, failure));
    if (!stream_) throw CaptureError(fmt::format("camera \"{}\": no stream: {}", label_, failure.text()));
    if (ARV_IS_GV_STREAM(stream_.get())) {
      g_object_set(stream_.get(), "socket-buffer", ARV_GV_STREAM_SOCKET_BUFFER_FIXED, "socket-buffer-size",
                   options_.socket_buffer_bytes, "packet-resend",
                   options_.resend ? ARV_GV_STREAM_PACKET_RESEND_ALWAYS : ARV_GV_STREAM_PACKET_RESEND_NEVER,
                   nullptr);
      guard(payload);
    }
    reader_.set_buffer_bytes(payload);
    const auto memory = shared_buffers(payload);
    for (int i = 0; i < options_.buffers; ++i) {
      const auto destroy = [](gpointer lease) { delete static_cast<Lease*>(lease); };
      void* const bytes = memory ? memory->data() + static_cast<std::size_t>(i) * in_pages(payload) : nullptr;
      ArvBuffer* buffer = arv_buffer_new_full(payload, bytes, new Lease{{}, memory}, destroy);
      // Parts of an image that never arrive must not show the previous contents of this memory.
      std::memset(const_cast<void*>(arv_buffer_get_data(buffer, nullptr)), 0, payload);
      arv_stream_push_buffer(stream_.get(), buffer);
    }
    link_->stream = stream_.get();
    arv_camera_start_acquisition(camera(), failure);
    if (failure.failed())
      throw CaptureError(fmt::format("camera \"{}\": does not start: {}", label_, failure.text()));
    shared_->is_streaming = true;
    arrivals_.started = arrivals_.last_buffer = Clock::now();
  }

  const AravisOptions options_;
  std::string label_;  // the admin's name of the camera
  const std::shared_ptr<Link> link_ = std::make_shared<Link>();
  const std::shared_ptr<AravisCamera> shared_ = std::make_shared<AravisCamera>();
  const std::shared_ptr<Controls> controls_ = aravis_controls(shared_);
  Object<ArvStream> stream_;  // destroyed before the camera
  std::vector<std::string> warnings_;
  BufferTimes times_;
  AravisBufferReader reader_{options_.use_incomplete};
  AravisUnpacker unpacker_{options_.buffers};
  Arrivals arrivals_;
  ExposureFollower exposure_{*shared_, *link_};
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
