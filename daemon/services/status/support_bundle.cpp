// SPDX-License-Identifier: Apache-2.0
#include "services/status/support_bundle.h"

#include "base/log.h"
#include "health/computer.h"
#include "web/tar_file.h"

#include <cstdint>
#include <ctime>
#include <exception>
#include <utility>

#include <fmt/chrono.h>

namespace sslv {
std::string log_text() {
  std::string out;
  const auto recent = log::recent().newer_than(0, log::Level::kDebug);
  for (const auto& line : recent.lines) {
    const auto milliseconds = static_cast<std::int64_t>(line.time_s * 1e3);
    out += fmt::format("{:%Y-%m-%dT%H:%M:%S}.{:03}Z {:7} {}\n",
                       fmt::gmtime(static_cast<std::time_t>(milliseconds / 1000)), milliseconds % 1000,
                       log::name_of(line.level), line.text);
  }
  return out;
}

Response support_bundle(const std::vector<SupportFile>& files,
                        const std::optional<SupportRecording>& recording, const std::stop_token& stop) {
  const std::time_t now = std::time(nullptr);
  const std::string folder = fmt::format("ssl-visiond-{}-{:%Y%m%d-%H%M%S}", host_name(), fmt::gmtime(now));
  std::string readme = fmt::format(
      "State of ssl-visiond on this computer at {:%Y-%m-%d %H:%M:%S} UTC, for a bug report. Check it\n"
      "before you share it: it contains images of the hall, addresses of clients and every setting.\n\n",
      fmt::gmtime(now));
  std::vector<TarEntry> entries(1);
  for (const SupportFile& file : files) {
    readme += fmt::format("{}: {}", file.name, file.what);
    try {
      entries.push_back({folder + "/" + file.name, file.make()});
    } catch (const std::exception& error) {  // the rest is still useful
      readme += fmt::format("; missing: {}", error.what());
    }
    readme += "\n";
  }
  if (!recording) {
    entries.front() = {folder + "/README.txt", readme};
    Response response{200, "application/gzip", tar_gz(entries, now, stop)};
    response.headers.emplace_back("Content-Disposition",
                                  fmt::format("attachment; filename=\"{}.tar.gz\"", folder));
    return response;
  }
  const std::string name = recording->file.filename().string();
  SentFile file = open_file(recording->file, name);
  readme += fmt::format("{}: {}\n", name, recording->what);
  entries.front() = {folder + "/README.txt", readme};
  TarAround around = tar_around(entries, folder + "/" + name, file.bytes, now);
  file.before = std::move(around.before);
  file.after = std::move(around.after);
  return file_response(std::move(file), "application/x-tar", folder + ".tar");
}

}  // namespace sslv
