// SPDX-License-Identifier: Apache-2.0
#include "ctl/field_text.h"

#include "ctl/status_text.h"
#include "ctl/table.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>
#include <vector>

#include <fmt/format.h>

namespace sslv {
namespace {

using Rows = std::vector<std::vector<std::string>>;

std::string rounded(const Json& value, int digits = 0) {
  return fmt::format("{:.{}f}", value.get<double>(), digits);
}

std::string speed_m_s(const Json& thing) {
  return fmt::format("{:.2f}", std::hypot(thing.at("vx").get<double>(), thing.at("vy").get<double>()) * 1e-3);
}

std::string seen_text(const Json& thing) {
  return thing.at("visibility").get<double>() >= 1
             ? "seen"
             : fmt::format("hidden, {:.0f} %", 100 * thing.at("visibility").get<double>());
}

std::string robot_name(const Json& robot) {
  return fmt::format("{} {}", robot.at("team").get<std::string>(), robot.at("id").get<int>());
}

}  // namespace

std::string field_text(const Json& field) {
  Rows rows;
  for (const Json& robot : field.at("robots")) {
    rows.push_back({robot_name(robot), rounded(robot.at("x")), rounded(robot.at("y")), "",
                    rounded(robot.at("orientation").get<double>() * 180 / std::numbers::pi), speed_m_s(robot),
                    rounded(robot.at("turn_rad_s"), 1), seen_text(robot)});
  }
  for (const Json& ball : field.at("balls")) {
    rows.push_back({"ball", rounded(ball.at("x")), rounded(ball.at("y")), rounded(ball.at("z")), "",
                    speed_m_s(ball), "", seen_text(ball)});
  }
  std::string out = rows.empty() ? "Nothing is tracked.\n"
                                 : table_text({{"what"},
                                               {"x mm", true},
                                               {"y mm", true},
                                               {"z mm", true},
                                               {"heading deg", true},
                                               {"speed m/s", true},
                                               {"turn rad/s", true},
                                               {"now"}},
                                              rows);
  out += fmt::format("\n{} images tracked, {:.0f} us to the packet (p99 {:.0f} us)\n",
                     field.at("frames").get<std::uint64_t>(), field.at("latency_p50_us").get<double>(),
                     field.at("latency_p99_us").get<double>());
  for (const Json& stage : field.at("stages")) {
    const Json& note = stage.at("note");
    out += fmt::format("  {:<12} {:>6.1f} us  p99 {:>6.1f} us{}\n", stage_text(stage),
                       stage.at("p50_us").get<double>(), stage.at("p99_us").get<double>(),
                       note.is_null() ? "" : "  " + note.at("text").get<std::string>());
  }
  for (const Json& camera : field.at("other_cameras"))
    out += fmt::format("camera {} comes from {}, whose clock is {:.1f} ms behind{}\n",
                       camera.at("camera").get<int>(), camera.at("address").get<std::string>(),
                       camera.at("clock_correction_ms").get<double>(),
                       camera.at("is_used") == true
                           ? ""
                           : "; it is not used for tracks (field/other_computers does not name it)");
  out += field.at("sends") == true ? fmt::format("{} packets of tracks sent as \"{}\"\n",
                                                 field.at("packets_sent").get<std::uint64_t>(),
                                                 field.at("source").at("name").get<std::string>())
                                   : "Tracks are not sent to the network: network/tracker/enabled is off.\n";
  return out;
}

std::string agreement_text(const Json& agreement) {
  struct Pair {
    std::vector<double> off_mm;
    double worst_mm = 0, x_mm = 0, y_mm = 0;
  };
  std::map<std::pair<int, int>, Pair> pairs;
  for (const Json& one : agreement.at("differences")) {
    Pair& pair = pairs[{one.at("cameras").at(0), one.at("cameras").at(1)}];
    const double off_mm = std::hypot(one.at("off_x_mm").get<double>(), one.at("off_y_mm").get<double>());
    pair.off_mm.push_back(off_mm);
    if (off_mm < pair.worst_mm) continue;
    pair.worst_mm = off_mm;
    pair.x_mm = one.at("x");
    pair.y_mm = one.at("y");
  }
  Rows rows;
  for (auto& [cameras, pair] : pairs) {
    std::sort(pair.off_mm.begin(), pair.off_mm.end());
    rows.push_back(
        {fmt::format("{} and {}", cameras.first, cameras.second),
         fmt::format("{:.2f}", pair.off_mm[pair.off_mm.size() / 2]), fmt::format("{:.2f}", pair.worst_mm),
         fmt::format("({:.0f}, {:.0f})", pair.x_mm, pair.y_mm), std::to_string(pair.off_mm.size())});
  }
  std::string out = rows.empty() ? "No two cameras have seen the same robots.\n"
                                 : table_text({{"cameras"},
                                               {"differ by mm", true},
                                               {"at most mm", true},
                                               {"there (mm)", true},
                                               {"places", true}},
                                              rows);
  for (const Json& trend : agreement.at("trends")) {
    if (trend.at("since").is_null()) continue;
    const Json& before_mm = trend.at("before_mm");
    out += fmt::format(
        "cameras {} and {} have differed too much since {}{}\n", trend.at("cameras").at(0).get<int>(),
        trend.at("cameras").at(1).get<int>(), local_time_text(trend.at("since").get<double>()),
        before_mm.is_null() ? "" : fmt::format("; before, it was {:.1f} mm", before_mm.get<double>()));
  }
  rows.clear();
  for (const Json& camera : agreement.at("cameras"))
    rows.push_back({std::to_string(camera.at("camera").get<int>()), rounded(camera.at("time_offset_ms"), 2),
                    fmt::format("{:.0f}", 100 * camera.at("evenness").get<double>()),
                    rounded(camera.at("error_mm"), 2)});
  if (!rows.empty()) {
    out += "\n" + table_text({{"camera"},
                              {"its times are late by ms", true},
                              {"evened out by %", true},
                              {"taken off mm", true}},
                             rows);
  }
  rows.clear();
  for (const Json& robot : agreement.at("heights")) {
    rows.push_back({robot_name(robot), rounded(robot.at("more_mm"), 1), rounded(robot.at("sigma_mm"), 1)});
  }
  if (!rows.empty()) out += "\n" + table_text({{"robot"}, {"higher by mm", true}, {"+-", true}}, rows);
  return out;
}

std::string kicks_text(const Json& kicks) {
  Rows rows;
  for (const Json& kick : kicks.at("kicks")) {
    const Json& robot = kick.at("robot");
    const Json& landing = kick.at("landing");
    rows.push_back({local_time_text(kick.at("time")), robot.is_null() ? "" : robot_name(robot),
                    kick.at("is_chip") == true ? "chip" : "flat", rounded(kick.at("speed_m_s"), 2),
                    rounded(kick.at("x")), rounded(kick.at("y")),
                    landing.is_null() ? ""
                                      : fmt::format("({:.0f}, {:.0f})", landing.at(0).get<double>(),
                                                    landing.at(1).get<double>())});
  }
  if (rows.empty()) return "No kick was seen.\n";
  return table_text({{"time"},
                     {"robot"},
                     {"kind"},
                     {"speed m/s", true},
                     {"x mm", true},
                     {"y mm", true},
                     {"lands (mm)", true}},
                    rows);
}

}  // namespace sslv
