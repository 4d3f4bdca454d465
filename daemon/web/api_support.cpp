// SPDX-License-Identifier: Apache-2.0
#include "base/log.h"
#include "web/api.h"
#include "web/http.h"
#include "web/picture.h"
#include "web/tar_file.h"

#include <array>
#include <cctype>
#include <cstdint>
#include <ctime>
#include <functional>

#include <fmt/chrono.h>
#include <httplib.h>
#include <unistd.h>

namespace sslv {
namespace {

struct BundleFile {
  std::string name;
  std::string what;  // for the README
  std::function<std::string()> make;
};

std::string pretty(const Json& json) {
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string full_picture(const WebHost& host, std::uint32_t camera_id) {
  const std::optional<View> view = host.wait_view(camera_id, 0, std::chrono::milliseconds(0));
  if (!view) throw HttpError(503, "no picture yet");
  std::vector<std::uint8_t> unused;
  const Picture picture = picture_of(*view, PictureKind::kCamera, unused);
  JpegEncoder encoder;
  const std::span<const std::uint8_t> jpeg =
      encoder.encode(picture.image, picture.image.width, 90, picture.chroma);
  return {jpeg.begin(), jpeg.end()};
}

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

/// All that a bundle holds. There is no secret in it: the settings hold none (see Passwords).
std::vector<BundleFile> bundle_files(const WebHost& host) {
  std::vector<BundleFile> files{
      {"version.txt", "the program's version",
       [&] { return host.status().at("version").get<std::string>() + "\n"; }},
      {"status.json", "cameras, network, alerts, as /api/status has them",
       [&] { return pretty(host.status()); }},
      {"settings.json", "all settings in force, with defaults", [&] { return pretty(host.settings()); }},
      {"settings_history.json", "who changed which setting, with the clients' addresses",
       [&] { return pretty(host.settings_history()); }},
      {"diagnostics.json", "this computer, its clock, how long every stage takes",
       [&] { return pretty(host.diagnostics()); }},
      {"timeline.json", "the last ten minutes, second by second", [&] { return pretty(host.timeline(600)); }},
      {"log.txt", "the last lines of the log", log_text},
  };
  for (const std::uint32_t id : host.camera_ids()) {
    const std::string camera = fmt::format("camera_{}", id);
    files.push_back({camera + "/calibration.json", "its calibrations: reports, figures, history",
                     [&host, id] { return pretty(host.calibration(id)); }});
    files.push_back({camera + "/picture.jpg", "its newest picture, in full size",
                     [&host, id] { return full_picture(host, id); }});
  }
  return files;
}

/// This computer's name, as far as it may stand in a file's.
std::string host_name() {
  std::array<char, 65> name{};
  gethostname(name.data(), name.size() - 1);
  std::string out;
  for (const char c : std::string_view(name.data())) {
    if (std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '-') out += c;
  }
  return out.empty() ? "unnamed" : out;
}

}  // namespace

void get_support(const WebHost& host, const httplib::Request&, httplib::Response& response) {
  const std::time_t now = std::time(nullptr);
  const std::string folder = fmt::format("ssl-visiond-{}-{:%Y%m%d-%H%M%S}", host_name(), fmt::gmtime(now));
  std::string readme = fmt::format(
      "What ssl-visiond on this computer was like at {:%Y-%m-%d %H:%M:%S} UTC, for a bug report. Look "
      "through it\n"
      "before you hand it on: it has pictures of the hall, addresses of clients and every setting.\n\n",
      fmt::gmtime(now));
  std::vector<TarEntry> entries(1);
  for (const BundleFile& file : bundle_files(host)) {
    readme += fmt::format("{}: {}", file.name, file.what);
    try {
      entries.push_back({folder + "/" + file.name, file.make()});
    } catch (const std::exception& error) {  // the rest is worth having all the same
      readme += fmt::format("; missing: {}", error.what());
    }
    readme += "\n";
  }
  entries.front() = {folder + "/README.txt", readme};
  const std::string bytes = tar_gz(entries, now);
  response.set_header("Content-Disposition", fmt::format("attachment; filename=\"{}.tar.gz\"", folder));
  response.set_content(bytes, "application/gzip");
}

}  // namespace sslv
