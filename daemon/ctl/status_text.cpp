// SPDX-License-Identifier: Apache-2.0
#include "ctl/status_text.h"

#include "ctl/table.h"

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace sslv {
namespace {

int badness(const Json& alert) {
  const Json& severity = alert.at("severity");
  return severity == "bad" ? 2 : severity == "warn" ? 1 : 0;
}

/// "2 min 13 s".
std::string duration_text(double seconds) {
  const auto all = static_cast<long>(seconds);
  if (all < 1) return "under 1 s";
  if (all < 60) return fmt::format("{} s", all);
  if (all < 3600) return fmt::format("{} min {} s", all / 60, all % 60);
  return fmt::format("{} h {} min", all / 3600, all % 3600 / 60);
}

/// The stages' notes, without warnings: those are shown as alerts.
std::string notes_text(const std::string& whose, const Json& stages) {
  std::string out;
  for (const Json& stage : stages) {
    if (stage.at("note").is_null() || stage.at("note").at("kind") != "note") continue;
    out +=
        fmt::format("{}, {}: {}\n", whose, stage_text(stage), stage.at("note").at("text").get<std::string>());
  }
  return out;
}

}  // namespace

std::string stage_text(const Json& stage) {
  const auto library = stage.at("library").get<std::string>();
  return stage.at("name").get<std::string>() + (library.empty() ? "" : " from " + library);
}

std::string status_text(const Json& status) {
  const Json& network = status.at("network");
  std::string out = fmt::format("{}  ({}, up {:.0f} s)\n", status.at("site").get<std::string>(),
                                status.at("version").get<std::string>(), status.at("uptime_s").get<double>());
  out +=
      fmt::format("-> {}:{}{}  {:.0f} packets/s, {} errors\n", network.at("group").get<std::string>(),
                  network.at("port").get<int>(),
                  network.at("interface") == "" ? "" : " on " + network.at("interface").get<std::string>(),
                  network.at("packets_per_s").get<double>(), network.at("send_errors").get<std::uint64_t>());
  if (const Json& addresses = status.at("panel").at("addresses"); !addresses.empty())
    out += fmt::format("panel: {}\n", fmt::join(addresses.get<std::vector<std::string>>(), "  "));
  out += fmt::format("{:>6}  {:<14} {:<8} {:>10} {:>6} {:>8} {:>8} {:>9} {:>7} {:>6}\n", "camera", "name",
                     "state", "image", "fps", "p50 ms", "p99 ms", "frames", "robots", "balls");
  for (const Json& camera : status.at("cameras")) {
    out +=
        fmt::format("{:>6}  {:<14} {:<8} {:>10} {:>6.1f} {:>8.2f} {:>8.2f} {:>9} {:>7} {:>6}\n",
                    camera.at("id").get<int>(), camera.at("name").get<std::string>(),
                    camera.at("state").get<std::string>(),
                    fmt::format("{}x{}", camera.at("width").get<int>(), camera.at("height").get<int>()),
                    camera.at("fps").get<double>(), camera.at("latency_ms").at("p50").get<double>(),
                    camera.at("latency_ms").at("p99").get<double>(), camera.at("frames").get<std::uint64_t>(),
                    camera.at("robots").get<int>(), camera.at("balls").get<int>());
  }
  for (const Json& camera : status.at("cameras"))
    out += notes_text(fmt::format("camera {}", camera.at("id").get<int>()), camera.at("stages"));
  out += notes_text("field", status.at("tracks").at("stages"));
  for (const Json& alert : status.at("alerts")) {
    out += fmt::format("{}: {}. {}\n", alert.at("severity").get<std::string>(),
                       alert.at("title").get<std::string>(), alert.at("fix").get<std::string>());
  }
  return out;
}

std::string cameras_text(const Json& cameras) {
  std::vector<std::vector<std::string>> rows;
  for (const Json& camera : cameras) {
    const Json& latency = camera.at("latency_ms");
    rows.push_back(
        {json_text(camera.at("id")), camera.at("name").get<std::string>(),
         camera.at("state").get<std::string>(), fmt::format("{:.1f}", camera.at("fps").get<double>()),
         fmt::format("{:.2f}", latency.at("p50").get<double>()),
         fmt::format("{:.2f}", latency.at("p99").get<double>()), json_text(camera.at("frames_dropped")),
         json_text(camera.at("robots")), json_text(camera.at("balls"))});
  }
  return table_text({{"id", true},
                     {"name"},
                     {"state"},
                     {"fps", true},
                     {"p50 ms", true},
                     {"p99 ms", true},
                     {"drops", true},
                     {"robots", true},
                     {"balls", true}},
                    rows);
}

Json worst_first(Json alerts) {
  std::stable_sort(alerts.begin(), alerts.end(),
                   [](const Json& a, const Json& b) { return badness(a) > badness(b); });
  return alerts;
}

std::string alerts_text(const Json& alerts) {
  if (alerts.empty()) return "no alerts\n";
  std::string out;
  for (const Json& alert : alerts) {
    out += fmt::format("{:<4}  {}\n      {}\n", alert.at("severity").get<std::string>(),
                       alert.at("title").get<std::string>(), alert.at("fix").get<std::string>());
  }
  return out;
}

std::string checks_text(const Json& checks) {
  std::vector<std::vector<std::string>> rows;
  for (const Json& check : checks.at("checks")) {
    const auto value = check.at("value").get<std::string>(), unit = check.at("unit").get<std::string>();
    const bool has_figure = value != "\u2013";
    rows.push_back({check.at("state").get<std::string>(), check.at("title").get<std::string>(),
                    has_figure ? value + (unit.empty() ? "" : " ") + unit : "",
                    check.at("text").get<std::string>()});
  }
  return (checks.at("go") == true ? "GO\n" : "NO-GO\n") +
         table_text({{"state"}, {"check"}, {"figure"}, {"what was found"}}, rows);
}

std::string log_line_text(const Json& line) {
  return fmt::format("{} {:<7} {}\n", local_time_text(line.at("time").get<double>()),
                     line.at("level").get<std::string>(), line.at("text").get<std::string>());
}

std::string events_text(const Json& events) {
  std::string out;
  const std::string problem = events.at("save_problem").get<std::string>();
  if (!problem.empty()) out += fmt::format("not saved: {}\n", problem);
  std::vector<std::vector<std::string>> rows;
  for (const Json& entry : events.at("entries")) {
    const bool is_alert = entry.at("kind") == "alert";
    std::string what = entry.at("title").get<std::string>();
    const auto add = [&](const std::string& more) { what += more; };
    if (const int count = entry.at("count").get<int>(); count > 1) add(fmt::format(" ({} times)", count));
    if (const auto who = entry.at("who").get<std::string>(); !who.empty()) add(" by " + who);
    if (const auto why = entry.at("ended_by").get<std::string>(); !why.empty()) add(" (until " + why + ")");
    std::string lasted;
    if (is_alert) lasted = duration_text(entry.at("seconds").get<double>());
    if (is_alert && entry.at("end").is_null()) lasted += " so far";
    rows.push_back({local_time_text(entry.at("begin").get<double>()), std::move(lasted),
                    is_alert ? entry.at("severity").get<std::string>() : "", std::move(what)});
  }
  return out + (rows.empty() ? "nothing in the last 24 hours\n"
                             : table_text({{"began"}, {"lasted", true}, {"severity"}, {"what"}}, rows));
}

Json only_bad(const Json& entries) {
  Json out = Json::array();
  for (const Json& entry : entries) {
    if (entry.at("kind") == "alert" && entry.at("severity") == "bad") out.push_back(entry);
  }
  return out;
}

bool any_bad(const Json& alerts) {
  return std::any_of(alerts.begin(), alerts.end(),
                     [](const Json& alert) { return alert.at("severity") == "bad"; });
}

}  // namespace sslv
