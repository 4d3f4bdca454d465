// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "capture/v4l2/v4l2_device.h"

#include <condition_variable>
#include <deque>
#include <map>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <linux/videodev2.h>

namespace sslv {

/// A video device simulated at the level of kernel calls. The test defines its properties and delivers
/// frames.
class FakeV4l2 final : public V4l2Device {
 public:
  struct Mode {
    std::uint32_t fourcc;
    int width, height;
    std::vector<int> rates_hz;
  };
  struct Item {
    std::uint32_t id, type;
    std::string title;
    std::int64_t min = 0, max = 0, step = 1, value = 0;
    std::uint32_t flags = 0;
    std::vector<std::string> choices{};  // empty: that number is not allowed
    std::string text{};
  };

  // To be set before it is opened.
  std::string model = "Fake Camera", driver = "fake", bus = "usb-1";
  std::uint32_t capabilities = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING;
  std::vector<Mode> modes{{V4L2_PIX_FMT_YUYV, 64, 48, {30}}};
  std::uint32_t padding_bytes = 0;  // per row
  /// For a device with only V4L2_CAP_VIDEO_CAPTURE_MPLANE: offset of images in their plane, and the number of
  /// planes that it reports.
  std::uint32_t data_offset = 0, planes = 1;
  std::map<std::uint32_t, Item> items{};
  std::map<unsigned long, int> failing{};  // calls that fail, and their errno
  std::uint32_t stamp_flags = V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC | V4L2_BUF_FLAG_TSTAMP_SRC_SOE;

  /// Fills the next queued buffer; without one, the frame is lost as in a driver.
  void deliver(std::span<const std::uint8_t> bytes, std::uint32_t flags = 0);
  /// A whole image of equal bytes.
  void deliver(std::uint8_t value);
  void lose_pictures(std::uint32_t count);
  void change_item(std::uint32_t id, std::int64_t value, std::uint32_t flags);
  void fail(unsigned long request, int error);
  void unplug();

  std::int64_t value_of(std::uint32_t id);
  v4l2_pix_format format();
  bool streams();
  std::size_t queued(), mapped();
  std::vector<std::uint32_t> order_set();  // ids of controls in the order set; 0: the stream was started

  int call(unsigned long request, void* argument) noexcept override;
  Ready wait(std::chrono::milliseconds timeout) noexcept override;
  std::uint8_t* map(std::size_t bytes, std::uint32_t offset) noexcept override;
  void unmap(std::uint8_t* memory, std::size_t bytes) noexcept override;

 private:
  struct Buffer {
    std::vector<std::uint8_t> bytes;
    bool queued = false;
  };

  v4l2_buf_type buffer_type() const;
  std::size_t buffer_bytes() const { return data_offset + format_.sizeimage; }
  /// Whether a call about formats or buffers has the device's own buffer type.
  bool is_of_its_kind(unsigned long request, const void* argument) const;
  void fill_in(v4l2_buffer& out, const v4l2_buffer& from) const;
  int answer(unsigned long request, void* argument);
  int describe(v4l2_capability& out);
  int describe(v4l2_fmtdesc& out);
  int describe(v4l2_frmsizeenum& out);
  int describe(v4l2_frmivalenum& out);
  int get_or_set_format(bool setting, v4l2_format& format);
  int set(v4l2_pix_format& wanted);
  int set(v4l2_captureparm& wanted);
  int allocate(v4l2_requestbuffers& request);
  int describe(v4l2_query_ext_ctrl& out);
  int describe(v4l2_querymenu& out);
  int get_or_set(bool setting, v4l2_ext_control& one);
  int subscribe(const v4l2_event_subscription& subscription);
  const Mode* mode_of(std::uint32_t fourcc, int width, int height) const;
  void tell(const Item& item);

  std::mutex mutex_;
  std::condition_variable changed_;
  v4l2_pix_format format_{};
  int rate_hz_ = 0;
  std::vector<Buffer> buffers_;
  std::map<std::uint8_t*, std::vector<std::uint8_t>> orphans_;  // mapped, but no longer the device's
  std::size_t mapped_ = 0;
  std::deque<std::uint32_t> queue_;
  std::deque<v4l2_buffer> filled_;
  std::deque<v4l2_event> events_;
  std::optional<std::uint32_t> watched_;
  std::vector<std::uint32_t> order_;
  std::uint32_t sequence_ = 0;
  bool streams_ = false, unplugged_ = false;
};

}  // namespace sslv
