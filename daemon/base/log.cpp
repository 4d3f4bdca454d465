// SPDX-License-Identifier: Apache-2.0
#include "base/log.h"

#include "base/clock.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <sys/stat.h>
#include <sys/uio.h>
#include <syslog.h>
#define SD_JOURNAL_SUPPRESS_LOCATION  // the location would always be in this file
#include <systemd/sd-journal.h>
#include <unistd.h>

namespace sslv::log {
namespace {

// The logger and the ring buffer are never destroyed, because code that ends after main() may still log.

spdlog::logger& logger() {
  static const auto& made = *new auto([] {
    auto one = spdlog::stderr_color_mt("ssl-visiond");
    one->set_pattern("%H:%M:%S.%e %^%l%$ %v");
    one->flush_on(spdlog::level::info);
    return one;
  }());
  return *made;
}

spdlog::level::level_enum to_spdlog(Level level) {
  switch (level) {
    case Level::kDebug: return spdlog::level::debug;
    case Level::kInfo: return spdlog::level::info;
    case Level::kWarning: return spdlog::level::warn;
    case Level::kError: return spdlog::level::err;
  }
  return spdlog::level::info;
}

/// Whether standard error is a stream to the journal: systemd.exec(5), $JOURNAL_STREAM.
bool is_journal() {
  const char* stream = std::getenv("JOURNAL_STREAM");
  struct stat about {};
  return stream != nullptr && ::fstat(STDERR_FILENO, &about) == 0 &&
         fmt::format("{}:{}", about.st_dev, about.st_ino) == stream;
}

/// The number in "camera 3: lost".
std::string_view camera_in(std::string_view message) {
  constexpr std::string_view kPrefix = "camera ";
  if (!message.starts_with(kPrefix)) return {};
  message.remove_prefix(kPrefix.size());
  return message.substr(0, std::min(message.find_first_not_of("0123456789"), message.size()));
}

void write_to_journal(Level level, std::string_view message) {
  constexpr std::array kPriorities{LOG_DEBUG, LOG_INFO, LOG_WARNING, LOG_ERR};
  std::vector<std::string> fields{fmt::format("MESSAGE={}", message),
                                  fmt::format("PRIORITY={}", kPriorities[static_cast<std::size_t>(level)])};
  if (const auto camera = camera_in(message); !camera.empty())
    fields.push_back(fmt::format("CAMERA={}", camera));
  if (message.starts_with("audit: ")) fields.push_back(fmt::format("MESSAGE_ID={}", kAuditId));
  std::vector<iovec> parts;
  for (std::string& field : fields) parts.push_back({field.data(), field.size()});
  sd_journal_sendv(parts.data(), static_cast<int>(parts.size()));
}

LogRing& ring() {
  static auto& lines = *new LogRing;
  return lines;
}

}  // namespace

void set_level(Level level) {
  logger().set_level(to_spdlog(level));
}

void write(Level level, std::string_view message) {
  if (!logger().should_log(to_spdlog(level))) return;
  ring().add(unix_time_s(), level, message);
  static const bool kJournal = is_journal();
  if (kJournal) return write_to_journal(level, message);
  logger().log(to_spdlog(level), spdlog::string_view_t(message.data(), message.size()));
}

const LogRing& recent() {
  return ring();
}

}  // namespace sslv::log
