// SPDX-License-Identifier: Apache-2.0
#include "ctl/backup_text.h"

#include "ctl/change_text.h"

#include <cstdint>
#include <ctime>

#include <fmt/chrono.h>

namespace sslv {
namespace {

std::string held_text(const Json& contents) {
  const auto time = static_cast<std::time_t>(contents.at("time").get<double>());
  std::string cameras, profiles;
  for (const Json& camera : contents.at("cameras")) {
    const auto name = camera.at("name").get<std::string>();
    cameras += fmt::format("{}{}{}", cameras.empty() ? "" : ", ", camera.at("id").get<int>(),
                           name.empty() ? "" : " (" + name + ")");
  }
  for (const Json& profile : contents.at("profiles"))
    profiles += (profiles.empty() ? "" : ", ") + profile.get<std::string>();
  const bool has_passwords = contents.at("passwords").get<bool>();
  std::string out = fmt::format(
      "made          {:%Y-%m-%d %H:%M:%S} UTC\n"
      "computer      {}\n"
      "site          {}\n"
      "program       ssl-visiond {}\n"
      "cameras       {}\n"
      "tables        {}\n"
      "profiles      {}\n"
      "calibrations  {}\n"
      "history       {} steps\n"
      "passwords     {}\n",
      fmt::gmtime(time), contents.at("computer").get<std::string>(), contents.at("site").get<std::string>(),
      contents.at("version").get<std::string>(), cameras.empty() ? "none" : cameras,
      contents.at("tables").get<int>(), profiles.empty() ? "none" : profiles,
      contents.at("calibrations").get<int>(), contents.at("steps").get<int>(),
      !has_passwords                               ? "none"
      : contents.at("keeps_passwords").get<bool>() ? "yes; this computer keeps its own"
                                                   : "yes");
  for (const Json& file : contents.at("files_elsewhere")) {
    out += fmt::format("not in it     {}: {}\n", file.at("path").get<std::string>(),
                       file.at("file").get<std::string>());
  }
  return out;
}

}  // namespace

std::string backup_text(const Json& contents) {
  return held_text(contents) + "\n" + changes_text(contents.at("changes")) +
         "only checked, nothing was restored\n";
}

std::string restored_text(const Json& restored) {
  const auto revision = restored.at("revision").get<std::uint64_t>();
  return held_text(restored.at("backup")) +
         fmt::format("restored, revision {}; `ssl-visionctl undo {}` restores the previous settings\n",
                     revision, revision);
}

}  // namespace sslv
