// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "gpu/gpu_context.h"
#include "gpu/rows_there.h"
#include "image/image.h"
#include "vision/lut.h"
#include "vision/mask.h"
#include "vision/regions.h"

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>

namespace sslv {

struct GroupedImage;
class ThresholdPass;

/// View of the labels of one colour table, in LutTable's order: a Lut's own labels or a copy.
struct TableView {
  std::uint64_t lut_id = 0;  // id of the Lut with these labels
  bool is_rgb = false;       // the Lut's RGB table, otherwise its YUV table
  int bits = LutTable::kBits;
  std::span<const Label> labels;
};
/// The table for images of this format.
TableView table_for(const Lut& lut, PixelFormat format);

/// Threshold (vision/threshold.h) on the GPU: bit-identical labels for every format, size, stride, table and
/// mask.
class GpuThreshold {
 public:
  /// Durations of the steps for one image. A measurement waits between the steps, so their sum exceeds the
  /// time of an unmeasured image.
  struct Steps {
    std::chrono::nanoseconds upload, shader, read_back;
  };

  /// `context` must outlive this object. Throws GpuError if the context is lost or in use.
  explicit GpuThreshold(GpuContext& context);
  ~GpuThreshold();

  /// Optional: uploads the table and builds the program before the first image of this format. Returns false
  /// for the same reasons as process().
  bool set_lut(const Lut& lut, PixelFormat format) noexcept;

  /// Blocks until the labels are complete. False: no labels were made, and the CPU must make them; problem()
  /// gives the reason. The failure is permanent after a lost context (GpuContext::is_lost); after an image
  /// that is too large for this GPU, other images still work.
  bool process(const Lut& lut, const Mask& mask, const Image& image, LabelImage& labels,
               Steps* steps = nullptr) noexcept {
    return process(table_for(lut, image.view().format), &mask, image.view(), labels, steps);
  }
  /// Like process() above, but with the `table` for the image's format. Without a mask, labels the whole
  /// image. With `rows`, reads the image's rows as they become available.
  bool process(const TableView& table, const Mask* mask, const ImageView& view, LabelImage& labels,
               Steps* steps = nullptr, const RowsThere* rows = nullptr) noexcept;

  /// The reason of the last failed call, in a few words.
  const std::string& problem() const { return problem_; }

 private:
  struct Timer;
  bool fail(std::string problem);
  void start_again();
  bool load(const TableView& table, PixelFormat format);
  bool make_labels(const GroupedImage& grouped, const Mask* mask, const ImageView& view, LabelImage& labels,
                   Steps* steps, const RowsThere* rows);

  GpuContext& context_;
  std::unique_ptr<ThresholdPass> pass_;  // destroyed with the context
  std::unique_ptr<Timer> timer_;
  /// The table in the GPU's memory: its Lut's id, and whether it is the RGB table.
  std::optional<std::pair<std::uint64_t, bool>> loaded_;
  std::string problem_;
};

}  // namespace sslv
