// SPDX-License-Identifier: Apache-2.0
#include "lab/truth.h"

#include "base/error.h"
#include "vision/detections_json.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <numbers>
#include <optional>

#include <fmt/format.h>

namespace sslv {
namespace {

constexpr const char* kKinds[] = {"robots", "balls"};

/// Corrects the line of one image.
class Correcting {
 public:
  Correcting(Json& line, const Scene& scene)
      : line_(line), scene_(scene), frame_(line.at("frame").get<std::string>()) {
    for (const char* kind : kKinds) {
      for (const Json& thing : line.at(kind))
        last_number_ = std::max(last_number_, thing.at("number").get<int>());
    }
  }

  void remove(int number) {
    const Place place = place_of(number);
    place.list->erase(place.list->begin() + place.index);
  }
  void doubt(int number) { thing(number)["visible_share"] = 0; }
  void rename(int number, int id) {
    Json& robot = thing(number);
    if (!robot.contains("team")) fail(fmt::format("mark {} is a ball and has no id", number));
    robot["id"] = id;
    named_.push_back(number);
  }
  void add(const Corrections::RobotAt& r) {
    const double height_mm = scene_.height_of(r.team);
    const Eigen::Vector2d middle = located(r.x_px, r.y_px, height_mm);
    const Eigen::Vector2d ahead = located(r.front_x_px, r.front_y_px, height_mm) - middle;
    if (ahead.norm() < 1) fail("the place that a robot looks towards must be another than its middle");
    Json& robot = add("robots", {{"team", name_of(r.team)}, {"id", r.id}}, middle, r.x_px, r.y_px);
    robot["orientation"] = std::atan2(ahead.y(), ahead.x());
    robot["height"] = height_mm;
    named_.push_back(last_number_);
  }
  void add(const Corrections::BallAt& b) {
    add("balls", Json::object(), located(b.x_px, b.y_px, scene_.field.ball_radius), b.x_px, b.y_px);
  }
  /// Checked at the end: two robots may have swapped their ids.
  void finish() {
    for (const int number : named_) refuse_twice(thing(number));
  }

 private:
  struct Place {
    Json* list;
    std::ptrdiff_t index;
  };
  Place place_of(int number) const {
    std::string known;
    for (const char* kind : kKinds) {
      Json& list = line_.at(kind);
      for (std::size_t i = 0; i < list.size(); ++i) {
        const int here = list[i].at("number").get<int>();
        if (here == number) return {&list, static_cast<std::ptrdiff_t>(i)};
        known += fmt::format("{}{}", known.empty() ? "" : ", ", here);
      }
    }
    fail(fmt::format("has no mark {}; it has {}", number, known.empty() ? "none" : known));
  }
  Json& thing(int number) {
    const Place place = place_of(number);
    return (*place.list)[static_cast<std::size_t>(place.index)];
  }
  Json& add(const char* kind, Json thing, const Eigen::Vector2d& mm, double x_px, double y_px) {
    thing.update({{"number", ++last_number_},
                  {"by", "hand"},
                  {"visible_share", 1},
                  {"x", mm.x()},
                  {"y", mm.y()},
                  {"pixel_x", x_px},
                  {"pixel_y", y_px}});
    line_[kind].push_back(std::move(thing));
    return line_[kind].back();
  }
  Eigen::Vector2d located(double x_px, double y_px, double height_mm) const {
    const double right = line_.at("width").get<double>() - 0.5,
                 below = line_.at("height").get<double>() - 0.5;
    if (!(x_px >= -0.5 && x_px <= right && y_px >= -0.5 && y_px <= below))
      fail(fmt::format("{}, {} is not in it; it has {:.0f}x{:.0f} pixels", x_px, y_px, right + 0.5,
                       below + 0.5));
    const auto mm = scene_.camera->unproject({x_px, y_px}, height_mm);
    if (!mm) fail(fmt::format("{}, {} cannot be located", x_px, y_px));
    return *mm;
  }
  void refuse_twice(const Json& robot) const {
    for (const Json& other : line_.at("robots")) {
      if (other["team"] == robot["team"] && other["id"] == robot["id"] &&
          other["number"] != robot["number"]) {
        fail(fmt::format("{} {} is there twice, as marks {} and {}", robot["team"].get<std::string>(),
                         robot["id"].get<int>(), other["number"].get<int>(), robot["number"].get<int>()));
      }
    }
  }
  [[noreturn]] void fail(const std::string& why) const {
    throw SettingsError(fmt::format("image {}: {}", frame_, why));
  }

  Json& line_;
  const Scene& scene_;
  const std::string frame_;
  int last_number_ = 0;
  std::vector<int> named_;  // robots that got an id
};

}  // namespace

Json draft_of_truth(const std::string& name, const Frame& frame) {
  const ImageView& image = frame.image.view();
  return truth_draft_json(name, image.width, image.height, frame.robots, frame.balls);
}

void correct(Json& line, const Corrections& corrections, const Scene& scene) {
  Json corrected = line;
  Correcting picture(corrected, scene);
  for (const int number : corrections.remove) picture.remove(number);
  for (const int number : corrections.doubtful) picture.doubt(number);
  for (const auto& [number, id] : corrections.ids) picture.rename(number, id);
  for (const Corrections::RobotAt& robot : corrections.robots) picture.add(robot);
  for (const Corrections::BallAt& ball : corrections.balls) picture.add(ball);
  picture.finish();
  if (corrections.checked) corrected["checked"] = true;
  line = std::move(corrected);
}

std::vector<Json> read_truth(const std::string& file) {
  std::vector<Json> lines;
  std::ifstream in(file);
  std::string text;
  for (int number = 1; std::getline(in, text); ++number) {
    if (text.find_first_not_of(" \t\r") == std::string::npos) continue;
    Json line = Json::parse(text, nullptr, false);
    if (!line.is_object() || !line.contains("frame") || !line.contains("checked"))
      throw SettingsError(fmt::format("{}, line {}: is not of a file that `annotate` wrote", file, number));
    lines.push_back(std::move(line));
  }
  return lines;
}

std::string truth_text(const Json& line) {
  std::string out = fmt::format("{}: {} robots, {} balls, {}\n", line.at("frame").get<std::string>(),
                                line.at("robots").size(), line.at("balls").size(),
                                line.at("checked") == true ? "checked" : "not checked yet");
  for (const char* kind : kKinds) {
    for (const Json& thing : line.at(kind)) {
      const bool is_robot = thing.contains("team");
      out += fmt::format(
          "  {:>3}  {:<10} {:>7.0f} {:>7.0f} mm {:>6}  pixel {:>6.1f} {:>6.1f}{}{}\n",
          thing.at("number").get<int>(),
          is_robot ? fmt::format("{} {}", thing.at("team").get<std::string>(), thing.at("id").get<int>())
                   : "ball",
          thing.at("x").get<double>(), thing.at("y").get<double>(),
          is_robot ? fmt::format("{:.0f} deg", thing.at("orientation").get<double>() * 180 / std::numbers::pi)
                   : "",
          thing.at("pixel_x").get<double>(), thing.at("pixel_y").get<double>(),
          thing.at("by") == "hand" ? "  by hand" : "", thing.at("visible_share") == 0 ? "  doubtful" : "");
    }
  }
  return out;
}

}  // namespace sslv
