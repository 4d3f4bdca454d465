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

/// Snapshot of this computer's load and resources.
struct ComputerFigures {
  std::string host, kernel;
  double uptime_s = 0;
  std::array<double, 3> load{};     // averages over 1, 5 and 15 minutes
  std::vector<double> cpu_percent;  // load of each core since the previous reading; empty the first time
  std::uint64_t memory_bytes = 0, memory_available_bytes = 0;
  struct Disk {
    std::filesystem::path folder;
    std::uint64_t total_bytes = 0, free_bytes = 0;  // free: available to this process's user
  };
  std::optional<Disk> disk;
  std::optional<double> temperature_c;  // temperature of the hottest sensor
  struct Process {
    double cpu_percent = 0;  // load since the previous reading; 100: one core
    std::uint64_t rss_bytes = 0;
    int threads = 0, descriptors = 0;
  } process;
};

/// This computer's name, reduced by file_name_part(); "unnamed" if nothing is left.
std::string host_name();
/// Keeps the letters, digits and hyphens of a text, for use in a file name; spaces become hyphens.
std::string file_name_part(std::string_view text);

/// Busy ticks and all ticks of each core since the computer started, from the text of /proc/stat.
struct CoreTicks {
  std::uint64_t busy = 0, all = 0;
};
std::vector<CoreTicks> read_core_ticks(std::string_view proc_stat);
/// Load of each core between two readings, 0 .. 100; empty if the number of cores has changed.
std::vector<double> busy_percent(const std::vector<CoreTicks>& before, const std::vector<CoreTicks>& now);

/// Reads the figures repeatedly. For one thread.
class Computer {
 public:
  /// Measures the disk of `folder`, or of its nearest existing parent if `folder` does not exist.
  explicit Computer(std::filesystem::path folder) : folder_(std::move(folder)) {}
  ComputerFigures read();

 private:
  const std::filesystem::path folder_;
  std::vector<CoreTicks> cores_;
  std::uint64_t process_ticks_ = 0;
  std::optional<std::chrono::steady_clock::time_point> read_before_;
};

/// Quality of the computer's clock, from the kernel.
struct ClockFigures {
  bool synchronised = false;
  double offset_ms = 0;  // offset still to be corrected
  double estimated_error_ms = 0;
};
/// Nothing if the kernel refuses the query.
std::optional<ClockFigures> read_clock();

}  // namespace sslv
