// SPDX-License-Identifier: Apache-2.0
#include "ctl/history.h"

#include <cstddef>
#include <ctime>

#include <fmt/chrono.h>
#include <fmt/format.h>

namespace sslv {
namespace {

/// Short: a whole camera would fill the terminal.
std::string shortened(const Json& change, const char* key) {
  constexpr std::size_t kLongest = 40;
  if (!change.contains(key)) return "nothing";
  const std::string text = change.at(key).dump();
  return text.size() <= kLongest ? text : text.substr(0, kLongest - 3) + "...";
}

}  // namespace

std::string history_text(const Json& history) {
  std::string out;
  for (const Json& step : history) {
    const auto time = static_cast<std::time_t>(step.at("time").get<double>());
    const std::string what = step.at("what").get<std::string>();
    out += fmt::format("{:>5}  {:%Y-%m-%d %H:%M:%S}  {}{}\n", step.at("revision").get<std::uint64_t>(),
                       fmt::localtime(time), step.at("who").get<std::string>(),
                       what.empty() ? "" : "  (" + what + ")");
    for (const Json& change : step.at("changes")) {
      out += fmt::format("       {}: {} -> {}\n", change.at("path").get<std::string>(),
                         shortened(change, "before"), shortened(change, "after"));
    }
  }
  return out.empty() ? "nothing was changed yet\n" : out;
}

}  // namespace sslv
