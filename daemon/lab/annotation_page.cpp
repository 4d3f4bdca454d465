// SPDX-License-Identifier: Apache-2.0
#include "lab/annotation_page.h"

#include "base/base64.h"
#include "lab/annotation_page_html.h"

#include <cmath>

#include <fmt/format.h>

namespace sslv {
namespace {

constexpr double kRobotRadiusMm = 90;

void replace_all(std::string& text, std::string_view from, std::string_view to) {
  for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size())
    text.replace(at, from.size(), to);
}

Json mark_of(const Json& thing, const Scene& scene) {
  const bool is_robot = thing.contains("team");
  const double height_mm = is_robot ? thing.at("height").get<double>() : scene.field.ball_radius;
  const double radius_mm = is_robot ? kRobotRadiusMm : scene.field.ball_radius;
  const Eigen::Vector2d pixel(thing.at("pixel_x").get<double>(), thing.at("pixel_y").get<double>());
  const double mm2_per_px = scene.camera->mm2_per_px(pixel, height_mm);
  Json mark{
      {"number", thing.at("number")},
      {"name", is_robot ? fmt::format("{} {}", thing.at("team").get<std::string>(), thing.at("id").get<int>())
                        : "ball"},
      {"kind", is_robot ? thing.at("team").get<std::string>() : "ball"},
      {"x", pixel.x()},
      {"y", pixel.y()},
      {"radius", mm2_per_px > 0 ? radius_mm / std::sqrt(mm2_per_px) : 10},
      {"doubtful", thing.at("visible_share") == 0},
      {"by_hand", thing.at("by") == "hand"}};
  if (is_robot) {
    const double turn_rad = thing.at("orientation").get<double>();
    const auto front =
        scene.camera->project({thing.at("x").get<double>() + radius_mm * std::cos(turn_rad),
                               thing.at("y").get<double>() + radius_mm * std::sin(turn_rad), height_mm});
    if (front) mark["front"] = {front->x(), front->y()};
  }
  return mark;
}

}  // namespace

std::string annotation_page_name(const std::string& frame) {
  return frame + ".html";
}

std::string annotation_page(const Json& line, std::span<const std::uint8_t> jpeg, const Scene& scene,
                            const AnnotationPlace& place) {
  Json data{{"frame", line.at("frame")},
            {"checked", line.at("checked")},
            {"width", line.at("width")},
            {"height", line.at("height")},
            {"command", place.command},
            {"previous", place.previous},
            {"next", place.next},
            {"marks", Json::array()},
            {"picture", "data:image/jpeg;base64," + to_base64(jpeg)}};
  for (const char* kind : {"robots", "balls"}) {
    for (const Json& thing : line.at(kind)) data["marks"].push_back(mark_of(thing, scene));
  }
  std::string text = json_text(data);
  replace_all(text, "<", "\\u003c");  // so that no text ends the script element
  std::string page(kAnnotationPageHtml);
  constexpr std::string_view kPlace = "{\"//\": \"the image and its marks\"}";
  page.replace(page.find(kPlace), kPlace.size(), text);
  return page;
}

}  // namespace sslv
