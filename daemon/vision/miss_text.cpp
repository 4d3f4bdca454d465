// SPDX-License-Identifier: Apache-2.0
#include "vision/miss_text.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

namespace sslv {

std::size_t miss_text(const RobotMiss& miss, std::span<char> text) noexcept {
  const auto write = [&]<class... Args>(fmt::format_string<Args...> format, Args&&... args) {
    return std::min(text.size(),
                    fmt::format_to_n(text.data(), text.size(), format, std::forward<Args>(args)...).size);
  };
  using enum RobotMiss::Why;
  switch (miss.why) {
    case kDots: return write("{} of {} dots are at their places", miss.dots, miss.of);
    case kFit:
      return write("the dots are {:.1f} mm off their places, allowed {:.1f}", miss.value, miss.limit);
    case kColors: return write("the colour of {} of {} dots is certain", miss.dots, miss.of);
    case kTeam: return write("the centre dot has neither team's colour");
    case kId:
      if (miss.value < 1) return write("no id has these colours");
      return write("{:.0f} ids are possible, because a dot's colour is not certain", miss.value);
    case kConfidence: return write("its confidence is {:.2f}, needed {:.2f}", miss.value, miss.limit);
  }
  return 0;
}

}  // namespace sslv
