// SPDX-License-Identifier: Apache-2.0
#include "gpu/gpu_choice.h"

#include <algorithm>

namespace sslv {

void GpuChoice::Side::add(const LabelCost& cost) {
  if (is_full()) return;
  ++seen;
  if (count() > 0) costs[count() - 1] = cost;
}

LabelCost GpuChoice::Side::median() const {
  if (count() == 0) return {};
  std::array<LabelCost, kImages> sorted = costs;
  const auto end = sorted.begin() + static_cast<std::ptrdiff_t>(count());
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(count() / 2);
  LabelCost found;
  for (const auto member : {&LabelCost::time, &LabelCost::cpu_time}) {
    std::nth_element(sorted.begin(), middle, end,
                     [member](const LabelCost& a, const LabelCost& b) { return a.*member < b.*member; });
    found.*member = (*middle).*member;
  }
  return found;
}

void GpuChoice::measure_again() {
  gpu_ = cpu_ = Side{};
  watched_ = slow_ = 0;
  is_measuring_ = true;
}

void GpuChoice::begin() {
  measure_again();
  measured_.reset();
}

bool GpuChoice::gpu_is_next(bool always) const {
  if (is_measuring_) return gpu_.seen < cpu_.seen;
  return always || measured_->gpu_is_faster();
}

void GpuChoice::took(bool by_gpu, const LabelCost& cost, TimePoint now) {
  if (is_measuring_) {
    (by_gpu ? gpu_ : cpu_).add(cost);
    if (!gpu_.is_full() || !cpu_.is_full()) return;
    is_measuring_ = false;
    measured_ = {gpu_.median(), cpu_.median()};
    measured_at_ = now;
    ++number_;
    return;
  }
  if (now - measured_at_ >= kEvery) return measure_again();
  // The admin requires this GPU although it is not faster: do not watch its times.
  if (!by_gpu || !measured_->gpu_is_faster()) return;
  slow_ += cost.time > measured_->cpu.time ? 1 : 0;
  if (++watched_ < kWatched) return;
  if (slow_ > kWatched / 2) return measure_again();
  watched_ = slow_ = 0;
}

std::chrono::nanoseconds GpuChoice::cpu_time_so_far() const {
  return is_measuring_ && !measured_ ? cpu_.median().time : measured_->cpu.time;
}

}  // namespace sslv
