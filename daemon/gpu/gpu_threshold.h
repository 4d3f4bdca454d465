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

/// The labels of one table, ordered as LutTable has them: a Lut's own, or a copy of them.
struct TableView {
  std::uint64_t lut_id = 0;  // of the Lut that they are from
  bool is_rgb = false;       // its table over RGB, else the one over YUV
  int bits = LutTable::kBits;
  std::span<const Label> labels;
};
/// The table that labels images of this format.
TableView table_for(const Lut& lut, PixelFormat format);

/// Threshold (vision/threshold.h) on the GPU: the same labels, bit by bit, of every format, size, stride,
/// table and mask.
class GpuThreshold {
 public:
  enum class Path : std::uint8_t {
    kCompute,   // OpenGL ES 3.1
    kFragment,  // OpenGL ES 3.0
  };
  /// What one image took, measured with waits between the steps, so that all of them together take longer
  /// than an image that is not measured.
  struct Steps {
    std::chrono::nanoseconds upload, shader, read_back;
  };

  /// The context stays longer than this. Throws GpuError when it does not have this path.
  GpuThreshold(GpuContext& context, Path path);
  /// By compute shaders where there are any.
  explicit GpuThreshold(GpuContext& context)
      : GpuThreshold(context, context.has_compute() ? Path::kCompute : Path::kFragment) {}
  ~GpuThreshold();

  /// Makes the next images of this format quicker, when it is called before the first one: takes the table to
  /// the GPU and makes the program. False as of process().
  bool set_lut(const Lut& lut, PixelFormat format) noexcept;

  /// Blocks until the labels are there. False: they are not, and the CPU must make them; problem() says why.
  /// After a lost context (GpuContext::is_lost) that is so for ever; images that are too large for this GPU
  /// do not keep it from others.
  bool process(const Lut& lut, const Mask& mask, const Image& image, LabelImage& labels,
               Steps* steps = nullptr) noexcept {
    return process(table_for(lut, image.view().format), &mask, image.view(), labels, steps);
  }
  /// Likewise; `table` is that for the image's format. Without a mask all of the image is labelled. Where
  /// `rows` are given, the image's rows are read as they come.
  bool process(const TableView& table, const Mask* mask, const ImageView& view, LabelImage& labels,
               Steps* steps = nullptr, const RowsThere* rows = nullptr) noexcept;

  Path path() const { return path_; }
  /// Of the last call that gave false; a few words.
  const std::string& problem() const { return problem_; }

 private:
  struct Pass;
  struct Timer;
  bool fail(std::string problem);
  void start_again();
  bool load(const TableView& table, PixelFormat format);
  bool make_labels(const GroupedImage& grouped, const Mask* mask, const ImageView& view, LabelImage& labels,
                   Steps* steps, const RowsThere* rows);

  GpuContext& context_;
  Path path_;
  std::unique_ptr<Pass> pass_;
  std::unique_ptr<Timer> timer_;
  /// The table in the GPU's memory: its id, and whether it is the one over RGB.
  std::optional<std::pair<std::uint64_t, bool>> loaded_;
  std::string problem_;
};

}  // namespace sslv
