// SPDX-License-Identifier: Apache-2.0
#include "support/fake_dc1394.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <memory>
#include <mutex>

#include <poll.h>
#include <sys/eventfd.h>
#include <sys/mman.h>
#include <unistd.h>

namespace sslv::fake_iidc {
namespace {

struct Handle;

struct Device {
  Camera camera;
  bool gone = false;
  int channel = -1, pictures = 0;
};

struct Event {
  std::uint64_t timestamp_us = 0;
  bool corrupt = false;
};

/// One capture_setup(). The vectors are reserved, so that nothing is allocated while frames arrive.
struct Capture {
  int fd = -1;
  unsigned char* memory = nullptr;
  std::size_t bytes = 0;
  std::vector<dc1394video_frame_t> frames;
  std::vector<bool> corrupt;
  std::vector<std::uint32_t> queued;  // in the order in which the card fills them
  std::vector<Event> events;          // filled, not yet fetched
  std::uint32_t next = 0;             // ring index that is handed out next
  int channel = -1, bandwidth = 0;
};

struct Handle : dc1394camera_t {
  std::shared_ptr<Device> device;
  std::unique_ptr<Capture> capture;
};

struct Bus {
  std::mutex mutex;
  std::vector<std::shared_ptr<Device>> devices;
  std::vector<Handle*> handles;
  Counts counts;
  int next_channel = 0;
};

Bus& bus() {
  static Bus one;
  return one;
}

constexpr int kBandwidthUnits = 4915;

Handle& handle_of(dc1394camera_t* camera) {
  return *static_cast<Handle*>(camera);
}

std::shared_ptr<Device> device_with(std::uint64_t guid) {
  for (const auto& device : bus().devices) {
    if (device->camera.guid == guid) return device;
  }
  return nullptr;
}

bool is_format7(dc1394video_mode_t mode) {
  return mode >= DC1394_VIDEO_MODE_FORMAT7_MIN && mode <= DC1394_VIDEO_MODE_FORMAT7_MAX;
}

struct Native {
  dc1394video_mode_t mode;
  std::uint32_t width, height;
  dc1394color_coding_t coding;
};
constexpr std::array kNative{
    Native{DC1394_VIDEO_MODE_160x120_YUV444, 160, 120, DC1394_COLOR_CODING_YUV444},
    Native{DC1394_VIDEO_MODE_320x240_YUV422, 320, 240, DC1394_COLOR_CODING_YUV422},
    Native{DC1394_VIDEO_MODE_640x480_YUV411, 640, 480, DC1394_COLOR_CODING_YUV411},
    Native{DC1394_VIDEO_MODE_640x480_YUV422, 640, 480, DC1394_COLOR_CODING_YUV422},
    Native{DC1394_VIDEO_MODE_640x480_RGB8, 640, 480, DC1394_COLOR_CODING_RGB8},
    Native{DC1394_VIDEO_MODE_640x480_MONO8, 640, 480, DC1394_COLOR_CODING_MONO8},
    Native{DC1394_VIDEO_MODE_640x480_MONO16, 640, 480, DC1394_COLOR_CODING_MONO16},
    Native{DC1394_VIDEO_MODE_800x600_YUV422, 800, 600, DC1394_COLOR_CODING_YUV422},
    Native{DC1394_VIDEO_MODE_800x600_RGB8, 800, 600, DC1394_COLOR_CODING_RGB8},
    Native{DC1394_VIDEO_MODE_800x600_MONO8, 800, 600, DC1394_COLOR_CODING_MONO8},
    Native{DC1394_VIDEO_MODE_1024x768_YUV422, 1024, 768, DC1394_COLOR_CODING_YUV422},
    Native{DC1394_VIDEO_MODE_1024x768_RGB8, 1024, 768, DC1394_COLOR_CODING_RGB8},
    Native{DC1394_VIDEO_MODE_1024x768_MONO8, 1024, 768, DC1394_COLOR_CODING_MONO8},
    Native{DC1394_VIDEO_MODE_800x600_MONO16, 800, 600, DC1394_COLOR_CODING_MONO16},
    Native{DC1394_VIDEO_MODE_1024x768_MONO16, 1024, 768, DC1394_COLOR_CODING_MONO16},
    Native{DC1394_VIDEO_MODE_1280x960_YUV422, 1280, 960, DC1394_COLOR_CODING_YUV422},
    Native{DC1394_VIDEO_MODE_1280x960_RGB8, 1280, 960, DC1394_COLOR_CODING_RGB8},
    Native{DC1394_VIDEO_MODE_1280x960_MONO8, 1280, 960, DC1394_COLOR_CODING_MONO8},
    Native{DC1394_VIDEO_MODE_1600x1200_YUV422, 1600, 1200, DC1394_COLOR_CODING_YUV422},
    Native{DC1394_VIDEO_MODE_1600x1200_RGB8, 1600, 1200, DC1394_COLOR_CODING_RGB8},
    Native{DC1394_VIDEO_MODE_1600x1200_MONO8, 1600, 1200, DC1394_COLOR_CODING_MONO8},
    Native{DC1394_VIDEO_MODE_1280x960_MONO16, 1280, 960, DC1394_COLOR_CODING_MONO16},
    Native{DC1394_VIDEO_MODE_1600x1200_MONO16, 1600, 1200, DC1394_COLOR_CODING_MONO16},
};
const Native* native(dc1394video_mode_t mode) {
  const auto found =
      std::find_if(kNative.begin(), kNative.end(), [=](const Native& n) { return n.mode == mode; });
  return found == kNative.end() ? nullptr : &*found;
}

std::uint32_t bits_of(dc1394color_coding_t coding) {
  switch (coding) {
    case DC1394_COLOR_CODING_MONO8:
    case DC1394_COLOR_CODING_RAW8: return 8;
    case DC1394_COLOR_CODING_YUV411: return 12;
    case DC1394_COLOR_CODING_YUV444:
    case DC1394_COLOR_CODING_RGB8: return 24;
    case DC1394_COLOR_CODING_RGB16:
    case DC1394_COLOR_CODING_RGB16S: return 48;
    default: return 16;
  }
}

float hz(dc1394framerate_t rate) {
  return 1.875F * static_cast<float>(1 << (rate - DC1394_FRAMERATE_MIN));
}

struct Layout {
  std::uint32_t left = 0, top = 0, width = 0, height = 0, packet = 0, packets = 0;
  dc1394color_coding_t coding = DC1394_COLOR_CODING_MONO8;
  dc1394color_filter_t filter = DC1394_COLOR_FILTER_RGGB;
  std::uint32_t image_bytes() const { return width * height * bits_of(coding) / 8; }
};

Layout layout_of(const Camera& camera) {
  Layout out;
  if (is_format7(camera.mode)) {
    const Format7& f = camera.format7.at(camera.mode);
    out = {f.left,   f.top, f.width,  f.height,
           f.packet, 0,     f.coding, f.filter.value_or(DC1394_COLOR_FILTER_RGGB)};
  } else {
    const Native& n = *native(camera.mode);
    out = {0, 0, n.width, n.height, 0, 0, n.coding, DC1394_COLOR_FILTER_RGGB};
    out.packet = static_cast<std::uint32_t>(std::ceil(out.image_bytes() * double{hz(camera.rate)} / 7200));
  }
  if (out.packet > 0) out.packets = (out.image_bytes() + out.packet - 1) / out.packet;
  return out;
}

int reserved_bandwidth() {
  int sum = 0;
  for (const Handle* handle : bus().handles) {
    if (handle->capture) sum += handle->capture->bandwidth;
  }
  return sum;
}

// ---- painting

std::uint8_t raw_sample(Rgb c, dc1394color_filter_t filter, std::uint32_t x, std::uint32_t y) {
  const std::uint8_t square[4][4] = {{c.r, c.g, c.g, c.b},   // RGGB
                                     {c.g, c.b, c.r, c.g},   // GBRG
                                     {c.g, c.r, c.b, c.g},   // GRBG
                                     {c.b, c.g, c.g, c.r}};  // BGGR
  return square[filter - DC1394_COLOR_FILTER_MIN][y % 2 * 2 + x % 2];
}

void paint(const Layout& layout, std::uint32_t depth, int number, unsigned char* to) {
  const auto put = [&](unsigned value) { *to++ = static_cast<unsigned char>(value); };
  for (std::uint32_t y = 0; y < layout.height; ++y) {
    const auto colour = [&](std::uint32_t x) {
      return colour_at(static_cast<int>(x + layout.left), static_cast<int>(y + layout.top), number);
    };
    const auto yuv = [&](std::uint32_t x) { return to_yuv(colour(x)); };
    for (std::uint32_t x = 0; x < layout.width; ++x) {
      // The next two bits below the upper 8 are the inverse of the first two.
      const auto put_deep = [&](unsigned value) {
        const unsigned deep = (value << 8 | (~value & 0xC0U)) >> (16 - depth);
        put(deep >> 8), put(deep);
      };
      const auto raw = [&] { return raw_sample(colour(x), layout.filter, x, y); };
      switch (layout.coding) {
        case DC1394_COLOR_CODING_YUV411:
          if (x % 4 != 0) break;
          put(yuv(x).u), put(yuv(x).y), put(yuv(x + 1).y), put(yuv(x).v), put(yuv(x + 2).y),
              put(yuv(x + 3).y);
          break;
        case DC1394_COLOR_CODING_YUV422:
          if (x % 2 != 0) break;
          put(yuv(x).u), put(yuv(x).y), put(yuv(x).v), put(yuv(x + 1).y);
          break;
        case DC1394_COLOR_CODING_YUV444: put(yuv(x).u), put(yuv(x).y), put(yuv(x).v); break;
        case DC1394_COLOR_CODING_RGB8: put(colour(x).r), put(colour(x).g), put(colour(x).b); break;
        case DC1394_COLOR_CODING_RAW8: put(raw()); break;
        case DC1394_COLOR_CODING_RAW16: put_deep(raw()); break;
        case DC1394_COLOR_CODING_MONO16: put_deep(yuv(x).y); break;
        default: put(yuv(x).y);
      }
    }
  }
}

std::uint64_t now_us() {
  return static_cast<std::uint64_t>(std::chrono::duration_cast<std::chrono::microseconds>(
                                        std::chrono::system_clock::now().time_since_epoch())
                                        .count());
}

void wake(const Capture& capture) {
  [[maybe_unused]] const int failed = ::eventfd_write(capture.fd, 1);
}

int send_locked(Device& device, const Send& how) {
  if (device.gone || !device.camera.sending) return -1;
  const int number = device.pictures++;
  const Layout layout = layout_of(device.camera);
  for (Handle* handle : bus().handles) {
    Capture* capture = handle->capture.get();
    if (!capture || handle->device.get() != &device || capture->channel != device.channel) continue;
    if (capture->queued.empty()) {
      ++bus().counts.overflows;
      continue;
    }
    const std::uint32_t id = capture->queued.front();
    capture->queued.erase(capture->queued.begin());
    paint(layout, device.camera.data_depth, number, capture->frames[id].image);
    capture->events.push_back({how.timestamp_us != 0 ? how.timestamp_us : now_us(), how.corrupt});
    wake(*capture);
  }
  return number;
}

}  // namespace

Camera league_camera(std::uint64_t guid) {
  Camera camera;
  camera.guid = guid;
  camera.vendor = "Fake Vision";
  camera.model = "F-046";
  camera.can_1394b = true;
  camera.memory_channels = 2;
  camera.data_depth = 12;
  camera.native[DC1394_VIDEO_MODE_640x480_YUV422] = {DC1394_FRAMERATE_15, DC1394_FRAMERATE_30,
                                                     DC1394_FRAMERATE_60};
  camera.native[DC1394_VIDEO_MODE_640x480_MONO8] = {DC1394_FRAMERATE_30, DC1394_FRAMERATE_60};
  Format7 whole;
  whole.max_width = 780;
  whole.max_height = 580;
  whole.codings = {DC1394_COLOR_CODING_MONO8,  DC1394_COLOR_CODING_YUV411, DC1394_COLOR_CODING_YUV422,
                   DC1394_COLOR_CODING_YUV444, DC1394_COLOR_CODING_RGB8,   DC1394_COLOR_CODING_MONO16,
                   DC1394_COLOR_CODING_RAW8,   DC1394_COLOR_CODING_RAW16,  DC1394_COLOR_CODING_RGB16};
  whole.max_packet = 8192;
  whole.recommended_packet = 6880;
  whole.filter = DC1394_COLOR_FILTER_GRBG;
  camera.format7[DC1394_VIDEO_MODE_FORMAT7_0] = whole;
  Format7 binned = whole;
  binned.max_width = 388;
  binned.max_height = 290;
  binned.codings = {DC1394_COLOR_CODING_MONO8};
  camera.format7[DC1394_VIDEO_MODE_FORMAT7_1] = binned;

  const std::vector<dc1394feature_mode_t> automatic{DC1394_FEATURE_MODE_MANUAL, DC1394_FEATURE_MODE_AUTO,
                                                    DC1394_FEATURE_MODE_ONE_PUSH_AUTO};
  Feature shutter;
  shutter.min = 1;
  shutter.max = 4095;
  shutter.values[0] = 200;
  shutter.modes = automatic;
  shutter.absolute = true;
  shutter.absolute_min = 1e-5F;
  shutter.absolute_max = 0.1F;
  shutter.absolute_value = 0.004F;
  camera.features[DC1394_FEATURE_SHUTTER] = shutter;
  Feature gain;
  gain.max = 680;
  gain.modes = automatic;
  gain.mode = DC1394_FEATURE_MODE_AUTO;
  camera.features[DC1394_FEATURE_GAIN] = gain;
  camera.features[DC1394_FEATURE_BRIGHTNESS].values[0] = 16;
  camera.features[DC1394_FEATURE_EXPOSURE] = {};
  camera.features[DC1394_FEATURE_GAMMA].switchable = true;
  Feature balance;
  balance.modes = automatic;
  balance.values = {284, 230, 0};
  camera.features[DC1394_FEATURE_WHITE_BALANCE] = balance;
  camera.features[DC1394_FEATURE_WHITE_SHADING].max = 255;
  Feature temperature;
  temperature.values = {100, 312, 0};
  camera.features[DC1394_FEATURE_TEMPERATURE] = temperature;
  Feature trigger;
  trigger.switchable = true;
  trigger.on = false;
  trigger.trigger_modes = {DC1394_TRIGGER_MODE_0, DC1394_TRIGGER_MODE_1, DC1394_TRIGGER_MODE_15};
  trigger.sources = {DC1394_TRIGGER_SOURCE_0, DC1394_TRIGGER_SOURCE_SOFTWARE};
  trigger.polarity_capable = true;
  camera.features[DC1394_FEATURE_TRIGGER] = trigger;
  Feature delay;
  delay.switchable = true;
  delay.on = false;
  camera.features[DC1394_FEATURE_TRIGGER_DELAY] = delay;
  Feature rate;
  rate.absolute = true;
  rate.absolute_min = 1;
  rate.absolute_max = 62;
  rate.absolute_value = 30;
  camera.features[DC1394_FEATURE_FRAME_RATE] = rate;
  return camera;
}

void clear() {
  const std::lock_guard lock(bus().mutex);
  for (const auto& device : bus().devices) device->gone = true;
  bus().devices.clear();
  bus().counts.overflows = bus().counts.bus_resets = 0;
}

void plug_in(const Camera& camera) {
  const std::lock_guard lock(bus().mutex);
  auto device = std::make_shared<Device>();
  device->camera = camera;
  for (auto& [mode, format] : device->camera.format7) {
    format.width = format.max_width;
    format.height = format.max_height;
    format.packet = format.recommended_packet;
  }
  bus().devices.push_back(std::move(device));
}

void unplug(std::uint64_t guid) {
  const std::lock_guard lock(bus().mutex);
  device_with(guid)->gone = true;
  std::erase_if(bus().devices, [&](const auto& device) { return device->camera.guid == guid; });
  for (Handle* handle : bus().handles) {
    if (handle->guid == guid && handle->capture) {
      handle->capture->bandwidth = 0;  // released by the bus reset
      wake(*handle->capture);
    }
  }
}

void stop_by_bus_reset(std::uint64_t guid) {
  const std::lock_guard lock(bus().mutex);
  device_with(guid)->camera.sending = false;
}

int send(std::uint64_t guid, const Send& how) {
  const std::lock_guard lock(bus().mutex);
  const auto device = device_with(guid);
  return device ? send_locked(*device, how) : -1;
}

Rgb colour_at(int x, int y, int number) {
  const unsigned hash = static_cast<unsigned>(x / 8) * 73U + static_cast<unsigned>(y / 8) * 151U +
                        static_cast<unsigned>(number) * 211U;
  const auto level = [&](unsigned shift) { return static_cast<std::uint8_t>((hash >> shift) % 8 * 32 + 16); };
  return {level(0), level(2), level(4)};
}

Camera state_of(std::uint64_t guid) {
  const std::lock_guard lock(bus().mutex);
  const auto device = device_with(guid);
  return device ? device->camera : Camera{};
}

Counts counts() {
  const std::lock_guard lock(bus().mutex);
  return bus().counts;
}

}  // namespace sslv::fake_iidc

// ---- the library's functions

using namespace sslv::fake_iidc;

struct __dc1394_t {};  // NOLINT: the library's name

namespace {

/// Held during each call on a camera; error() returns whether the camera still exists.
class Call {
 public:
  explicit Call(dc1394camera_t* camera) : handle(handle_of(camera)), lock_(bus().mutex) {}
  bool gone() const { return handle.device->gone; }
  Camera& camera() const { return handle.device->camera; }

  Handle& handle;

 private:
  const std::lock_guard<std::mutex> lock_;
};

Format7* format7_in(const Call& call, dc1394video_mode_t mode) {
  const auto found = call.camera().format7.find(mode);
  return found == call.camera().format7.end() ? nullptr : &found->second;
}

/// Reads or changes a camera with `use`, which returns an error.
template <class Use>
dc1394error_t with_camera(dc1394camera_t* camera, Use use) {
  const Call call(camera);
  if (call.gone()) return DC1394_FAILURE;
  return use(call.camera());
}
template <class Use>
dc1394error_t with_format7(dc1394camera_t* camera, dc1394video_mode_t mode, Use use) {
  const Call call(camera);
  if (call.gone()) return DC1394_FAILURE;
  if (!is_format7(mode)) return DC1394_INVALID_VIDEO_MODE;
  Format7* format = format7_in(call, mode);
  return format == nullptr ? DC1394_FAILURE : use(*format);
}
template <class Use>
dc1394error_t with_feature(dc1394camera_t* camera, dc1394feature_t id, Use use) {
  return with_camera(camera, [&](Camera& c) {
    const auto found = c.features.find(id);
    return found == c.features.end() ? DC1394_FAILURE : use(found->second);
  });
}
template <class Use>
dc1394error_t set_feature(dc1394camera_t* camera, dc1394feature_t id, Use use) {
  return with_feature(camera, id, [&](Feature& feature) {
    if (feature.refusal != DC1394_SUCCESS) return feature.refusal;
    use(feature);
    return DC1394_SUCCESS;
  });
}

dc1394bool_t boolean(bool value) {
  return value ? DC1394_TRUE : DC1394_FALSE;
}
dc1394switch_t switched(bool value) {
  return value ? DC1394_ON : DC1394_OFF;
}

}  // namespace

extern "C" {

dc1394_t* dc1394_new() {
  return new __dc1394_t;
}
void dc1394_free(dc1394_t* context) {
  delete context;
}

dc1394error_t dc1394_log_register_handler(dc1394log_t, void (*)(dc1394log_t, const char*, void*), void*) {
  return DC1394_SUCCESS;
}
const char* dc1394_error_get_string(dc1394error_t error) {
  switch (error) {
    case DC1394_SUCCESS: return "Success";
    case DC1394_FAILURE: return "Generic failure";
    case DC1394_REQ_VALUE_OUTSIDE_RANGE: return "Requested value is out of range";
    default: return "Some other failure";
  }
}

dc1394error_t dc1394_camera_enumerate(dc1394_t*, dc1394camera_list_t** list) {
  const std::lock_guard lock(bus().mutex);
  *list = new dc1394camera_list_t;
  (*list)->num = static_cast<std::uint32_t>(bus().devices.size());
  (*list)->ids = new dc1394camera_id_t[bus().devices.size()];
  for (std::size_t i = 0; i < bus().devices.size(); ++i) (*list)->ids[i] = {0, bus().devices[i]->camera.guid};
  return DC1394_SUCCESS;
}
void dc1394_camera_free_list(dc1394camera_list_t* list) {
  delete[] list->ids;
  delete list;
}

dc1394camera_t* dc1394_camera_new(dc1394_t*, std::uint64_t guid) {
  const std::lock_guard lock(bus().mutex);
  const auto device = device_with(guid);
  if (!device) return nullptr;
  auto* handle = new Handle();
  handle->device = device;
  handle->guid = guid;
  handle->vendor = device->camera.vendor.data();
  handle->model = device->camera.model.data();
  handle->bmode_capable = boolean(device->camera.can_1394b);
  handle->max_mem_channel = device->camera.memory_channels;
  bus().handles.push_back(handle);
  ++bus().counts.handles;
  return handle;
}
void dc1394_camera_free(dc1394camera_t* camera) {
  const std::lock_guard lock(bus().mutex);
  std::erase(bus().handles, &handle_of(camera));
  --bus().counts.handles;
  delete &handle_of(camera);
}
dc1394error_t dc1394_camera_get_platform_string(dc1394camera_t* camera, const char** platform) {
  return with_camera(camera, [&](const Camera& c) { return *platform = c.platform, DC1394_SUCCESS; });
}
dc1394error_t dc1394_reset_bus(dc1394camera_t* camera) {
  return with_camera(camera, [&](Camera&) { return ++bus().counts.bus_resets, DC1394_SUCCESS; });
}

// ---- video

dc1394error_t dc1394_video_get_supported_modes(dc1394camera_t* camera, dc1394video_modes_t* modes) {
  return with_camera(camera, [&](const Camera& c) {
    modes->num = 0;
    for (const auto& [mode, rates] : c.native) modes->modes[modes->num++] = mode;
    for (const auto& [mode, format] : c.format7) modes->modes[modes->num++] = mode;
    return DC1394_SUCCESS;
  });
}
dc1394error_t dc1394_video_get_supported_framerates(dc1394camera_t* camera, dc1394video_mode_t mode,
                                                    dc1394framerates_t* rates) {
  return with_camera(camera, [&](const Camera& c) {
    const auto found = c.native.find(mode);
    if (found == c.native.end()) return DC1394_INVALID_VIDEO_MODE;
    rates->num = 0;
    for (const dc1394framerate_t rate : found->second) rates->framerates[rates->num++] = rate;
    return DC1394_SUCCESS;
  });
}
dc1394error_t dc1394_framerate_as_float(dc1394framerate_t rate, float* value) {
  return *value = hz(rate), DC1394_SUCCESS;
}
dc1394error_t dc1394_video_get_framerate(dc1394camera_t* camera, dc1394framerate_t* rate) {
  return with_camera(camera, [&](const Camera& c) { return *rate = c.rate, DC1394_SUCCESS; });
}
dc1394error_t dc1394_video_set_framerate(dc1394camera_t* camera, dc1394framerate_t rate) {
  return with_camera(camera, [&](Camera& c) { return c.rate = rate, DC1394_SUCCESS; });
}
dc1394error_t dc1394_video_get_mode(dc1394camera_t* camera, dc1394video_mode_t* mode) {
  return with_camera(camera, [&](const Camera& c) { return *mode = c.mode, DC1394_SUCCESS; });
}
dc1394error_t dc1394_video_set_mode(dc1394camera_t* camera, dc1394video_mode_t mode) {
  return with_camera(camera, [&](Camera& c) {
    if (c.native.contains(mode) || c.format7.contains(mode)) c.mode = mode;  // otherwise ignored
    return DC1394_SUCCESS;
  });
}
dc1394error_t dc1394_video_set_operation_mode(dc1394camera_t* camera, dc1394operation_mode_t mode) {
  return with_camera(camera, [&](Camera& c) {
    if (mode == DC1394_OPERATION_MODE_1394B && !c.can_1394b) return DC1394_FUNCTION_NOT_SUPPORTED;
    return c.operation = mode, DC1394_SUCCESS;
  });
}
dc1394error_t dc1394_video_set_iso_speed(dc1394camera_t* camera, dc1394speed_t speed) {
  return with_camera(camera, [&](Camera& c) {
    if (speed > DC1394_ISO_SPEED_400 && c.operation != DC1394_OPERATION_MODE_1394B)
      return DC1394_INVALID_ISO_SPEED;
    return c.speed = speed, DC1394_SUCCESS;
  });
}
dc1394error_t dc1394_video_set_transmission(dc1394camera_t* camera, dc1394switch_t on) {
  return with_camera(camera, [&](Camera& c) { return c.sending = on == DC1394_ON, DC1394_SUCCESS; });
}
dc1394error_t dc1394_video_get_transmission(dc1394camera_t* camera, dc1394switch_t* on) {
  return with_camera(camera, [&](const Camera& c) { return *on = switched(c.sending), DC1394_SUCCESS; });
}
dc1394error_t dc1394_get_image_size_from_video_mode(dc1394camera_t* camera, dc1394video_mode_t mode,
                                                    std::uint32_t* width, std::uint32_t* height) {
  if (is_format7(mode)) return dc1394_format7_get_image_size(camera, mode, width, height);
  const Native* found = native(mode);
  if (found == nullptr) return DC1394_FAILURE;
  *width = found->width;
  *height = found->height;
  return DC1394_SUCCESS;
}
dc1394error_t dc1394_get_color_coding_from_video_mode(dc1394camera_t* camera, dc1394video_mode_t mode,
                                                      dc1394color_coding_t* coding) {
  if (is_format7(mode))
    return with_format7(camera, mode, [&](const Format7& f) { return *coding = f.coding, DC1394_SUCCESS; });
  const Native* found = native(mode);
  if (found == nullptr) return DC1394_INVALID_VIDEO_MODE;
  return *coding = found->coding, DC1394_SUCCESS;
}
dc1394error_t dc1394_get_color_coding_bit_size(dc1394color_coding_t coding, std::uint32_t* bits) {
  return *bits = bits_of(coding), DC1394_SUCCESS;
}

// ---- Format7

dc1394error_t dc1394_format7_get_max_image_size(dc1394camera_t* camera, dc1394video_mode_t mode,
                                                std::uint32_t* width, std::uint32_t* height) {
  return with_format7(camera, mode, [&](const Format7& f) {
    return *width = f.max_width, *height = f.max_height, DC1394_SUCCESS;
  });
}
dc1394error_t dc1394_format7_get_unit_size(dc1394camera_t* camera, dc1394video_mode_t mode,
                                           std::uint32_t* width, std::uint32_t* height) {
  return with_format7(camera, mode, [&](const Format7& f) {
    return *width = f.unit_width, *height = f.unit_height, DC1394_SUCCESS;
  });
}
dc1394error_t dc1394_format7_get_unit_position(dc1394camera_t* camera, dc1394video_mode_t mode,
                                               std::uint32_t* x, std::uint32_t* y) {
  return with_format7(camera, mode,
                      [&](const Format7& f) { return *x = f.unit_x, *y = f.unit_y, DC1394_SUCCESS; });
}
dc1394error_t dc1394_format7_get_image_size(dc1394camera_t* camera, dc1394video_mode_t mode,
                                            std::uint32_t* width, std::uint32_t* height) {
  return with_format7(camera, mode,
                      [&](const Format7& f) { return *width = f.width, *height = f.height, DC1394_SUCCESS; });
}
dc1394error_t dc1394_format7_get_color_codings(dc1394camera_t* camera, dc1394video_mode_t mode,
                                               dc1394color_codings_t* codings) {
  return with_format7(camera, mode, [&](const Format7& f) {
    codings->num = 0;
    for (const dc1394color_coding_t coding : f.codings) codings->codings[codings->num++] = coding;
    return DC1394_SUCCESS;
  });
}
dc1394error_t dc1394_format7_set_color_coding(dc1394camera_t* camera, dc1394video_mode_t mode,
                                              dc1394color_coding_t coding) {
  return with_format7(camera, mode, [&](Format7& f) {
    if (std::find(f.codings.begin(), f.codings.end(), coding) == f.codings.end()) return DC1394_FAILURE;
    return f.coding = coding, DC1394_SUCCESS;
  });
}
dc1394error_t dc1394_format7_get_color_filter(dc1394camera_t* camera, dc1394video_mode_t mode,
                                              dc1394color_filter_t* filter) {
  return with_format7(camera, mode, [&](const Format7& f) {
    if (!f.filter) return DC1394_FUNCTION_NOT_SUPPORTED;
    return *filter = *f.filter, DC1394_SUCCESS;
  });
}
dc1394error_t dc1394_format7_get_packet_parameters(dc1394camera_t* camera, dc1394video_mode_t mode,
                                                   std::uint32_t* unit, std::uint32_t* most) {
  return with_format7(camera, mode, [&](const Format7& f) {
    return *unit = f.unit_packet, *most = f.max_packet, DC1394_SUCCESS;
  });
}
dc1394error_t dc1394_format7_get_packet_size(dc1394camera_t* camera, dc1394video_mode_t mode,
                                             std::uint32_t* bytes) {
  return with_format7(camera, mode, [&](const Format7& f) { return *bytes = f.packet, DC1394_SUCCESS; });
}
dc1394error_t dc1394_format7_set_packet_size(dc1394camera_t* camera, dc1394video_mode_t mode,
                                             std::uint32_t bytes) {
  return with_format7(camera, mode, [&](Format7& f) { return f.packet = bytes, DC1394_SUCCESS; });
}
dc1394error_t dc1394_format7_get_packets_per_frame(dc1394camera_t* camera, dc1394video_mode_t mode,
                                                   std::uint32_t* packets) {
  return with_format7(camera, mode, [&](const Format7& f) {
    *packets = (f.width * f.height * bits_of(f.coding) / 8 + f.packet - 1) / f.packet;
    return DC1394_SUCCESS;
  });
}
dc1394error_t dc1394_format7_get_frame_interval(dc1394camera_t*, dc1394video_mode_t, float*) {
  return DC1394_FUNCTION_NOT_SUPPORTED;
}
dc1394error_t dc1394_format7_set_roi(dc1394camera_t* camera, dc1394video_mode_t mode,
                                     dc1394color_coding_t coding, std::int32_t packet, std::int32_t left,
                                     std::int32_t top, std::int32_t width, std::int32_t height) {
  return with_format7(camera, mode, [&](Format7& f) {
    const auto x = static_cast<std::uint32_t>(left), y = static_cast<std::uint32_t>(top);
    const auto w = static_cast<std::uint32_t>(width), h = static_cast<std::uint32_t>(height);
    if (x % f.unit_x != 0 || y % f.unit_y != 0 || w % f.unit_width != 0 || h % f.unit_height != 0 || w == 0 ||
        h == 0 || x + w > f.max_width || y + h > f.max_height) {
      return DC1394_FORMAT7_ERROR_FLAG_1;
    }
    f.coding = coding;
    f.left = x, f.top = y, f.width = w, f.height = h;
    f.packet = packet == DC1394_USE_RECOMMENDED ? f.recommended_packet : static_cast<std::uint32_t>(packet);
    return DC1394_SUCCESS;
  });
}

// ---- capture

dc1394error_t dc1394_capture_setup(dc1394camera_t* camera, std::uint32_t buffers, std::uint32_t flags) {
  const Call call(camera);
  if (call.gone()) return DC1394_FAILURE;
  if (call.handle.capture) return DC1394_CAPTURE_IS_RUNNING;
  const Layout layout = layout_of(call.camera());
  if (layout.packet == 0) return DC1394_FAILURE;
  auto capture = std::make_unique<Capture>();
  if ((flags & (DC1394_CAPTURE_FLAGS_DEFAULT | DC1394_CAPTURE_FLAGS_BANDWIDTH_ALLOC)) != 0) {
    capture->bandwidth =
        static_cast<int>(layout.packet / 4 * (16U >> static_cast<unsigned>(call.camera().speed)));
    if (reserved_bandwidth() + capture->bandwidth > kBandwidthUnits) return DC1394_NO_ISO_CHANNEL;
  }
  capture->channel = call.handle.device->channel = bus().next_channel++;
  capture->fd = ::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK | EFD_SEMAPHORE);
  const std::size_t frame_bytes = std::size_t{layout.packet} * layout.packets;
  capture->bytes = frame_bytes * buffers;
  capture->memory = static_cast<unsigned char*>(
      ::mmap(nullptr, capture->bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0));
  capture->frames.resize(buffers);
  capture->corrupt.resize(buffers);
  capture->queued.reserve(buffers);
  capture->events.reserve(buffers);
  for (std::uint32_t i = 0; i < buffers; ++i) {
    dc1394video_frame_t& frame = capture->frames[i];
    frame.image = capture->memory + i * frame_bytes;
    frame.size[0] = layout.width;
    frame.size[1] = layout.height;
    frame.position[0] = layout.left;
    frame.position[1] = layout.top;
    frame.color_coding = layout.coding;
    frame.color_filter = layout.filter;
    frame.yuv_byte_order = DC1394_BYTE_ORDER_UYVY;
    frame.data_depth = call.camera().data_depth;
    frame.stride = layout.width * bits_of(layout.coding) / 8;
    frame.video_mode = call.camera().mode;
    frame.image_bytes = layout.image_bytes();
    frame.total_bytes = frame_bytes;
    frame.padding_bytes = static_cast<std::uint32_t>(frame_bytes) - frame.image_bytes;
    frame.packet_size = layout.packet;
    frame.packets_per_frame = layout.packets;
    frame.camera = camera;
    frame.id = i;
    capture->queued.push_back(i);
  }
  call.handle.capture = std::move(capture);
  ++bus().counts.captures;
  return DC1394_SUCCESS;
}
dc1394error_t dc1394_capture_stop(dc1394camera_t* camera) {
  const Call call(camera);
  if (!call.handle.capture) return DC1394_CAPTURE_IS_NOT_SET;
  --bus().counts.captures;
  const std::unique_ptr<Capture> capture = std::move(call.handle.capture);
  if (call.gone()) return DC1394_IOCTL_FAILURE;  // leaks memory and file, like the library
  ::munmap(capture->memory, capture->bytes);
  ::close(capture->fd);
  return DC1394_SUCCESS;
}
int dc1394_capture_get_fileno(dc1394camera_t* camera) {
  const Call call(camera);
  return call.handle.capture ? call.handle.capture->fd : -1;
}
dc1394error_t dc1394_capture_dequeue(dc1394camera_t* camera, dc1394capture_policy_t policy,
                                     dc1394video_frame_t** frame) {
  const Call call(camera);
  *frame = nullptr;
  Capture* capture = call.handle.capture.get();
  if (capture == nullptr) return DC1394_CAPTURE_IS_NOT_SET;
  if (policy != DC1394_CAPTURE_POLICY_POLL) std::abort();  // the daemon must never block here
  if (call.gone()) return DC1394_FAILURE;
  if (capture->events.empty()) return DC1394_SUCCESS;
  eventfd_t one = 0;
  ::eventfd_read(capture->fd, &one);
  const Event event = capture->events.front();
  capture->events.erase(capture->events.begin());
  dc1394video_frame_t& next = capture->frames[capture->next];
  capture->corrupt[capture->next] = event.corrupt;
  capture->next = (capture->next + 1) % static_cast<std::uint32_t>(capture->frames.size());
  next.timestamp = event.timestamp_us;
  next.frames_behind = 0;
  *frame = &next;
  return DC1394_SUCCESS;
}
dc1394error_t dc1394_capture_enqueue(dc1394camera_t* camera, dc1394video_frame_t* frame) {
  const Call call(camera);
  if (frame->camera != camera) return DC1394_INVALID_ARGUMENT_VALUE;
  if (call.gone()) return DC1394_IOCTL_FAILURE;
  std::vector<std::uint32_t>& queued = call.handle.capture->queued;
  if (std::find(queued.begin(), queued.end(), frame->id) != queued.end()) std::abort();  // returned twice
  queued.push_back(frame->id);
  return DC1394_SUCCESS;
}
dc1394bool_t dc1394_capture_is_frame_corrupt(dc1394camera_t* camera, dc1394video_frame_t* frame) {
  const Call call(camera);
  return boolean(call.handle.capture->corrupt[frame->id]);
}

// ---- features

dc1394error_t dc1394_feature_get(dc1394camera_t* camera, dc1394feature_info_t* info) {
  return with_camera(camera, [&](const Camera& c) {
    const auto found = c.features.find(info->id);
    info->available = boolean(found != c.features.end());
    if (found == c.features.end()) return DC1394_SUCCESS;
    const Feature& f = found->second;
    info->absolute_capable = boolean(f.absolute);
    info->readout_capable = boolean(f.readable);
    info->on_off_capable = boolean(f.switchable);
    info->is_on = switched(f.on);
    info->min = f.min;
    info->max = f.max;
    info->value = f.values[0];
    info->abs_control = switched(f.absolute_on);
    info->abs_min = f.absolute_min;
    info->abs_max = f.absolute_max;
    info->abs_value = f.absolute_value;
    info->current_mode = f.mode;
    info->modes.num = 0;
    info->polarity_capable = boolean(f.polarity_capable);
    if (info->id == DC1394_FEATURE_TRIGGER) {
      info->trigger_mode = f.trigger_mode;
      info->trigger_source = f.source;
      info->trigger_modes.num = info->trigger_sources.num = 0;
      for (const auto mode : f.trigger_modes) info->trigger_modes.modes[info->trigger_modes.num++] = mode;
      for (const auto source : f.sources) info->trigger_sources.sources[info->trigger_sources.num++] = source;
    } else {
      for (const auto mode : f.modes) info->modes.modes[info->modes.num++] = mode;
    }
    return DC1394_SUCCESS;
  });
}
dc1394error_t dc1394_feature_is_present(dc1394camera_t* camera, dc1394feature_t id, dc1394bool_t* there) {
  return with_camera(
      camera, [&](const Camera& c) { return *there = boolean(c.features.contains(id)), DC1394_SUCCESS; });
}
dc1394error_t dc1394_feature_has_absolute_control(dc1394camera_t* camera, dc1394feature_t id,
                                                  dc1394bool_t* there) {
  return with_feature(camera, id,
                      [&](const Feature& f) { return *there = boolean(f.absolute), DC1394_SUCCESS; });
}
dc1394error_t dc1394_feature_is_switchable(dc1394camera_t* camera, dc1394feature_t id, dc1394bool_t* there) {
  return with_feature(camera, id,
                      [&](const Feature& f) { return *there = boolean(f.switchable), DC1394_SUCCESS; });
}
dc1394error_t dc1394_feature_get_absolute_boundaries(dc1394camera_t* camera, dc1394feature_t id, float* least,
                                                     float* most) {
  return with_feature(camera, id, [&](const Feature& f) {
    return *least = f.absolute_min, *most = f.absolute_max, DC1394_SUCCESS;
  });
}
dc1394error_t dc1394_feature_set_power(dc1394camera_t* camera, dc1394feature_t id, dc1394switch_t on) {
  return set_feature(camera, id, [&](Feature& f) { f.on = on == DC1394_ON; });
}
dc1394error_t dc1394_feature_set_mode(dc1394camera_t* camera, dc1394feature_t id, dc1394feature_mode_t mode) {
  return set_feature(camera, id, [&](Feature& f) {
    // One push finishes at once.
    f.mode = mode == DC1394_FEATURE_MODE_ONE_PUSH_AUTO ? DC1394_FEATURE_MODE_MANUAL : mode;
    if (mode == DC1394_FEATURE_MODE_ONE_PUSH_AUTO) f.values[0] = 77;
  });
}
dc1394error_t dc1394_feature_set_value(dc1394camera_t* camera, dc1394feature_t id, std::uint32_t value) {
  if (id == DC1394_FEATURE_WHITE_BALANCE || id == DC1394_FEATURE_WHITE_SHADING ||
      id == DC1394_FEATURE_TEMPERATURE) {
    return DC1394_INVALID_FEATURE;
  }
  return set_feature(camera, id, [&](Feature& f) { f.values[0] = value; });
}
dc1394error_t dc1394_feature_set_absolute_control(dc1394camera_t* camera, dc1394feature_t id,
                                                  dc1394switch_t on) {
  return set_feature(camera, id, [&](Feature& f) { f.absolute_on = on == DC1394_ON; });
}
dc1394error_t dc1394_feature_set_absolute_value(dc1394camera_t* camera, dc1394feature_t id, float value) {
  return set_feature(camera, id, [&](Feature& f) { f.absolute_value = value; });
}
dc1394error_t dc1394_feature_whitebalance_get_value(dc1394camera_t* camera, std::uint32_t* blue_u,
                                                    std::uint32_t* red_v) {
  return with_feature(camera, DC1394_FEATURE_WHITE_BALANCE, [&](const Feature& f) {
    return *blue_u = f.values[0], *red_v = f.values[1], DC1394_SUCCESS;
  });
}
dc1394error_t dc1394_feature_whitebalance_set_value(dc1394camera_t* camera, std::uint32_t blue_u,
                                                    std::uint32_t red_v) {
  return set_feature(camera, DC1394_FEATURE_WHITE_BALANCE, [&](Feature& f) {
    f.values = {blue_u, red_v, 0};
  });
}
dc1394error_t dc1394_feature_whiteshading_get_value(dc1394camera_t* camera, std::uint32_t* red,
                                                    std::uint32_t* green, std::uint32_t* blue) {
  return with_feature(camera, DC1394_FEATURE_WHITE_SHADING, [&](const Feature& f) {
    return *red = f.values[0], *green = f.values[1], *blue = f.values[2], DC1394_SUCCESS;
  });
}
dc1394error_t dc1394_feature_whiteshading_set_value(dc1394camera_t* camera, std::uint32_t red,
                                                    std::uint32_t green, std::uint32_t blue) {
  return set_feature(camera, DC1394_FEATURE_WHITE_SHADING, [&](Feature& f) {
    f.values = {red, green, blue};
  });
}
dc1394error_t dc1394_feature_temperature_get_value(dc1394camera_t* camera, std::uint32_t* target,
                                                   std::uint32_t* now) {
  return with_feature(camera, DC1394_FEATURE_TEMPERATURE, [&](const Feature& f) {
    return *target = f.values[0], *now = f.values[1], DC1394_SUCCESS;
  });
}
dc1394error_t dc1394_feature_temperature_set_value(dc1394camera_t* camera, std::uint32_t target) {
  return set_feature(camera, DC1394_FEATURE_TEMPERATURE, [&](Feature& f) { f.values[0] = target; });
}

dc1394error_t dc1394_external_trigger_set_power(dc1394camera_t* camera, dc1394switch_t on) {
  return dc1394_feature_set_power(camera, DC1394_FEATURE_TRIGGER, on);
}
dc1394error_t dc1394_external_trigger_get_power(dc1394camera_t* camera, dc1394switch_t* on) {
  return with_feature(camera, DC1394_FEATURE_TRIGGER,
                      [&](const Feature& f) { return *on = switched(f.on), DC1394_SUCCESS; });
}
dc1394error_t dc1394_external_trigger_set_mode(dc1394camera_t* camera, dc1394trigger_mode_t mode) {
  return set_feature(camera, DC1394_FEATURE_TRIGGER, [&](Feature& f) { f.trigger_mode = mode; });
}
dc1394error_t dc1394_external_trigger_set_source(dc1394camera_t* camera, dc1394trigger_source_t source) {
  return set_feature(camera, DC1394_FEATURE_TRIGGER, [&](Feature& f) { f.source = source; });
}
dc1394error_t dc1394_external_trigger_get_polarity(dc1394camera_t* camera,
                                                   dc1394trigger_polarity_t* polarity) {
  return with_feature(camera, DC1394_FEATURE_TRIGGER,
                      [&](const Feature& f) { return *polarity = f.polarity, DC1394_SUCCESS; });
}
dc1394error_t dc1394_external_trigger_set_polarity(dc1394camera_t* camera,
                                                   dc1394trigger_polarity_t polarity) {
  return set_feature(camera, DC1394_FEATURE_TRIGGER, [&](Feature& f) { f.polarity = polarity; });
}
dc1394error_t dc1394_software_trigger_set_power(dc1394camera_t* camera, dc1394switch_t on) {
  const Call call(camera);
  if (call.gone()) return DC1394_FAILURE;
  if (on == DC1394_ON) send_locked(*call.handle.device, {});
  return DC1394_SUCCESS;
}
dc1394error_t dc1394_memory_load(dc1394camera_t* camera, std::uint32_t channel) {
  return with_camera(camera,
                     [&](Camera& c) { return c.loaded_channel = static_cast<int>(channel), DC1394_SUCCESS; });
}
dc1394error_t dc1394_memory_save(dc1394camera_t* camera, std::uint32_t channel) {
  return with_camera(camera,
                     [&](Camera& c) { return c.saved_channel = static_cast<int>(channel), DC1394_SUCCESS; });
}

}  // extern "C"
