// SPDX-License-Identifier: Apache-2.0
#include "ctl/packets_text.h"

#include "ctl/table.h"

#include <cstdint>
#include <numbers>
#include <utility>
#include <vector>

#include <fmt/format.h>

namespace sslv {
namespace {

std::string number_or_dash(const Json& of, const char* key, double factor = 1) {
  const auto found = of.find(key);
  return found == of.end() ? "-" : fmt::format("{:.1f}", found->get<double>() * factor);
}

std::string figures_text(const Json& packet) {
  return fmt::format("{} bytes, {:.1f} packets/s, heard {:.2f} s ago",
                     packet.at("bytes").get<std::uint64_t>(), packet.at("packets_per_s").get<double>(),
                     packet.at("age_s").get<double>());
}

void add_robots(const Json& detection, const char* key, const char* team,
                std::vector<std::vector<std::string>>& rows) {
  const auto robots = detection.find(key);
  if (robots == detection.end()) return;
  for (const Json& robot : *robots) {
    rows.push_back(
        {team, robot.contains("robot_id") ? json_text(robot.at("robot_id")) : "-", number_or_dash(robot, "x"),
         number_or_dash(robot, "y"), number_or_dash(robot, "orientation", 180 / std::numbers::pi),
         number_or_dash(robot, "height"), number_or_dash(robot, "pixel_x"), number_or_dash(robot, "pixel_y"),
         fmt::format("{:.2f}", robot.at("confidence").get<double>())});
  }
}

std::string detection_text(const Json& heard) {
  const Json& detection = heard.at("packet").at("detection");
  const double captured_s = detection.at("t_capture").get<double>(),
               sent_s = detection.at("t_sent").get<double>();
  std::string out =
      fmt::format("camera {}: frame {}, captured {:.4f}, sent {:.4f}: {:.2f} ms later; {}\n",
                  heard.at("camera").get<int>(), detection.at("frame_number").get<std::uint64_t>(),
                  captured_s, sent_s, (sent_s - captured_s) * 1e3, figures_text(heard));
  std::vector<std::vector<std::string>> rows;
  if (const auto balls = detection.find("balls"); balls != detection.end()) {
    for (const Json& ball : *balls) {
      rows.push_back({"ball", "", number_or_dash(ball, "x"), number_or_dash(ball, "y"), "",
                      number_or_dash(ball, "z"), number_or_dash(ball, "pixel_x"),
                      number_or_dash(ball, "pixel_y"),
                      fmt::format("{:.2f}", ball.at("confidence").get<double>())});
    }
  }
  add_robots(detection, "robots_yellow", "yellow", rows);
  add_robots(detection, "robots_blue", "blue", rows);
  if (rows.empty()) return out + "  no ball and no robot\n";
  return out + table_text({{"what"},
                           {"id", true},
                           {"x mm", true},
                           {"y mm", true},
                           {"angle deg", true},
                           {"height mm", true},
                           {"pixel x", true},
                           {"pixel y", true},
                           {"confidence", true}},
                          rows);
}

std::string geometry_text(const Json& heard) {
  const Json& geometry = heard.at("packet").at("geometry");
  const Json& field = geometry.at("field");
  const auto count = [](const Json& of, const char* key) {
    const auto found = of.find(key);
    return found == of.end() ? std::size_t{0} : found->size();
  };
  std::string out = fmt::format("geometry: field {} x {} mm, {} lines, {} arcs; {}\n",
                                field.at("field_length").get<int>(), field.at("field_width").get<int>(),
                                count(field, "field_lines"), count(field, "field_arcs"), figures_text(heard));
  if (count(geometry, "calib") == 0) return out + "  no calibration\n";
  for (const Json& calibration : geometry.at("calib")) {
    out += fmt::format("  calibration of camera {}: focal length {} px\n",
                       calibration.at("camera_id").get<int>(), number_or_dash(calibration, "focal_length"));
  }
  return out;
}

std::string arrivals_text(const Json& arrivals) {
  std::string out;
  for (const Json& one : arrivals) {
    const bool multicast = one.at("multicast").get<bool>(), broadcast = one.at("broadcast").get<bool>();
    out += fmt::format("heard {} at {} by {}\n", one.at("what").get<std::string>(),
                       one.at("address").get<std::string>(),
                       multicast && broadcast ? "multicast and broadcast"
                       : multicast            ? "multicast"
                                              : "broadcast");
  }
  return out;
}

std::string listeners_text(const Json& listeners) {
  std::string out = "programs on the service's computer that packets are given to:\n";
  for (const Json& program : listeners.at("programs")) {
    out += fmt::format("  a socket of user {}, bound to {}:{}\n", program.at("user").get<std::string>(),
                       program.at("address").get<std::string>(), listeners.at("port").get<int>());
  }
  if (listeners.at("programs").empty()) out += "  none\n";
  return out +
         "Who listens on other computers cannot be seen from here. Ask the teams, or run sample_client "
         "(package ssl-visiond-dev) there.\n";
}

}  // namespace

std::string packets_text(const Json& packets) {
  std::string out = fmt::format("heard from {}:{}\n", packets.at("group").get<std::string>(),
                                packets.at("port").get<int>());
  const auto why = packets.at("not_heard_because").get<std::string>();
  if (!why.empty()) out += "not heard: " + why + "\n";
  const auto no_broadcasts = packets.at("broadcasts_not_heard_because").get<std::string>();
  if (!no_broadcasts.empty()) out += "broadcasts not heard: " + no_broadcasts + "\n";
  out += arrivals_text(packets.at("arrivals"));
  for (const Json& heard : packets.at("detections")) out += detection_text(heard);
  const Json& geometry = packets.at("geometry");
  out += geometry.is_null() ? "geometry: none heard\n" : geometry_text(geometry);
  return out + listeners_text(packets.at("listeners"));
}

}  // namespace sslv
