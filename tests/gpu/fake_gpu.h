// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "gpu/gpu_context.h"
#include "gpu/threshold_device.h"

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace sslv {

/// A test's control over the fake GPUs and what it observes of them. Shared with each GPU, because a hanging
/// thread may outlive the test.
struct FakeGpus {
  std::atomic<bool> may_open{true};       // until then, opening waits
  std::atomic<bool> is_there{true};       // otherwise opening fails
  std::atomic<bool> may_answer{true};     // until then, process() waits
  std::atomic<bool> fails{false};         // process() returns no labels
  std::atomic<bool> loses_itself{false};  // a failure also loses the GPU
  std::atomic<bool> is_software{false};
  std::atomic<int> widest{16'384};  // maximum image width
  std::atomic<int> opened{0}, closed{0}, asked{0};

  static void set(std::atomic<bool>& flag) {
    flag = true;
    flag.notify_all();
  }
};

/// Labels grey images by their table, like a GPU.
class FakeGpu final : public ThresholdDevice {
 public:
  explicit FakeGpu(std::shared_ptr<FakeGpus> all) : all_(std::move(all)) {}
  ~FakeGpu() override { ++all_->closed; }

  const std::string& name() const override { return name_; }
  bool is_software() const override { return all_->is_software; }
  const std::string& problem() const override { return problem_; }
  bool is_lost() const override { return is_lost_; }

  bool process(const TableView& table, const ImageView& image, const RowsThere& rows,
               LabelImage& labels) noexcept override {
    ++all_->asked;
    all_->asked.notify_all();
    all_->may_answer.wait(false);
    if (image.width > all_->widest) {
      problem_ = "the image is too large for this GPU";
      return false;
    }
    if (all_->fails) {
      problem_ = "the GPU was reset";
      is_lost_ = all_->loses_itself;
      return false;
    }
    // Like a GPU, copies the table only if its id has changed.
    if (std::exchange(table_id_, table.lut_id) != table.lut_id)
      table_.assign(table.labels.begin(), table.labels.end());
    labels.cell_px = 1;
    labels.width = image.width;
    labels.height = image.height;
    labels.labels.resize(static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height));
    for (int y = 0; y < image.height; ++y) {
      rows.wait_for(y + 1);
      std::transform(image.row(y), image.row(y) + image.width, labels.row(y),
                     [&](std::uint8_t grey) { return table_[LutTable::index(128, 128, grey, table.bits)]; });
    }
    return true;
  }

 private:
  const std::shared_ptr<FakeGpus> all_;
  const std::string name_ = "Fake 3000";
  std::string problem_;
  std::uint64_t table_id_ = 0;
  std::vector<Label> table_;
  bool is_lost_ = false;
};

inline OpenDevice open_fake(std::shared_ptr<FakeGpus> all) {
  return [all = std::move(all)]() -> std::unique_ptr<ThresholdDevice> {
    ++all->opened;
    all->may_open.wait(false);
    if (!all->is_there) throw GpuError("no GPU: it is not plugged in");
    return std::make_unique<FakeGpu>(all);
  };
}

}  // namespace sslv
