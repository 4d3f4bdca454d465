// SPDX-License-Identifier: Apache-2.0
#include "ctl/change_text.h"

#include "ctl/table.h"

#include <cstddef>
#include <cstdint>
#include <vector>

#include <fmt/format.h>

namespace sslv {
namespace {

/// A whole camera would fill the terminal.
std::string shortened(const Json& change, const char* key) {
  constexpr std::size_t kLongest = 40;
  if (!change.contains(key)) return "nothing";
  const std::string text = json_text(change.at(key));
  return text.size() <= kLongest ? text : text.substr(0, kLongest - 3) + "...";
}

}  // namespace

std::string change_text(const Json& change) {
  return fmt::format("{}: {} -> {}", change.at("path").get<std::string>(), shortened(change, "before"),
                     shortened(change, "after"));
}

std::string changes_text(const Json& changes) {
  std::string out;
  for (const Json& change : changes) out += change_text(change) + "\n";
  return out.empty() ? "nothing changes\n" : out;
}

std::string history_text(const Json& history) {
  std::string out;
  for (const Json& step : history) {
    const std::string what = step.at("what").get<std::string>();
    out += fmt::format("{:>5}  {}  {}{}\n", step.at("revision").get<std::uint64_t>(),
                       local_time_text(step.at("time").get<double>()), step.at("who").get<std::string>(),
                       what.empty() ? "" : "  (" + what + ")");
    for (const Json& change : step.at("changes")) out += "       " + change_text(change) + "\n";
  }
  return out.empty() ? "nothing was changed yet\n" : out;
}

std::string profiles_text(const Json& profiles) {
  if (profiles.empty()) return "no profiles yet\n";
  std::vector<std::vector<std::string>> rows;
  for (const Json& profile : profiles) {
    rows.push_back({profile.at("name").get<std::string>(), local_time_text(profile.at("time").get<double>()),
                    profile.at("who").get<std::string>()});
  }
  return table_text({{"profile"}, {"saved"}, {"by"}}, rows);
}

std::string profile_text(const Json& profile) {
  return profiles_text(Json::array({profile})) + "\napplying it now:\n" + changes_text(profile.at("changes"));
}

}  // namespace sslv
