// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <optional>

namespace sslv {

/// The cost of labelling one image.
struct LabelCost {
  std::chrono::nanoseconds time{};      // time until the labels are complete
  std::chrono::nanoseconds cpu_time{};  // processor time of all our threads together
};

/// Chooses whether the CPU or the GPU labels the next image. CPU and GPU alternate until each has labelled
/// kImages of the camera's images; then the side with the lower median time is chosen. Measures again every
/// hour, and when the GPU has become slower than the CPU's last median. Has no clock and no thread: the
/// caller passes the times.
class GpuChoice {
 public:
  using TimePoint = std::chrono::steady_clock::time_point;
  /// Measured images per side. The kWarmUp images before these, with cold caches, are not counted.
  static constexpr std::size_t kImages = 20, kWarmUp = 2;
  /// Measure again if more than half of this many GPU images took longer than the CPU's median.
  static constexpr std::size_t kWatched = 64;
  static constexpr std::chrono::hours kEvery{1};
  /// The GPU wins only below this fraction of the CPU's time; otherwise the choice between nearly equal times
  /// would change with each measurement.
  static constexpr double kGain = 0.9;

  struct Measured {
    LabelCost gpu, cpu;  // medians
    bool gpu_is_faster() const {
      return static_cast<double>(gpu.time.count()) < kGain * static_cast<double>(cpu.time.count());
    }
  };

  /// Restarts both measurements, for another GPU or other images.
  void begin();
  /// Whether the GPU, which must be ready, labels the next image. `always`: use the GPU even if it is slower.
  bool gpu_is_next(bool always) const;
  /// Adds the cost of an image. If the GPU did not finish in time, the cost includes both the GPU's attempt
  /// and the CPU's labelling.
  void took(bool by_gpu, const LabelCost& cost, TimePoint now);

  /// Empty during the first measurement since begin().
  const std::optional<Measured>& measured() const { return measured_; }
  /// Number of completed measurements; changes with measured().
  int number() const { return number_; }
  /// The CPU's median so far; zero before the first image.
  std::chrono::nanoseconds cpu_time_so_far() const;

 private:
  /// The costs of one side, CPU or GPU.
  struct Side {
    std::array<LabelCost, kImages> costs{};
    std::size_t seen = 0;  // includes the warm-up images
    std::size_t count() const { return seen > kWarmUp ? seen - kWarmUp : 0; }
    bool is_full() const { return count() == kImages; }
    void add(const LabelCost& cost);
    LabelCost median() const;
  };
  void measure_again();

  Side gpu_, cpu_;
  bool is_measuring_ = true;
  std::optional<Measured> measured_;
  TimePoint measured_at_{};
  int number_ = 0;
  std::size_t watched_ = 0, slow_ = 0;
};

}  // namespace sslv
