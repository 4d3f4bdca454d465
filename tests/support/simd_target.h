// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <hwy/highway.h>

namespace sslv {

/// Has Highway's dynamic dispatch use one instruction set only, in the whole process, while it lives.
class OnlyTarget {
 public:
  explicit OnlyTarget(std::int64_t target) { use(target); }
  ~OnlyTarget() { use(0); }
  OnlyTarget(const OnlyTarget&) = delete;
  OnlyTarget& operator=(const OnlyTarget&) = delete;

 private:
  static void use(std::int64_t targets) {
    hwy::SetSupportedTargetsForTest(targets);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
  }
};

/// Instruction sets this CPU has, best first, with SCALAR and EMU128, which any has.
inline std::vector<std::int64_t> cpu_targets() {
  std::vector<std::int64_t> targets;
  // A lower bit is a better target.
  for (std::int64_t left = hwy::SupportedTargets(); left != 0; left &= left - 1)
    targets.push_back(left & -left);
  return targets;
}

inline std::string name_of_target(std::int64_t target) {
  return hwy::TargetName(target);
}

}  // namespace sslv
