// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/params.h"
#include "base/stage_notes.h"
#include "gpu/gpu_choice.h"
#include "gpu/gpu_worker.h"
#include "image/image.h"
#include "vision/lut.h"
#include "vision/mask.h"
#include "vision/regions.h"
#include "vision/threshold.h"

#include <array>
#include <chrono>
#include <cstdint>
#include <memory>
#include <tuple>

namespace sslv {

/// Threshold (vision/threshold.h), on a GPU if it is faster: bit-identical labels. The CPU labels every image
/// that no GPU labels in time: while the GPU is being opened, is lost, or hangs.
class GpuThresholdStage {
 public:
  enum class Use : std::uint8_t { kWhenFaster, kAlways, kNever };

  struct Params {
    Use use = Use::kWhenFaster;
    static constexpr auto fields() {
      return std::tuple{
          choice("use", &Params::use,
                 std::array{Choice<Use>{"when_faster", Use::kWhenFaster}, Choice<Use>{"always", Use::kAlways},
                            Choice<Use>{"never", Use::kNever}},
                 "use of the GPU: when_faster measures it and the CPU on the camera's own images; always "
                 "uses it even if it is slower; never leaves it alone")};
    }
  };

  struct Limits {
    /// An image waits at most this long for the GPU, or twice the CPU's time if that is more.
    std::chrono::nanoseconds shortest_deadline = std::chrono::milliseconds(10);
    /// A GPU that is not ready after this time counts as hung.
    std::chrono::nanoseconds longest_opening = std::chrono::seconds(30);
    GpuWorker::Limits worker{};
  };

  GpuThresholdStage() : GpuThresholdStage(&open_gpu, Limits()) {}
  GpuThresholdStage(OpenDevice open, const Limits& limits);

  void process(const Params& params, const Lut& lut, const Mask& mask, const Image& image, LabelImage& labels,
               StageNotes& notes) noexcept;

  /// Whether a GPU computed the last image's labels.
  bool was_on_gpu() const { return was_on_gpu_; }

 private:
  /// The last note for the admin, so that each note is reported once.
  struct Told {
    enum class Kind : std::uint8_t {
      kNothing,
      kNever,
      kNoThread,
      kHangs,
      kSoftware,
      kMeasuring,
      kMeasured,
      kStatus,  // the worker's status
    };
    Kind kind = Kind::kNothing;
    Use use = Use::kWhenFaster;
    int number = 0;  // number of the worker's status or of the measurement
    bool operator==(const Told&) const = default;
  };

  bool start(Use use);
  bool label_on_gpu(const Lut& lut, const Mask& mask, const ImageView& image, LabelImage& labels);
  bool hangs(const GpuWorker::Status& status, bool is_ready, std::chrono::steady_clock::time_point now);
  Told told_now(Use use, const GpuWorker::Status& status, bool is_ready) const;
  void tell(const Told& now, const GpuWorker::Status& status, StageNotes& notes);
  static void say_status(const GpuWorker::Status& status, bool is_wanted, StageNotes& notes);

  const OpenDevice open_;
  const Limits limits_;
  Threshold cpu_;
  std::unique_ptr<GpuWorker> worker_;  // created for the first image that may need it
  bool has_no_thread_ = false;
  GpuChoice choice_;
  int measured_status_ = -1;                               // number of the status that `choice_` measures
  std::chrono::steady_clock::time_point opening_since_{};  // 0: not opening
  bool was_on_gpu_ = false;
  Told told_;
};

}  // namespace sslv
