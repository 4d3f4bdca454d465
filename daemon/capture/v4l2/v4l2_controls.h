// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "capture/controls.h"
#include "capture/v4l2/v4l2_device.h"

#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include <linux/videodev2.h>

namespace sslv {

/// All controls of a video device, with the names that v4l2-ctl uses: "brightness", "exposure_time_absolute".
class V4l2Controls final : public Controls {
 public:
  explicit V4l2Controls(std::shared_ptr<V4l2Device> device);

  /// Makes further calls throw CaptureError. Waits for a running call.
  void close();

  std::vector<Control> list() override;
  Control get(const std::string& name) override;

 protected:
  void write(const Control& control, const Json& value) override;

 private:
  /// Properties that are constant while the device is open.
  struct Entry {
    std::string name, category;
    std::uint32_t id;
  };

  V4l2Device& device() const;  // throws CaptureError when closed
  const Entry& entry_of(const std::string& name) const;
  v4l2_query_ext_ctrl query(std::uint32_t id) const;
  Control describe(const Entry& entry) const;
  std::vector<std::string> menu(const v4l2_query_ext_ctrl& asked, std::vector<std::int64_t>& numbers) const;
  Json read(const v4l2_query_ext_ctrl& asked) const;

  std::mutex mutex_;
  std::shared_ptr<V4l2Device> device_;  // null: closed
  std::vector<Entry> entries_;          // in the device's order
};

}  // namespace sslv
