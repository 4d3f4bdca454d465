// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vision/disc_kernel.h"
#include "vision/segment_kernel.h"

#include <cstdint>
#include <string>
#include <vector>

#include <hwy/highway.h>

namespace sslv {

/// Has Highway's dynamic dispatch choose as on a CPU whose best instruction set is `best`, in the whole
/// process, while it lives. Kernels that are not compiled for that set use the next best one.
class OnlyTarget {
 public:
  explicit OnlyTarget(std::int64_t best) {
    use(hwy::SupportedTargets() & ~(best - 1));  // a lower bit is a better target
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

/// Instruction sets that this CPU has and any kernel is compiled for, best first; the last one is what any
/// CPU has.
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
