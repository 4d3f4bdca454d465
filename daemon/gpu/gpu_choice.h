// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <optional>

namespace sslv {

/// What the labels of one image take.
struct LabelCost {
  std::chrono::nanoseconds time{};      // until they are there
  std::chrono::nanoseconds cpu_time{};  // of processors, all our threads together
};

/// Whether the CPU or the GPU labels the next image: they take turns until both have been measured on so many
/// of the camera's images that their medians say who is faster. Measured again every hour, and when the GPU
/// has become slower than the CPU was. No clock, no thread: times are given to it.
class GpuChoice {
 public:
  using TimePoint = std::chrono::steady_clock::time_point;
  /// Images each; the first ones, which find caches cold, do not count.
  static constexpr std::size_t kImages = 20, kWarmUp = 2;
  /// Images on the GPU of which more than half took longer than the CPU's median: measured again.
  static constexpr std::size_t kWatched = 64;
  static constexpr std::chrono::hours kEvery{1};
  /// A GPU has to be so much faster: what is nearly the same would change with every measurement.
  static constexpr double kGain = 0.9;

  struct Measured {
    LabelCost gpu, cpu;  // medians
    bool gpu_is_faster() const {
      return static_cast<double>(gpu.time.count()) < kGain * static_cast<double>(cpu.time.count());
    }
  };

  /// Measures both again: another GPU, other images.
  void begin();
  /// Where the GPU is ready: whether it labels the next image. `always`: also when it is slower.
  bool gpu_is_next(bool always) const;
  /// What an image took by whom it was labelled, or by both where the GPU did not do it in time.
  void took(bool by_gpu, const LabelCost& cost, TimePoint now);

  /// None while they are being measured for the first time since begin().
  const std::optional<Measured>& measured() const { return measured_; }
  /// Of measurements: another number, other figures.
  int number() const { return number_; }
  /// The CPU's median so far; zero: none yet.
  std::chrono::nanoseconds cpu_time_so_far() const;

 private:
  /// What one of the two took.
  struct Side {
    std::array<LabelCost, kImages> costs{};
    std::size_t seen = 0;  // with those that do not count
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
