// SPDX-License-Identifier: Apache-2.0
#include "gpu/threshold_device.h"

#include "gpu/gpu_context.h"

namespace sslv {
namespace {

class Gpu final : public ThresholdDevice {
 public:
  const std::string& name() const override { return context_.name(); }
  bool is_software() const override { return context_.is_software(); }
  bool process(const TableView& table, const ImageView& image, const RowsThere& rows,
               LabelImage& labels) noexcept override {
    return threshold_.process(table, nullptr, image, labels, nullptr, &rows);
  }
  const std::string& problem() const override { return threshold_.problem(); }
  bool is_lost() const override { return context_.is_lost(); }

 private:
  GpuContext context_;
  GpuThreshold threshold_{context_};
};

}  // namespace

std::unique_ptr<ThresholdDevice> open_gpu() {
  return std::make_unique<Gpu>();
}

}  // namespace sslv
