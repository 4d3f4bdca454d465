// SPDX-License-Identifier: Apache-2.0
#include "health/computer.h"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <sstream>
#include <system_error>

#include <sys/statvfs.h>
#include <sys/timex.h>
#include <sys/utsname.h>
#include <unistd.h>

namespace sslv {
namespace {

namespace fs = std::filesystem;

/// Content of a file; empty if it cannot be read.
std::string text_of(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// Value of `name` in /proc/meminfo, in bytes; 0 if it is missing.
std::uint64_t memory_bytes(const std::string& meminfo, const std::string& name) {
  std::istringstream lines(meminfo);
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with(name + ":")) continue;
    std::uint64_t kilobytes = 0;
    std::istringstream(line.substr(name.size() + 1)) >> kilobytes;
    return kilobytes * 1024;
  }
  return 0;
}

std::optional<double> hottest_c() {
  std::optional<double> hottest;
  std::error_code error;
  for (const auto& zone : fs::directory_iterator("/sys/class/thermal", error)) {
    double millidegrees = 0;
    std::istringstream text(text_of(zone.path() / "temp"));
    if (text >> millidegrees) hottest = std::max(hottest.value_or(millidegrees * 1e-3), millidegrees * 1e-3);
  }
  return hottest;
}

std::optional<ComputerFigures::Disk> disk_of(fs::path folder) {
  folder = fs::absolute(folder);
  struct statvfs disk {};
  // The folder is missing until something has been saved.
  while (::statvfs(folder.c_str(), &disk) != 0) {
    if (!folder.has_relative_path()) return std::nullopt;
    folder = folder.parent_path();
  }
  return ComputerFigures::Disk{folder, disk.f_blocks * disk.f_frsize, disk.f_bavail * disk.f_frsize};
}

struct ProcessTicks {
  std::uint64_t ticks = 0;
  int threads = 0;
};

/// Reads fields 14, 15 and 20 of /proc/self/stat. The process name before them may contain anything and ends
/// at the last ')'.
ProcessTicks read_process(const std::string& stat) {
  std::istringstream fields(stat.substr(std::min(stat.size(), stat.rfind(')') + 1)));
  std::string skipped;
  for (int field = 3; field < 14; ++field) fields >> skipped;
  std::uint64_t user = 0, system = 0;
  fields >> user >> system;
  for (int field = 16; field < 20; ++field) fields >> skipped;
  ProcessTicks out;
  fields >> out.threads;
  out.ticks = user + system;
  return out;
}

}  // namespace

std::string host_name() {
  std::array<char, 65> name{};
  gethostname(name.data(), name.size() - 1);
  const std::string out = file_name_part(name.data());
  return out.empty() ? "unnamed" : out;
}

std::string file_name_part(std::string_view text) {
  std::string out;
  for (const char c : text) {
    const bool is_kept =
        (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-';
    if (is_kept)
      out += c;
    else if (c == ' ' && !out.empty() && out.back() != '-')
      out += '-';
  }
  while (!out.empty() && out.back() == '-') out.pop_back();
  return out;
}

std::vector<CoreTicks> read_core_ticks(std::string_view proc_stat) {
  std::vector<CoreTicks> cores;
  std::istringstream lines{std::string(proc_stat)};
  for (std::string line; std::getline(lines, line);) {
    // "cpu0 ..."; the line "cpu  ..." has the sum.
    if (!line.starts_with("cpu") || line.size() < 4 || line[3] == ' ') continue;
    std::istringstream words(line);
    std::string name;
    words >> name;
    constexpr int kIdle = 3, kWaiting = 4, kKinds = 8;  // guest ticks follow; user ticks include them
    CoreTicks& core = cores.emplace_back();
    std::uint64_t ticks = 0;
    for (int kind = 0; kind < kKinds && words >> ticks; ++kind) {
      core.all += ticks;
      if (kind != kIdle && kind != kWaiting) core.busy += ticks;
    }
  }
  return cores;
}

std::vector<double> busy_percent(const std::vector<CoreTicks>& before, const std::vector<CoreTicks>& now) {
  std::vector<double> out;
  if (before.size() != now.size()) return out;
  for (std::size_t i = 0; i < now.size(); ++i) {
    // The kernel's count of idle ticks may step back.
    const double all = now[i].all > before[i].all ? static_cast<double>(now[i].all - before[i].all) : 0;
    const double busy = now[i].busy > before[i].busy ? static_cast<double>(now[i].busy - before[i].busy) : 0;
    out.push_back(all > 0 ? std::min(100.0, 100 * busy / all) : 0);
  }
  return out;
}

ComputerFigures Computer::read() {
  ComputerFigures out;
  utsname system{};
  if (::uname(&system) == 0) {
    out.host = system.nodename;
    out.kernel = std::string(system.sysname) + " " + system.release;
  }
  std::istringstream(text_of("/proc/uptime")) >> out.uptime_s;
  std::istringstream(text_of("/proc/loadavg")) >> out.load[0] >> out.load[1] >> out.load[2];
  const std::string meminfo = text_of("/proc/meminfo");
  out.memory_bytes = memory_bytes(meminfo, "MemTotal");
  out.memory_available_bytes = memory_bytes(meminfo, "MemAvailable");
  out.disk = disk_of(folder_);
  out.temperature_c = hottest_c();

  auto cores = read_core_ticks(text_of("/proc/stat"));
  out.cpu_percent = busy_percent(cores_, cores);
  cores_ = std::move(cores);

  const auto now = std::chrono::steady_clock::now();
  const ProcessTicks process = read_process(text_of("/proc/self/stat"));
  if (read_before_) {
    const double passed_s = std::chrono::duration<double>(now - *read_before_).count();
    const auto ticks = static_cast<double>(process.ticks - process_ticks_);
    out.process.cpu_percent = 100 * ticks / static_cast<double>(::sysconf(_SC_CLK_TCK)) / passed_s;
  }
  process_ticks_ = process.ticks;
  read_before_ = now;
  out.process.threads = process.threads;
  std::uint64_t pages = 0;
  std::istringstream(text_of("/proc/self/statm")) >> pages >> pages;  // the second number: resident pages
  out.process.rss_bytes = pages * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
  std::error_code error;
  for (auto one = fs::directory_iterator("/proc/self/fd", error); one != fs::directory_iterator();
       one.increment(error))
    ++out.process.descriptors;
  return out;
}

std::optional<ClockFigures> read_clock() {
  timex clock{};  // modes 0: only reads
  const int state = ::adjtimex(&clock);
  if (state < 0) return std::nullopt;
  const double offset_unit_ms = (clock.status & STA_NANO) != 0 ? 1e-6 : 1e-3;
  return ClockFigures{state != TIME_ERROR && (clock.status & STA_UNSYNC) == 0,
                      static_cast<double>(clock.offset) * offset_unit_ms,
                      static_cast<double>(clock.esterror) * 1e-3};
}

}  // namespace sslv
