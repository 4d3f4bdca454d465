// SPDX-License-Identifier: Apache-2.0
#include "services/status/computer_report.h"

#include <cstdint>
#include <string>
#include <utility>

#include <fmt/format.h>

namespace sslv {
namespace {

constexpr std::uint64_t kLittleDisk_bytes = 100'000'000;
constexpr double kLittleDiskShare = 0.02, kLittleMemoryShare = 0.05;

Check check_clock(const std::optional<ClockFigures>& clock, bool another_host_sends) {
  Check check{"clock", "Clock", CheckState::kWarn, kNoFigure, "", ""};
  if (!clock) {
    check.text = "the system does not say whether it is synchronised";
  } else if (!clock->synchronised) {
    check.text = another_host_sends
                     ? "not synchronised: timedatectl set-ntp true"
                     : "not synchronised; before another vision joins, run: timedatectl set-ntp true";
  } else {
    check = {"clock", "Clock",       CheckState::kPass, fmt::format("±{:.1f}", clock->estimated_error_ms),
             "ms",    "synchronised"};
  }
  return check;
}

Check check_computer(const ComputerFigures& computer) {
  constexpr double kGb = 1e-9;
  std::string text =
      fmt::format("{:.1f} GB memory", static_cast<double>(computer.memory_available_bytes) * kGb);
  if (const auto& disk = computer.disk)
    text += fmt::format(", {:.0f} GB disk free", static_cast<double>(disk->free_bytes) * kGb);
  if (const auto& celsius = computer.temperature_c) text += fmt::format(", {:.0f} °C", *celsius);
  return {"computer", "This computer", CheckState::kPass, fmt::format("{:.1f}", computer.load[0]), "load",
          text};
}

}  // namespace

void report_computer(const ComputerFigures& computer, const std::optional<ClockFigures>& clock,
                     HealthReport& report) {
  const auto warn = [&](const char* id, const char* check, std::string title, std::string fix,
                        const char* page) {
    report.alerts.push_back({.id = id,
                             .check = check,
                             .severity = Severity::kWarn,
                             .title = std::move(title),
                             .fix = std::move(fix),
                             .page = page});
  };
  // A wrong clock matters only beside another vision: otherwise all times that teams receive are from it.
  if (report.another_host_sends && clock && !clock->synchronised) {
    warn("clock_not_synchronised", "clock",
         "This computer's clock is not synchronised, and another vision sends times too",
         "Turn on time synchronisation: timedatectl set-ntp true", "#/diagnostics");
  }
  if (const auto& disk = computer.disk) {
    if (disk->free_bytes < kLittleDisk_bytes ||
        static_cast<double>(disk->free_bytes) < kLittleDiskShare * static_cast<double>(disk->total_bytes)) {
      warn("disk_full", "computer",
           fmt::format("The disk of {} is nearly full: {:.0f} MB are free", disk->folder.string(),
                       static_cast<double>(disk->free_bytes) * 1e-6),
           "Settings cannot be saved on a full disk: delete files that are not needed.", "#/diagnostics");
    }
  }
  if (static_cast<double>(computer.memory_available_bytes) <
      kLittleMemoryShare * static_cast<double>(computer.memory_bytes)) {
    warn("memory_full", "computer",
         fmt::format("This computer's memory is nearly full: {:.0f} MB are free",
                     static_cast<double>(computer.memory_available_bytes) * 1e-6),
         "Close other programs before the system kills this one.", "#/diagnostics");
  }
  report.checks.push_back(check_clock(clock, report.another_host_sends));
  report.checks.push_back(check_computer(computer));
}

Json computer_json(const ComputerFigures& computer) {
  const ComputerFigures::Process& process = computer.process;
  Json out{{"host", computer.host},
           {"kernel", computer.kernel},
           {"uptime_s", computer.uptime_s},
           {"load", computer.load},
           {"cpu_percent", computer.cpu_percent},
           {"memory",
            {{"total_bytes", computer.memory_bytes}, {"available_bytes", computer.memory_available_bytes}}},
           {"disk", nullptr},
           {"temperature_c", computer.temperature_c ? Json(*computer.temperature_c) : Json(nullptr)},
           {"process",
            {{"cpu_percent", process.cpu_percent},
             {"rss_bytes", process.rss_bytes},
             {"threads", process.threads},
             {"descriptors", process.descriptors}}}};
  if (const auto& disk = computer.disk) {
    out["disk"] = {{"folder", disk->folder.string()},
                   {"total_bytes", disk->total_bytes},
                   {"free_bytes", disk->free_bytes}};
  }
  return out;
}

Json clock_json(const std::optional<ClockFigures>& clock) {
  if (!clock) return nullptr;
  return {{"synchronised", clock->synchronised},
          {"offset_ms", clock->offset_ms},
          {"estimated_error_ms", clock->estimated_error_ms}};
}

}  // namespace sslv
