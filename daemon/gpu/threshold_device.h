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

/// What labels images in the place of the CPU, for one thread that may wait for it: a GPU, or a test's fake.
class ThresholdDevice {
 public:
  virtual ~ThresholdDevice() = default;

  virtual const std::string& name() const = 0;
  /// It is a program on the CPU.
  virtual bool is_software() const = 0;
  /// All of the image, without a mask; its rows are still being written. False: there are no labels, and
  /// problem() says why.
  virtual bool process(const TableView& table, const ImageView& image, const RowsThere& rows,
                       LabelImage& labels) noexcept = 0;
  virtual const std::string& problem() const = 0;
  /// Nothing comes from it any more.
  virtual bool is_lost() const = 0;
};

/// Throws GpuError, with one line, when there is none. May take seconds.
using OpenDevice = std::function<std::unique_ptr<ThresholdDevice>()>;

/// This computer's GPU, by compute shaders where it has them.
std::unique_ptr<ThresholdDevice> open_gpu();

}  // namespace sslv
