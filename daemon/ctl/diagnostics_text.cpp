// SPDX-License-Identifier: Apache-2.0
#include "ctl/diagnostics_text.h"

#include "ctl/table.h"

#include <cmath>
#include <cstddef>
#include <vector>

#include <fmt/format.h>

namespace sslv {
namespace {

double gb(const Json& bytes) {
  return bytes.get<double>() * 1e-9;
}

std::string system_text(const Json& system) {
  std::string cores;
  for (const Json& percent : system.at("cpu_percent")) cores += fmt::format(" {:.0f}", percent.get<double>());
  const Json& load = system.at("load");
  const Json& disk = system.at("disk");
  const Json& temperature = system.at("temperature_c");
  const Json& process = system.at("process");
  std::string out = fmt::format("host      {}, {}, up {:.0f} s\n", system.at("host").get<std::string>(),
                                system.at("kernel").get<std::string>(), system.at("uptime_s").get<double>());
  out += fmt::format("load      {:.2f} {:.2f} {:.2f}; cores busy, %:{}\n", load.at(0).get<double>(),
                     load.at(1).get<double>(), load.at(2).get<double>(), cores);
  out +=
      fmt::format("memory    {:.1f} of {:.1f} GB available\n", gb(system.at("memory").at("available_bytes")),
                  gb(system.at("memory").at("total_bytes")));
  if (disk.is_object()) {
    out += fmt::format("disk      {:.1f} of {:.1f} GB free at {}\n", gb(disk.at("free_bytes")),
                       gb(disk.at("total_bytes")), disk.at("folder").get<std::string>());
  }
  if (temperature.is_number()) out += fmt::format("hottest   {:.0f} C\n", temperature.get<double>());
  return out + fmt::format("service   {:.0f} % of a core, {:.0f} MB, {} threads, {} descriptors\n",
                           process.at("cpu_percent").get<double>(), gb(process.at("rss_bytes")) * 1000,
                           process.at("threads").get<int>(), process.at("descriptors").get<int>());
}

std::string clock_text(const Json& clock) {
  if (clock.is_null()) return "clock     cannot be read\n";
  return fmt::format("clock     {}, {:.3f} ms off, accurate to {:.3f} ms\n",
                     clock.at("synchronised") == true ? "synchronised" : "NOT synchronised",
                     clock.at("offset_ms").get<double>(), clock.at("estimated_error_ms").get<double>());
}

std::string exposure_text(const Json& camera) {
  const Json& exposure = camera.at("exposure");
  if (exposure.is_null()) return fmt::format("camera {}  no image\n", camera.at("id").get<int>());
  return fmt::format("camera {}  {:.1f} % of the image clipped, {:.1f} % dark, mean luma {:.0f}\n",
                     camera.at("id").get<int>(), 100 * exposure.at("clipped_share").get<double>(),
                     100 * exposure.at("dark_share").get<double>(), exposure.at("mean_luma").get<double>());
}

}  // namespace

std::optional<double> quantile_us(const Json& histogram, double share) {
  const Json& counts = histogram.at("counts");
  double all = 0;
  for (const Json& count : counts) all += count.get<double>();
  if (all == 0) return {};
  double below = 0;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    const double here = counts.at(i).get<double>();
    if (here > 0 && (below + here >= share * all || i + 1 == counts.size())) {
      // The width of bins is proportional to their times, so interpolate geometrically within a bin.
      const double from = histogram.at("edges_us").at(i).get<double>();
      const double to = histogram.at("edges_us").at(i + 1).get<double>();
      const double part = (share * all - below) / here;
      return from > 0 ? from * std::pow(to / from, part) : to * part;
    }
    below += here;
  }
  return {};  // not a histogram of a daemon
}

std::string diagnostics_text(const Json& diagnostics) {
  std::string out = system_text(diagnostics.at("system")) + clock_text(diagnostics.at("clock"));
  std::vector<std::vector<std::string>> rows;
  for (const Json& camera : diagnostics.at("cameras")) {
    out += exposure_text(camera);
    const auto add = [&](const std::string& what, const Json& histogram) {
      const auto ms = [&](double share) {
        const auto us = quantile_us(histogram, share);
        return us ? fmt::format("{:.3f}", *us / 1000) : "-";
      };
      rows.push_back({json_text(camera.at("id")), what, ms(0.5), ms(0.99)});
    };
    for (const Json& stage : camera.at("stages"))
      add(stage.at("name").get<std::string>(), stage.at("histogram"));
    add("latency", camera.at("latency"));
    add("age", camera.at("age"));
  }
  return out + "\n" + table_text({{"camera", true}, {"what"}, {"p50 ms", true}, {"p99 ms", true}}, rows);
}

}  // namespace sslv
