// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vision/disc_kernel.h"
#include "vision/segment_kernel.h"

#include <cstdint>
#include <string>
#include <vector>

#include <hwy/highway.h>

namespace sslv {

/// While it exists, Highway's dynamic dispatch behaves in the whole process as on a CPU whose best
/// instruction set is `best`. Kernels not compiled for that set use the next best one.
class OnlyTarget {
 public:
  explicit OnlyTarget(std::int64_t best) {
    use(hwy::SupportedTargets() & ~(best - 1));  // lower bits are better targets
  }
  ~OnlyTarget() { use(0); }
  OnlyTarget(const OnlyTarget&) = delete;
  OnlyTarget& operator=(const OnlyTarget&) = delete;

 private:
  static void use(std::int64_t targets) {
    hwy::SetSupportedTargetsForTest(targets);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
  }
};

inline std::string name_of_target(std::int64_t target) {
  return hwy::TargetName(target);
}

/// Instruction sets of this CPU that some kernel is compiled for, best first; the last one is the baseline of
/// all CPUs.
inline std::vector<std::int64_t> cpu_targets() {
  std::vector<std::int64_t> targets;
  for (std::int64_t left = hwy::SupportedTargets(); left != 0; left &= left - 1) {
    const std::int64_t target = left & -left;
    const OnlyTarget only(target);
    const std::string name = name_of_target(target);
    if (search_runs_target() == name || disc_kernel_target() == name) targets.push_back(target);
  }
  return targets;
}

}  // namespace sslv
