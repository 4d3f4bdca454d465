// SPDX-License-Identifier: Apache-2.0
#include "capture/aravis.h"

#include "base/clock.h"
#include "base/log.h"
#include "base/params_json.h"
#include "capture/aravis_controls.h"
#include "capture/aravis_library.h"
#include "capture/camera_clock.h"
#include "capture/pixel_format_choice.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <fstream>
#include <mutex>
#include <thread>
#include <utility>

#include <arpa/inet.h>
#include <fmt/format.h>
#include <sys/socket.h>
#include <unistd.h>

namespace sslv {
namespace {

using Clock = std::chrono::steady_clock;

struct Options {
  std::string camera;
  PixelFormatOrAuto pixel_format;
  int width = 0, height = 0, offset_x = 0, offset_y = 0;
  std::optional<double> frame_rate_hz, exposure_us, gain;
  int buffers = 8;
  int packet_size = 0;
  int socket_buffer_bytes = 4 << 20;
  double silence_s = 2;
  bool resend = true, use_incomplete = false;
  Json controls = Json::object();
  static constexpr auto fields() {
    using O = Options;
    return std::tuple{
        text("camera", &O::camera,
             "the camera's serial number, IP address or Aravis id; empty: the first that is found"),
        choice("pixel_format", &O::pixel_format, kPixelFormatOrAutoChoices,
               "auto: what the camera is set to"),
        number("width", &O::width, 0, 16384, "px",
               "of the part of the sensor that is read; 0: leave as it is"),
        number("height", &O::height, 0, 16384, "px",
               "of the part of the sensor that is read; 0: leave as it is"),
        number("offset_x", &O::offset_x, 0, 16384, "px",
               "left edge of that part, when width or height is set"),
        number("offset_y", &O::offset_y, 0, 16384, "px",
               "upper edge of that part, when width or height is set"),
        number("frame_rate_hz", &O::frame_rate_hz, 0.01, 10000.0, "Hz",
               "switches triggers off; null: leave as it is"),
        number("exposure_us", &O::exposure_us, 1.0, 1e7, "us",
               "switches automatic exposure off; null: leave as it is"),
        number("gain", &O::gain, -100.0, 10000.0, "",
               "in the camera's unit; switches automatic gain off; null: leave as it is"),
        number("buffers", &O::buffers, 3, 200, "", "pictures that may be under way at once"),
        number("packet_size", &O::packet_size, 0, 65535, "bytes",
               "of GigE Vision; 0: the largest that gets through"),
        number("socket_buffer_bytes", &O::socket_buffer_bytes, 65536, 1 << 30, "bytes",
               "of GigE Vision: what the system keeps for us while we are busy"),
        number("silence_s", &O::silence_s, 0.1, 3600.0, "s",
               "a camera that sends nothing for this long is taken for lost"),
        flag("resend", &O::resend, "of GigE Vision: ask again for packets that did not come"),
        flag("use_incomplete", &O::use_incomplete,
             "look at pictures with packets missing too: what is missing shows an older picture"),
        object("controls", &O::controls,
               "what to set at the camera itself, by the camera's own names (GenICam), such as "
               "{\"GainAuto\": \"Off\", \"Gain\": 6}; changed while it runs"),
    };
  }
};

struct NamedFormat {
  PixelFormat format;
  ArvPixelFormat arv;
};
constexpr ArvPixelFormat kArvBgr8 = 0x02180015;  // PFNC; the library has no name for it
constexpr std::array kFormats{
    NamedFormat{PixelFormat::kUyvy, ARV_PIXEL_FORMAT_YUV_422_PACKED},
    NamedFormat{PixelFormat::kYuyv, ARV_PIXEL_FORMAT_YUV_422_YUYV_PACKED},
    NamedFormat{PixelFormat::kRgb24, ARV_PIXEL_FORMAT_RGB_8_PACKED},
    NamedFormat{PixelFormat::kBgr24, kArvBgr8},
    NamedFormat{PixelFormat::kMono8, ARV_PIXEL_FORMAT_MONO_8},
    NamedFormat{PixelFormat::kBayerRg8, ARV_PIXEL_FORMAT_BAYER_RG_8},
    NamedFormat{PixelFormat::kBayerGr8, ARV_PIXEL_FORMAT_BAYER_GR_8},
    NamedFormat{PixelFormat::kBayerGb8, ARV_PIXEL_FORMAT_BAYER_GB_8},
    NamedFormat{PixelFormat::kBayerBg8, ARV_PIXEL_FORMAT_BAYER_BG_8},
};

std::optional<PixelFormat> format_of(ArvPixelFormat arv) {
  for (const NamedFormat& named : kFormats) {
    if (named.arv == arv) return named.format;
  }
  return std::nullopt;
}

ArvPixelFormat arv_format_of(PixelFormat format) {
  return std::find_if(kFormats.begin(), kFormats.end(),
                      [=](const NamedFormat& n) { return n.format == format; })
      ->arv;
}

// ---- finding

struct Device {
  std::string id, physical_id, address, vendor, model, serial, protocol;
};

/// Cameras that answer now. Takes about a second, because the library waits for late answers; several camera
/// threads that start together share one search.
std::vector<Device> find_devices() {
  constexpr std::chrono::seconds kFresh(2);
  static std::mutex mutex;  // also guards the library's list, which is read by index
  static std::vector<Device> devices;
  static std::optional<Clock::time_point> searched;
  const std::lock_guard lock(mutex);
  if (searched && Clock::now() - *searched < kFresh) return devices;
  arv_update_device_list();
  devices.clear();
  for (unsigned i = 0; i < arv_get_n_devices(); ++i) {
    devices.push_back({text_or_empty(arv_get_device_id(i)), text_or_empty(arv_get_device_physical_id(i)),
                       text_or_empty(arv_get_device_address(i)), text_or_empty(arv_get_device_vendor(i)),
                       text_or_empty(arv_get_device_model(i)), text_or_empty(arv_get_device_serial_nbr(i)),
                       text_or_empty(arv_get_device_protocol(i))});
  }
  searched = Clock::now();
  return devices;
}

/// What Aravis opens a device by. With several network cards the address is safer than the id, for which the
/// library may choose the wrong card.
std::string handle_of(const Device& device) {
  return device.protocol == "GigEVision" ? device.address : device.id;
}

std::string resolve(const std::string& camera) {
  in_addr address{};
  if (inet_pton(AF_INET, camera.c_str(), &address) == 1) return camera;
  std::string found;
  for (const Device& device : find_devices()) {
    if (camera.empty() || camera == device.serial || camera == device.id || camera == device.physical_id) {
      return handle_of(device);
    }
    found += fmt::format("{}\"{}\" ({})", found.empty() ? "" : ", ", device.serial, device.id);
  }
  if (found.empty()) throw CaptureError(fmt::format("camera \"{}\": no camera answers", camera));
  throw CaptureError(fmt::format("camera \"{}\": not found; there are {}", camera, found));
}

// ---- setting up

/// Sets features of an open camera; every refusal is a CaptureError that names camera, option and value.
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
    if (now != value) refuse(key, value, fmt::format("the camera made it {}", now));
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

  void region(const Options& options) const {
    if (options.width == 0 && options.height == 0) return;
    // The size that is possible depends on the offset, so that goes first out of the way.
    const bool has_offset = arv_camera_is_region_offset_available(camera_, nullptr);
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
    const std::optional<PixelFormat> ours = format_of(now);
    if (!ours)
      refuse("pixel_format", "auto", fmt::format("the camera is set to 0x{:08x}; it has {}", now, formats()));
    if (wanted && *ours != *wanted) {
      refuse("pixel_format", name_of(*wanted), fmt::format("the camera made it {}", name_of(*ours)));
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
    refuse(key, value, fmt::format("the camera takes {} .. {}", min, max));
  }
  [[noreturn]] void missing(const char* key, const char* feature) const {
    throw CaptureError(
        fmt::format("camera \"{}\": {} cannot be set: the camera has no {}", label_, key, feature));
  }

  /// Those of ours that the camera has.
  std::string formats() const {
    guint count = 0;
    const std::unique_ptr<gint64, void (*)(void*)> available(
        arv_camera_dup_available_pixel_formats(camera_, &count, nullptr), g_free);
    std::string out;
    for (guint i = 0; available && i < count; ++i) {
      const auto format = format_of(static_cast<ArvPixelFormat>(available.get()[i]));
      if (format) out += (out.empty() ? "" : ", ") + std::string(name_of(*format));
    }
    return out.empty() ? "none that is supported" : out;
  }

  ArvCamera* camera_;
  std::string label_;
};

/// Without CAP_NET_RAW pictures pass through a socket whose buffer the system may keep small.
void warn_of_small_socket_buffer(const std::string& label, int wanted_bytes) {
  if (const int packet_socket = ::socket(AF_PACKET, SOCK_DGRAM | SOCK_CLOEXEC, 0); packet_socket >= 0) {
    ::close(packet_socket);
    return;
  }
  std::ifstream file("/proc/sys/net/core/rmem_max");
  if (int allowed_bytes = 0; file >> allowed_bytes && allowed_bytes < wanted_bytes) {
    log::warning(
        "camera \"{}\": pictures may get lost: net.core.rmem_max is {}, socket_buffer_bytes {}; raise the "
        "first or "
        "give the service CAP_NET_RAW",
        label, allowed_bytes, wanted_bytes);
  }
}

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

// ---- pictures

constexpr std::chrono::milliseconds kForeignPackets(100);
/// Nothing but damaged pictures for this long after the opening: foreign packets came all the same.
constexpr std::chrono::milliseconds kFirstPicture(500);
/// The best of what came since the opening.
enum class Beginning { kNothing, kDamaged, kWhole };

/// What the source, the library's threads and the pictures still out share.
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

class AravisSource final : public Source {
 public:
  explicit AravisSource(const Options& options) : options_(options) {
    Failure failure;
    shared_->camera.reset(arv_camera_new(resolve(options_.camera).c_str(), failure));
    label_ = !options_.camera.empty() || !shared_->camera
                 ? options_.camera
                 : text_or_empty(arv_camera_get_device_serial_number(camera(), nullptr));
    if (!shared_->camera)
      throw CaptureError(fmt::format("camera \"{}\": cannot be opened: {}", label_, failure.text()));
    warnings_ = apply_controls(*controls_, options_.controls);
    const std::lock_guard lock(shared_->mutex);
    set_up();
    watch_control();
    start_stream();
  }

  ~AravisSource() override {
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
    return without_buffer;
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
      if (beginning_ == Beginning::kDamaged && now - started_ > kFirstPicture) return bad_beginning(problem);
      if (now - last_buffer_ < std::chrono::duration<double>(options_.silence_s))
        return CaptureStatus::kTimeout;
      problem = fmt::format("camera \"{}\": no picture for {} s", label_, options_.silence_s);
      return CaptureStatus::kLost;
    }
    last_buffer_ = now;
    const ImageView view = view_of(buffer, problem);
    if (view.empty()) {
      arv_stream_push_buffer(stream_.get(), buffer);
      if (beginning_ == Beginning::kWhole) return CaptureStatus::kIncomplete;
      beginning_ = Beginning::kDamaged;
      return now - started_ < kFirstPicture ? CaptureStatus::kIncomplete : bad_beginning(problem);
    }
    beginning_ = Beginning::kWhole;
    image.is_damaged = arv_buffer_get_status(buffer) != ARV_BUFFER_STATUS_SUCCESS;
    {
      const std::lock_guard lock(link_->mutex);
      lease_of(buffer).link = link_;
    }
    image.image = Image(view, nullptr, buffer, &give_back);
    image.times = times_of(buffer);
    image.whole = whole_;
    return CaptureStatus::kImage;
  }

 private:
  CaptureStatus bad_beginning(std::string& problem) const {
    problem = fmt::format("camera \"{}\": none of its first pictures can be read", label_);
    return CaptureStatus::kLost;
  }

  ArvCamera* camera() const { return shared_->camera.get(); }

  /// The camera's own clock says when a picture was taken far more evenly than its arrival does.
  CaptureTimes times_of(ArvBuffer* buffer) {
    // The moment the picture's first packet came, which is about the end of the exposure.
    const guint64 system_ns = arv_buffer_get_system_timestamp(buffer);
    const double now_s = unix_time_s(), steady_s = static_cast<double>(steady_ns()) * 1e-9;
    const double arrival_s = system_ns != 0 ? static_cast<double>(system_ns) * 1e-9 : now_s;
    CaptureTimes out;
    out.t_capture_s = arrival_s;
    if (const guint64 camera_ns = arv_buffer_get_timestamp(buffer); camera_ns != 0) {
      out.t_capture_camera_s = static_cast<double>(camera_ns) * 1e-9;
      const auto estimate = clock_.add(*out.t_capture_camera_s, arrival_s - now_s + steady_s);
      if (estimate.settled) {
        out.t_capture_s = estimate.t_host_s - steady_s + now_s;
        out.t_capture_sigma_s = estimate.sigma_s;
      }
    }
    out.t_capture_s -= shared_->exposure_s / 2;
    return out;
  }

  void set_up() {
    const Setup setup(camera(), label_);
    ArvCamera* camera = this->camera();
    setup.pixel_format(options_.pixel_format);
    setup.region(options_);
    if (options_.exposure_us) {
      if (arv_camera_is_exposure_auto_available(camera, nullptr)) {
        arv_camera_set_exposure_time_auto(camera, ARV_AUTO_OFF, nullptr);
      }
      setup.real("exposure_us", *options_.exposure_us, arv_camera_is_exposure_time_available,
                 arv_camera_get_exposure_time_bounds, arv_camera_set_exposure_time);
    }
    if (options_.gain) {
      if (arv_camera_is_gain_auto_available(camera, nullptr)) {
        arv_camera_set_gain_auto(camera, ARV_AUTO_OFF, nullptr);
      }
      setup.real("gain", *options_.gain, arv_camera_is_gain_available, arv_camera_get_gain_bounds,
                 arv_camera_set_gain);
    }
    if (options_.frame_rate_hz) {
      setup.real("frame_rate_hz", *options_.frame_rate_hz, arv_camera_is_frame_rate_available,
                 arv_camera_get_frame_rate_bounds, arv_camera_set_frame_rate);
    }
    read_exposure(*shared_);
    Failure failure;
    arv_camera_set_acquisition_mode(camera, ARV_ACQUISITION_MODE_CONTINUOUS, failure);
    setup.check(failure, "acquisition mode", "Continuous");
    if (!arv_camera_is_gv_device(camera)) return;
    if (options_.packet_size > 0) {
      arv_camera_gv_set_packet_size(camera, options_.packet_size, failure);
    } else {
      arv_camera_gv_auto_packet_size(camera, failure);
    }
    setup.check(failure, "packet_size", options_.packet_size);
    warn_of_small_socket_buffer(label_, options_.socket_buffer_bytes);
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
    }
    // The packet socket takes in what is meant for others until its filter is set, and such packets' numbers
    // would make the camera's own pictures look late. Without buffers the library throws them away.
    std::this_thread::sleep_for(kForeignPackets);
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

  /// Empty, with the reason, when the buffer holds no sound picture.
  ImageView view_of(ArvBuffer* buffer, std::string& problem) const {
    const ArvBufferStatus status = arv_buffer_get_status(buffer);
    const bool lacks_packets =
        status == ARV_BUFFER_STATUS_TIMEOUT || status == ARV_BUFFER_STATUS_MISSING_PACKETS;
    if (status != ARV_BUFFER_STATUS_SUCCESS && !(lacks_packets && options_.use_incomplete)) {
      problem = text_of(status);
      return {};
    }
    const ArvBufferPayloadType payload = arv_buffer_get_payload_type(buffer);
    if (payload != ARV_BUFFER_PAYLOAD_TYPE_IMAGE && payload != ARV_BUFFER_PAYLOAD_TYPE_EXTENDED_CHUNK_DATA &&
        payload != ARV_BUFFER_PAYLOAD_TYPE_MULTIPART) {
      problem = fmt::format("it holds no picture but payload type {}", static_cast<int>(payload));
      return {};
    }
    const std::optional<PixelFormat> format = format_of(arv_buffer_get_image_pixel_format(buffer));
    const int width = arv_buffer_get_image_width(buffer), height = arv_buffer_get_image_height(buffer);
    if (!format || !is_valid_size(*format, width, height)) {
      problem = fmt::format("{}x{} pixels of format 0x{:08x} are not supported", width, height,
                            arv_buffer_get_image_pixel_format(buffer));
      return {};
    }
    gint x_padding = 0, y_padding = 0;
    arv_buffer_get_image_padding(buffer, &x_padding, &y_padding);
    std::size_t size = 0;
    const auto* data = static_cast<const std::uint8_t*>(arv_buffer_get_image_data(buffer, &size));
    const std::ptrdiff_t stride = std::ptrdiff_t{width} * bytes_per_pixel(*format) + x_padding;
    if (static_cast<std::ptrdiff_t>(size) < stride * height - x_padding) {
      problem = fmt::format("{} bytes came; {}x{} {} needs {}", size, width, height, name_of(*format),
                            stride * height);
      return {};
    }
    return {data, width, height, stride, *format};
  }

  const Options options_;
  std::string label_;  // as the admin calls the camera
  const std::shared_ptr<Link> link_ = std::make_shared<Link>();
  const std::shared_ptr<AravisCamera> shared_ = std::make_shared<AravisCamera>();
  const std::shared_ptr<Controls> controls_ = aravis_controls(shared_);
  Object<ArvStream> stream_;  // goes before the camera
  std::vector<std::string> warnings_;
  CameraClock clock_;
  WholePicture whole_;
  Clock::time_point started_, last_buffer_;
  Beginning beginning_ = Beginning::kNothing;
};

std::vector<FoundCamera> list_cameras() {
  std::vector<FoundCamera> out;
  for (const Device& device : find_devices()) {
    const std::string& known_by = device.serial.empty() ? device.id : device.serial;
    FoundCamera& found = out.emplace_back();
    found.name = fmt::format("{} {} {} ({}, {})", device.vendor, device.model, device.serial, device.protocol,
                             device.address.empty() ? device.physical_id : device.address);
    found.source = {{"backend", "aravis"}, {"camera", known_by}};
    found.model = device.vendor + ' ' + device.model;
    found.serial = device.serial;
  }
  return out;
}

}  // namespace

Backend aravis_backend() {
  return {
      "aravis",
      "GigE Vision and USB3 Vision cameras",
      [](const Json& options, const std::string& path) {
        return params_to_json(params_from_json<Options>(options, path));
      },
      [] { return params_schema<Options>(); },
      [](const Json& options, const SourceContext&) -> std::unique_ptr<Source> {
        return std::make_unique<AravisSource>(params_from_json<Options>(options, ""));
      },
      list_cameras,
  };
}

}  // namespace sslv
