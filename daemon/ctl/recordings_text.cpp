// SPDX-License-Identifier: Apache-2.0
#include "ctl/recordings_text.h"

#include "ctl/table.h"

#include <algorithm>
#include <cstdint>
#include <vector>

#include <fmt/format.h>

namespace sslv {

std::string clock_text(double seconds) {
  const auto whole = static_cast<long>(std::max(0.0, seconds));
  if (whole < 3600) return fmt::format("{}:{:02}", whole / 60, whole % 60);
  return fmt::format("{}:{:02}:{:02}", whole / 3600, whole / 60 % 60, whole % 60);
}

std::string size_text(double bytes) {
  return fmt::format("{:.1f} MB", bytes * 1e-6);
}

std::string recordings_text(const Json& recordings) {
  const Json& now = recordings.at("match_log");
  const std::string state = now.at("state").get<std::string>();
  std::string out = fmt::format("match log: {}", state);
  if (!now.at("name").is_null())
    out += fmt::format(" {}, {}, {}", now.at("name").get<std::string>(),
                       clock_text(now.at("seconds").get<double>()), size_text(now.at("bytes").get<double>()));
  if (const std::string error = now.at("error").get<std::string>(); !error.empty())
    out += fmt::format(": {}", error);
  const Json& disk = recordings.at("disk");
  out += fmt::format("\ndisk: {} of {} used, {} free\n", size_text(disk.at("used_bytes").get<double>()),
                     size_text(disk.at("quota_bytes").get<double>()),
                     size_text(disk.at("free_bytes").get<double>()));
  std::vector<std::vector<std::string>> rows;
  for (const Json& log : recordings.at("logs")) {
    rows.push_back({log.at("name").get<std::string>(),
                    log.at("seconds").is_null() ? "" : clock_text(log.at("seconds").get<double>()),
                    size_text(log.at("bytes").get<double>()), log.at("pinned").get<bool>() ? "pinned" : "",
                    log.at("problem").get<std::string>()});
  }
  if (!rows.empty()) out += "\n" + table_text({{"log"}, {"length", true}, {"size", true}, {""}, {""}}, rows);
  return out;
}

std::string clips_text(const Json& clips) {
  std::string out = "in memory:";
  for (const Json& camera : clips.at("last_seconds").at("cameras")) {
    out += fmt::format(" camera {} {:.1f} s", camera.at("id").get<int>(), camera.at("seconds").get<double>());
    if (const auto dropped = camera.at("dropped").get<std::uint64_t>(); dropped > 0)
      out += fmt::format(" ({} frames dropped)", dropped);
    out += ",";
  }
  out += fmt::format(" {}\n", size_text(clips.at("last_seconds").at("memory_bytes").get<double>()));
  if (const auto problem = clips.at("last_seconds").at("problem").get<std::string>(); !problem.empty())
    out += problem + "\n";
  const Json& now = clips.at("clip");
  if (now.at("state") != "idle")
    out +=
        fmt::format("clip: {} {}\n", now.at("state").get<std::string>(), now.at("error").get<std::string>());
  std::vector<std::vector<std::string>> rows;
  for (const Json& clip : clips.at("clips")) {
    rows.push_back(
        {clip.at("name").get<std::string>(),
         clip.at("seconds").is_null() ? "" : fmt::format("{:.1f} s", clip.at("seconds").get<double>()),
         size_text(clip.at("bytes").get<double>()), clip.at("pinned").get<bool>() ? "pinned" : "",
         clip.at("why").get<std::string>(), clip.at("problem").get<std::string>()});
  }
  if (!rows.empty())
    out += "\n" + table_text({{"clip"}, {"length", true}, {"size", true}, {""}, {"why"}, {""}}, rows);
  return out;
}

}  // namespace sslv
