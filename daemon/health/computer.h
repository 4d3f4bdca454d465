// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace sslv {

/// The computer this runs on, at one moment.
struct ComputerFigures {
  std::string host, kernel;
  double uptime_s = 0;
  std::array<double, 3> load{};     // over 1, 5 and 15 minutes
  std::vector<double> cpu_percent;  // of each core since the reading before; empty in the first
  std::uint64_t memory_bytes = 0, memory_available_bytes = 0;
  struct Disk {
    std::filesystem::path folder;
    std::uint64_t total_bytes = 0, free_bytes = 0;  // free for the user that runs this
  };
  std::optional<Disk> disk;
  std::optional<double> temperature_c;  // of the hottest sensor
  struct Process {
    double cpu_percent = 0;  // since the reading before; 100: one core
    std::uint64_t rss_bytes = 0;
    int threads = 0, descriptors = 0;
  } process;
};

/// This computer's name, as far as it may stand in a file's.
std::string host_name();
/// Letters, digits and hyphens of a text, for the name of a file.
std::string file_name_part(std::string_view text);

/// Ticks that each core was busy, and all of its ticks, since the computer started: /proc/stat's text.
struct CoreTicks {
  std::uint64_t busy = 0, all = 0;
};
std::vector<CoreTicks> read_core_ticks(std::string_view proc_stat);
/// Between two readings; empty when there is another number of cores.
std::vector<double> busy_percent(const std::vector<CoreTicks>& before, const std::vector<CoreTicks>& now);

/// Reads them again and again. One thread.
class Computer {
 public:
  /// `folder`: whose disk is looked at; the nearest folder above it that is there.
  explicit Computer(std::filesystem::path folder) : folder_(std::move(folder)) {}
  ComputerFigures read();

 private:
  const std::filesystem::path folder_;
  std::vector<CoreTicks> cores_;
  std::uint64_t process_ticks_ = 0;
  std::optional<std::chrono::steady_clock::time_point> read_before_;
};

/// How good the computer's clock is, as the kernel says.
struct ClockFigures {
  bool synchronised = false;
  double offset_ms = 0;  // still to be corrected
  double estimated_error_ms = 0;
};
/// Nothing where it may not be asked.
std::optional<ClockFigures> read_clock();

}  // namespace sslv
