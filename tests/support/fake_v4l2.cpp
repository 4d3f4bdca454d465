// SPDX-License-Identifier: Apache-2.0
#include "support/fake_v4l2.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <ctime>

namespace sslv {
namespace {

template <std::size_t N, class C>
void copy_text(C (&to)[N], const std::string& from) {
  std::fill(to, to + N, C{});
  std::copy_n(from.begin(), std::min(from.size(), N - 1), to);
}

template <class T>
T& as(void* argument) {
  return *static_cast<T*>(argument);
}

}  // namespace

void FakeV4l2::deliver(std::span<const std::uint8_t> bytes, std::uint32_t flags) {
  const std::lock_guard lock(mutex_);
  const std::uint32_t sequence = sequence_++;
  if (queue_.empty() || !streams_) return;
  v4l2_buffer filled{};
  filled.index = queue_.front();
  queue_.pop_front();
  Buffer& buffer = buffers_[filled.index];
  buffer.queued = false;
  const std::size_t count = std::min(bytes.size(), buffer.bytes.size() - data_offset);
  std::copy_n(bytes.begin(), count, buffer.bytes.begin() + data_offset);
  filled.bytesused = static_cast<__u32>(data_offset + count);
  filled.length = static_cast<__u32>(buffer.bytes.size());
  filled.flags = stamp_flags | flags;
  filled.sequence = sequence;
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  filled.timestamp = {now.tv_sec, now.tv_nsec / 1000};
  filled_.push_back(filled);
  changed_.notify_all();
}

void FakeV4l2::deliver(std::uint8_t value) {
  deliver(std::vector<std::uint8_t>(format().sizeimage, value));
}

void FakeV4l2::lose_pictures(std::uint32_t count) {
  const std::lock_guard lock(mutex_);
  sequence_ += count;
}

void FakeV4l2::change_item(std::uint32_t id, std::int64_t value, std::uint32_t flags) {
  const std::lock_guard lock(mutex_);
  items.at(id).value = value;
  items.at(id).flags = flags;
  tell(items.at(id));
}

void FakeV4l2::fail(unsigned long request, int error) {
  const std::lock_guard lock(mutex_);
  failing[request] = error;
  changed_.notify_all();
}

void FakeV4l2::unplug() {
  const std::lock_guard lock(mutex_);
  unplugged_ = true;
  changed_.notify_all();
}

std::int64_t FakeV4l2::value_of(std::uint32_t id) {
  const std::lock_guard lock(mutex_);
  return items.at(id).value;
}

v4l2_pix_format FakeV4l2::format() {
  const std::lock_guard lock(mutex_);
  return format_;
}

bool FakeV4l2::streams() {
  const std::lock_guard lock(mutex_);
  return streams_;
}

std::size_t FakeV4l2::queued() {
  const std::lock_guard lock(mutex_);
  return queue_.size();
}

std::size_t FakeV4l2::mapped() {
  const std::lock_guard lock(mutex_);
  return mapped_;
}

std::vector<std::uint32_t> FakeV4l2::order_set() {
  const std::lock_guard lock(mutex_);
  return order_;
}

int FakeV4l2::call(unsigned long request, void* argument) noexcept {
  const std::lock_guard lock(mutex_);
  if (unplugged_) return ENODEV;
  if (const auto found = failing.find(request); found != failing.end()) return found->second;
  return answer(request, argument);
}

v4l2_buf_type FakeV4l2::buffer_type() const {
  return (capabilities & V4L2_CAP_VIDEO_CAPTURE) != 0 ? V4L2_BUF_TYPE_VIDEO_CAPTURE
                                                      : V4L2_BUF_TYPE_VIDEO_CAPTURE_MPLANE;
}

bool FakeV4l2::is_of_its_kind(unsigned long request, const void* argument) const {
  const auto type = static_cast<__u32>(buffer_type());
  switch (request) {
    case VIDIOC_ENUM_FMT: return static_cast<const v4l2_fmtdesc*>(argument)->type == type;
    case VIDIOC_G_FMT:
    case VIDIOC_S_FMT: return static_cast<const v4l2_format*>(argument)->type == type;
    case VIDIOC_G_PARM:
    case VIDIOC_S_PARM: return static_cast<const v4l2_streamparm*>(argument)->type == type;
    case VIDIOC_REQBUFS: return static_cast<const v4l2_requestbuffers*>(argument)->type == type;
    case VIDIOC_QUERYBUF:
    case VIDIOC_QBUF:
    case VIDIOC_DQBUF: {
      const auto& buffer = *static_cast<const v4l2_buffer*>(argument);
      const bool has_planes = buffer.m.planes != nullptr && buffer.length >= 1;
      return buffer.type == type && (type == V4L2_BUF_TYPE_VIDEO_CAPTURE || has_planes);
    }
    case VIDIOC_STREAMON:
    case VIDIOC_STREAMOFF: return *static_cast<const int*>(argument) == static_cast<int>(type);
    default: return true;
  }
}

/// Fills in the plane instead if the device has planes.
void FakeV4l2::fill_in(v4l2_buffer& out, const v4l2_buffer& from) const {
  if (buffer_type() == V4L2_BUF_TYPE_VIDEO_CAPTURE) {
    out = from;
    return;
  }
  v4l2_plane* plane = out.m.planes;
  *plane = {};
  plane->length = from.length;
  plane->bytesused = from.bytesused;
  plane->data_offset = data_offset;
  plane->m.mem_offset = from.m.offset;
  out = from;
  out.type = V4L2_BUF_TYPE_VIDEO_CAPTURE_MPLANE;
  out.m.planes = plane;
  out.length = 1;
  out.bytesused = 0;
}

int FakeV4l2::answer(unsigned long request, void* argument) {
  if (!is_of_its_kind(request, argument)) return EINVAL;
  switch (request) {
    case VIDIOC_QUERYCAP: return describe(as<v4l2_capability>(argument));
    case VIDIOC_ENUM_FMT: return describe(as<v4l2_fmtdesc>(argument));
    case VIDIOC_ENUM_FRAMESIZES: return describe(as<v4l2_frmsizeenum>(argument));
    case VIDIOC_ENUM_FRAMEINTERVALS: return describe(as<v4l2_frmivalenum>(argument));
    case VIDIOC_G_FMT: return get_or_set_format(false, as<v4l2_format>(argument));
    case VIDIOC_S_FMT: return get_or_set_format(true, as<v4l2_format>(argument));
    case VIDIOC_G_PARM:
      as<v4l2_streamparm>(argument).parm.capture = {};
      as<v4l2_streamparm>(argument).parm.capture.capability = V4L2_CAP_TIMEPERFRAME;
      as<v4l2_streamparm>(argument).parm.capture.timeperframe = {1, static_cast<__u32>(rate_hz_)};
      return 0;
    case VIDIOC_S_PARM: return set(as<v4l2_streamparm>(argument).parm.capture);
    case VIDIOC_REQBUFS: return allocate(as<v4l2_requestbuffers>(argument));
    case VIDIOC_QUERYBUF: {
      auto& buffer = as<v4l2_buffer>(argument);
      if (buffer.index >= buffers_.size()) return EINVAL;
      v4l2_buffer asked{};
      asked.index = asked.m.offset = buffer.index;
      asked.length = static_cast<__u32>(buffer_bytes());
      fill_in(buffer, asked);
      return 0;
    }
    case VIDIOC_QBUF: {
      const std::uint32_t index = as<v4l2_buffer>(argument).index;
      if (index >= buffers_.size() || buffers_[index].queued) return EINVAL;
      buffers_[index].queued = true;
      queue_.push_back(index);
      return 0;
    }
    case VIDIOC_DQBUF:
      if (filled_.empty()) return EAGAIN;
      fill_in(as<v4l2_buffer>(argument), filled_.front());
      filled_.pop_front();
      return 0;
    case VIDIOC_STREAMON:
      streams_ = true;
      order_.push_back(0);
      return 0;
    case VIDIOC_STREAMOFF:
      streams_ = false;
      queue_.clear();
      filled_.clear();
      return 0;
    case VIDIOC_QUERY_EXT_CTRL: return describe(as<v4l2_query_ext_ctrl>(argument));
    case VIDIOC_QUERYMENU: return describe(as<v4l2_querymenu>(argument));
    case VIDIOC_G_EXT_CTRLS: return get_or_set(false, *as<v4l2_ext_controls>(argument).controls);
    case VIDIOC_S_EXT_CTRLS: return get_or_set(true, *as<v4l2_ext_controls>(argument).controls);
    case VIDIOC_SUBSCRIBE_EVENT: return subscribe(as<v4l2_event_subscription>(argument));
    case VIDIOC_DQEVENT:
      if (events_.empty()) return ENOENT;
      as<v4l2_event>(argument) = events_.front();
      events_.pop_front();
      return 0;
    default: return ENOTTY;
  }
}

int FakeV4l2::describe(v4l2_capability& out) {
  copy_text(out.card, model);
  copy_text(out.driver, driver);
  copy_text(out.bus_info, bus);
  out.capabilities = capabilities | V4L2_CAP_DEVICE_CAPS;
  out.device_caps = capabilities;
  return 0;
}

int FakeV4l2::describe(v4l2_fmtdesc& out) {
  std::vector<std::uint32_t> known;
  for (const Mode& mode : modes) {
    if (std::find(known.begin(), known.end(), mode.fourcc) == known.end()) known.push_back(mode.fourcc);
  }
  if (out.index >= known.size()) return EINVAL;
  out.pixelformat = known[out.index];
  return 0;
}

int FakeV4l2::describe(v4l2_frmsizeenum& out) {
  std::uint32_t number = 0;
  for (const Mode& mode : modes) {
    if (mode.fourcc != out.pixel_format || number++ != out.index) continue;
    out.type = V4L2_FRMSIZE_TYPE_DISCRETE;
    out.discrete = {static_cast<__u32>(mode.width), static_cast<__u32>(mode.height)};
    return 0;
  }
  return EINVAL;
}

int FakeV4l2::describe(v4l2_frmivalenum& out) {
  const Mode* mode = mode_of(out.pixel_format, static_cast<int>(out.width), static_cast<int>(out.height));
  if (mode == nullptr || out.index >= mode->rates_hz.size()) return EINVAL;
  out.type = V4L2_FRMIVAL_TYPE_DISCRETE;
  out.discrete = {1, static_cast<__u32>(mode->rates_hz[out.index])};
  return 0;
}

int FakeV4l2::get_or_set_format(bool setting, v4l2_format& format) {
  const bool planar = buffer_type() == V4L2_BUF_TYPE_VIDEO_CAPTURE_MPLANE;
  v4l2_pix_format pix = format_;
  if (setting && planar) {
    const v4l2_pix_format_mplane& wanted = format.fmt.pix_mp;
    pix.width = wanted.width;
    pix.height = wanted.height;
    pix.pixelformat = wanted.pixelformat;
    pix.field = wanted.field;
  } else if (setting) {
    pix = format.fmt.pix;
  } else if (format_.width == 0) {
    pix.pixelformat = format_.pixelformat = modes[0].fourcc;
    pix.width = format_.width = static_cast<__u32>(modes[0].width);
    pix.height = format_.height = static_cast<__u32>(modes[0].height);
  }
  if (setting) set(pix);
  if (!planar) {
    format.fmt.pix = pix;
    return 0;
  }
  v4l2_pix_format_mplane& out = format.fmt.pix_mp;
  out = {};
  out.width = pix.width;
  out.height = pix.height;
  out.pixelformat = pix.pixelformat;
  out.field = pix.field;
  out.num_planes = static_cast<__u8>(planes);
  out.plane_fmt[0].bytesperline = pix.bytesperline;
  out.plane_fmt[0].sizeimage = pix.sizeimage;
  return 0;
}

/// Like a driver: replaces unsupported values by the first supported one.
int FakeV4l2::set(v4l2_pix_format& wanted) {
  const Mode* mode =
      mode_of(wanted.pixelformat, static_cast<int>(wanted.width), static_cast<int>(wanted.height));
  if (mode == nullptr) mode = &modes[0];
  wanted.pixelformat = mode->fourcc;
  wanted.width = static_cast<__u32>(mode->width);
  wanted.height = static_cast<__u32>(mode->height);
  const bool grey = mode->fourcc == V4L2_PIX_FMT_GREY;
  const bool bayer = mode->fourcc == V4L2_PIX_FMT_SRGGB8;
  const bool rgb = mode->fourcc == V4L2_PIX_FMT_RGB24;
  const bool jpeg = mode->fourcc == V4L2_PIX_FMT_MJPEG;
  const bool nv12 = mode->fourcc == V4L2_PIX_FMT_NV12;
  const __u32 bytes = rgb || jpeg ? 3 : grey || bayer || nv12 ? 1 : 2;
  wanted.bytesperline = jpeg ? 0 : wanted.width * bytes + padding_bytes;
  wanted.sizeimage = (wanted.width * bytes + padding_bytes) * wanted.height;
  if (nv12) wanted.sizeimage += wanted.sizeimage / 2;
  format_ = wanted;
  rate_hz_ = mode->rates_hz[0];
  return 0;
}

int FakeV4l2::set(v4l2_captureparm& wanted) {
  const Mode* mode =
      mode_of(format_.pixelformat, static_cast<int>(format_.width), static_cast<int>(format_.height));
  const auto asked_hz = static_cast<int>(wanted.timeperframe.denominator / wanted.timeperframe.numerator);
  const std::vector<int>& rates = mode->rates_hz;
  rate_hz_ = std::find(rates.begin(), rates.end(), asked_hz) != rates.end() ? asked_hz : rates[0];
  wanted.timeperframe = {1, static_cast<__u32>(rate_hz_)};
  return 0;
}

int FakeV4l2::allocate(v4l2_requestbuffers& request) {
  if (streams_) return EBUSY;
  for (Buffer& buffer : buffers_) {
    // The memory must not move.
    std::uint8_t* memory = buffer.bytes.data();
    orphans_[memory] = std::move(buffer.bytes);
  }
  buffers_.assign(request.count, {});
  for (Buffer& buffer : buffers_) buffer.bytes.resize(buffer_bytes());
  queue_.clear();
  return 0;
}

int FakeV4l2::describe(v4l2_query_ext_ctrl& out) {
  const bool next = (out.id & V4L2_CTRL_FLAG_NEXT_CTRL) != 0;
  const std::uint32_t id = out.id & ~static_cast<__u32>(V4L2_CTRL_FLAG_NEXT_CTRL);
  const auto found = next ? items.upper_bound(id) : items.find(id);
  if (found == items.end()) return EINVAL;
  const Item& item = found->second;
  out = {};
  out.id = item.id;
  out.type = item.type;
  copy_text(out.name, item.title);
  out.minimum = item.min;
  out.maximum = item.max;
  out.step = static_cast<__u64>(item.step);
  out.flags = item.flags;
  out.elem_size = item.type == V4L2_CTRL_TYPE_STRING ? static_cast<__u32>(item.max + 1) : 4;
  return 0;
}

int FakeV4l2::describe(v4l2_querymenu& out) {
  const Item& item = items.at(out.id);
  if (out.index >= item.choices.size() || item.choices[out.index].empty()) return EINVAL;
  if (item.type == V4L2_CTRL_TYPE_INTEGER_MENU) {
    out.value = std::stoll(item.choices[out.index]);
  } else {
    std::memset(out.name, 0, sizeof out.name);
    std::memcpy(out.name, item.choices[out.index].data(), item.choices[out.index].size());
  }
  return 0;
}

int FakeV4l2::get_or_set(bool setting, v4l2_ext_control& one) {
  const auto found = items.find(one.id);
  if (found == items.end()) return EINVAL;
  Item& item = found->second;
  if (!setting) {
    if ((item.flags & V4L2_CTRL_FLAG_WRITE_ONLY) != 0) return EACCES;
    if (item.type == V4L2_CTRL_TYPE_STRING) {
      std::memcpy(one.string, item.text.c_str(), item.text.size() + 1);
    } else if (item.type == V4L2_CTRL_TYPE_INTEGER64) {
      one.value64 = item.value;
    } else {
      one.value = static_cast<__s32>(item.value);
    }
    return 0;
  }
  order_.push_back(item.id);
  if (item.type == V4L2_CTRL_TYPE_STRING) {
    item.text = one.string;
  } else {
    item.value = item.type == V4L2_CTRL_TYPE_INTEGER64 ? std::int64_t{one.value64} : one.value;
  }
  // As in webcams, whose exposure time can only be set in manual mode (menu item 1).
  if (item.id == V4L2_CID_EXPOSURE_AUTO && items.contains(V4L2_CID_EXPOSURE_ABSOLUTE)) {
    Item& time = items.at(V4L2_CID_EXPOSURE_ABSOLUTE);
    time.flags = item.value == V4L2_EXPOSURE_MANUAL ? 0 : V4L2_CTRL_FLAG_INACTIVE;
    tell(time);
  }
  tell(item);
  return 0;
}

int FakeV4l2::subscribe(const v4l2_event_subscription& subscription) {
  const auto found = items.find(subscription.id);
  if (found == items.end()) return EINVAL;
  watched_ = subscription.id;
  tell(found->second);
  return 0;
}

const FakeV4l2::Mode* FakeV4l2::mode_of(std::uint32_t fourcc, int width, int height) const {
  const auto found = std::find_if(modes.begin(), modes.end(), [=](const Mode& m) {
    return m.fourcc == fourcc && m.width == width && m.height == height;
  });
  return found == modes.end() ? nullptr : &*found;
}

void FakeV4l2::tell(const Item& item) {
  if (watched_ != item.id) return;
  v4l2_event event{};
  event.type = V4L2_EVENT_CTRL;
  event.id = item.id;
  event.u.ctrl.value = static_cast<__s32>(item.value);
  event.u.ctrl.flags = item.flags;
  events_.push_back(event);
  changed_.notify_all();
}

V4l2Device::Ready FakeV4l2::wait(std::chrono::milliseconds timeout) noexcept {
  std::unique_lock lock(mutex_);
  const auto now = [&]() -> Ready {
    return {!filled_.empty(), !events_.empty(), unplugged_ || failing.contains(VIDIOC_DQBUF)};
  };
  changed_.wait_for(lock, timeout, [&] { return now().picture || now().event || now().error; });
  return now();
}

std::uint8_t* FakeV4l2::map(std::size_t, std::uint32_t offset) noexcept {
  const std::lock_guard lock(mutex_);
  ++mapped_;
  return buffers_[offset].bytes.data();
}

void FakeV4l2::unmap(std::uint8_t* memory, std::size_t) noexcept {
  const std::lock_guard lock(mutex_);
  --mapped_;
  orphans_.erase(memory);
}

}  // namespace sslv
