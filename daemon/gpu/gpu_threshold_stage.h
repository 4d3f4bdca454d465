// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/params.h"
#include "gpu/gpu_choice.h"
#include "gpu/gpu_worker.h"
#include "image/image.h"
#include "pipeline/stage_notes.h"
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

/// Threshold (vision/threshold.h), on a GPU where there is one that is faster: the same labels, bit by bit.
/// The CPU labels every image that no GPU labels in time: while one is opened, lost, or hangs.
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
                 "the GPU: when_faster measures it and the CPU on the camera's own images; "
                 "always also when it is slower; never leaves it alone")};
    }
  };

  struct Limits {
    /// An image waits so long for the GPU, or twice the time that the CPU takes, if that is more.
    std::chrono::nanoseconds shortest_deadline = std::chrono::milliseconds(10);
    /// One that is not ready by then hangs.
    std::chrono::nanoseconds longest_opening = std::chrono::seconds(30);
    GpuWorker::Limits worker{};
  };

  GpuThresholdStage() : GpuThresholdStage(&open_gpu, Limits()) {}
  GpuThresholdStage(OpenDevice open, const Limits& limits);

  void process(const Params& params, const Lut& lut, const Mask& mask, const Image& image, LabelImage& labels,
               StageNotes& notes) noexcept;

  /// The last image's labels are a GPU's.
  bool was_on_gpu() const { return was_on_gpu_; }

 private:
  /// What the admin was told last, so that it is said once.
  struct Told {
    enum class Kind : std::uint8_t {
      kNothing,
      kNever,
      kNoThread,
      kHangs,
      kSoftware,
      kMeasuring,
      kMeasured,
      kStatus,  // the worker's
    };
    Kind kind = Kind::kNothing;
    Use use = Use::kWhenFaster;
    int number = 0;  // of the status or the measurement
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
  std::unique_ptr<GpuWorker> worker_;  // from the first image on that may need it
  bool has_no_thread_ = false;
  GpuChoice choice_;
  int measured_status_ = -1;                               // number of that which `choice_` is about
  std::chrono::steady_clock::time_point opening_since_{};  // 0: it is not being opened
  bool was_on_gpu_ = false;
  Told told_;
};

}  // namespace sslv
