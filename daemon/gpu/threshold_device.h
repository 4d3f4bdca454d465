// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "gpu/gpu_threshold.h"
#include "gpu/rows_there.h"
#include "image/image.h"
#include "vision/regions.h"

#include <functional>
#include <memory>
#include <string>

namespace sslv {

/// Labels images instead of the CPU: a GPU, or a fake in tests. Used by one thread, which may wait.
class ThresholdDevice {
 public:
  virtual ~ThresholdDevice() = default;

  virtual const std::string& name() const = 0;
  /// Whether rendering runs on the CPU.
  virtual bool is_software() const = 0;
  /// Labels the whole image, without a mask, while its rows are still being written. False: there are no
  /// labels, and problem() gives the reason.
  virtual bool process(const TableView& table, const ImageView& image, const RowsThere& rows,
                       LabelImage& labels) noexcept = 0;
  virtual const std::string& problem() const = 0;
  /// Whether the device is permanently unusable.
  virtual bool is_lost() const = 0;
};

/// Opens a device. Throws GpuError with one line if there is none. May take seconds.
using OpenDevice = std::function<std::unique_ptr<ThresholdDevice>()>;

/// This computer's GPU.
std::unique_ptr<ThresholdDevice> open_gpu();

}  // namespace sslv
