// SPDX-License-Identifier: Apache-2.0
// Draws halls independently of the simulator, to evaluate colours and detection. Shares the league's camera
// model and field lines with the service, and nothing with the simulator.

#include "base/json.h"
#include "camera_bytes.h"
#include "draw.h"
#include "hall.h"
#include "play.h"

#include <cstdlib>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <map>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

namespace sslv::halls {
namespace {

struct Options {
  HallOptions hall;
  PlayOptions play;
  PixelFormat format = PixelFormat::kUyvy;
  int first = 1, frames = 1, robots = 0, balls = 0;
  double light = 1, exposure_ms = 0, readout_ms = 0;
  std::vector<double> lamps;
  std::string output;
  bool preview = false;
};

template <class T>
using Names = std::map<std::string, T>;

Json calibration_json(const CameraCalibration& c) {
  return {{"focal_length", c.focal_length},
          {"principal_point_x", c.principal_point_x},
          {"principal_point_y", c.principal_point_y},
          {"distortion", c.distortion},
          {"q0", c.q0},
          {"q1", c.q1},
          {"q2", c.q2},
          {"q3", c.q3},
          {"tx", c.tx},
          {"ty", c.ty},
          {"tz", c.tz},
          {"pixel_image_width", c.pixel_image_width},
          {"pixel_image_height", c.pixel_image_height}};
}

/// The service's settings: field, camera and heights, but no colours.
Json settings_json(const Hall& hall, PixelFormat format) {
  const FieldSize& f = hall.field;
  return {{"site", "A drawn hall"},
          {"field",
           {{"field_length", f.field_length},
            {"field_width", f.field_width},
            {"goal_width", f.goal_width},
            {"boundary_width", f.boundary_width},
            {"boundary_width_goal_line", f.boundary_width_goal_line},
            {"penalty_area_depth", f.penalty_area_depth},
            {"penalty_area_width", f.penalty_area_width},
            {"center_circle_radius", f.center_circle_radius},
            {"goal_center_to_penalty_mark", f.goal_center_to_penalty_mark}}},
          {"teams",
           {{"height_from_referee", false},
            {"yellow", {{"robot_height", kNominalHeightMm}}},
            {"blue", {{"robot_height", kNominalHeightMm}}}}},
          {"cameras", Json::array({{{"id", 0},
                                    {"source",
                                     {{"backend", "files"},
                                      {"path", "."},
                                      {"pixel_format", name_of(format)},
                                      {"width", hall.calibration.pixel_image_width},
                                      {"height", hall.calibration.pixel_image_height}}},
                                    {"calibration", calibration_json(hall.calibration)}}})}};
}

Json truth_json(const Play& play, const CameraModel& camera, const std::string& frame, double t_s) {
  Json robots = Json::array(), balls = Json::array();
  const auto add_pixel = [&](Json& thing, const Eigen::Vector3d& at_mm, double share) {
    const auto pixel = camera.project(at_mm).value();
    const auto& c = camera.calibration();
    thing["visible"] = share > 0 && pixel.x() > -0.5 && pixel.y() > -0.5 &&
                       pixel.x() < c.pixel_image_width - 0.5 && pixel.y() < c.pixel_image_height - 0.5;
    thing["visible_share"] = share;
    thing["pixel_x"] = pixel.x();
    thing["pixel_y"] = pixel.y();
  };
  for (const PlayedRobot& robot : play.robots) {
    const Eigen::Vector2d& at = robot.solid.at_mm();
    const double height_mm = robot.solid.look().height_mm;
    Json thing{
        {"team", robot.team == 0 ? "yellow" : "blue"}, {"id", robot.id},     {"x", at.x()}, {"y", at.y()},
        {"orientation", robot.orientation_rad},        {"height", height_mm}};
    add_pixel(thing, {at.x(), at.y(), height_mm}, robot.share);
    robots.push_back(thing);
  }
  for (const PlayedBall& ball : play.balls) {
    Json thing{{"x", ball.at_mm.x()}, {"y", ball.at_mm.y()}};
    add_pixel(thing, {ball.at_mm.x(), ball.at_mm.y(), Ball::kRadiusMm}, ball.share);
    balls.push_back(thing);
  }
  return {{"frame", frame}, {"t", t_s}, {"robots", robots}, {"balls", balls}};
}

void write_file(const std::filesystem::path& path, const std::string& header,
                std::span<const std::uint8_t> bytes) {
  std::ofstream out(path, std::ios::binary);
  out << header;
  out.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  if (!out.flush()) throw std::runtime_error("cannot write " + path.string());
}

/// Brightness of a frame's lamps: random for each frame, or drifting if the frames are consecutive.
double lamps_of(const Options& o, std::uint64_t hall_seed, int frame) {
  if (o.lamps.empty()) return o.light;
  if (o.play.placement == Placement::kScatter) {
    return o.light *
           Chance(hall_seed, "lamps", static_cast<std::uint64_t>(frame)).log_uniform(o.lamps[0], o.lamps[1]);
  }
  const float wave = smooth_noise(frame / 40.0, 0.5, static_cast<std::uint32_t>(hall_seed));
  return o.light * std::exp(std::log(o.lamps[0]) + (0.5 + 0.5 * wave) * std::log(o.lamps[1] / o.lamps[0]));
}

void draw(Options o) {
  const bool is_acceptance = o.hall.kind == Kind::kAcceptance;
  if (o.lamps.empty()) o.lamps = is_acceptance ? std::vector{0.88, 1.12} : std::vector{0.75, 1.33};
  const int usual_robots[]{6, 8, 11}, usual_balls[]{2, 2, 3};
  o.play.robots = o.robots > 0 ? o.robots : usual_robots[static_cast<int>(o.hall.size)];
  o.play.balls = o.balls > 0 ? o.balls : usual_balls[static_cast<int>(o.hall.size)];

  o.hall.exposure_s = o.exposure_ms / 1000;
  o.hall.readout_s = o.readout_ms / 1000;

  const Hall hall = make_hall(o.hall);
  const CameraModel camera(hall.calibration);
  Painter painter(hall, camera);
  const Obstacles obstacles(camera, painter.obstacles());
  const Game game(hall, camera, obstacles, o.play);

  const std::filesystem::path folder(o.output);
  std::filesystem::create_directories(folder);
  std::ofstream(folder / "settings.json") << settings_json(hall, o.format).dump(2) << '\n';
  std::ofstream truth(folder / "truth.jsonl");
  for (int frame = o.first; frame < o.first + o.frames; ++frame) {
    const Play play = game.at(frame);
    const Picture light = painter.frame(play, frame, lamps_of(o, hall.seed, frame));
    const Chance noise(hall.seed, "noise", static_cast<std::uint64_t>(frame));
    const std::string name = fmt::format("{:06}", frame);
    write_file(folder / (name + ".raw"), "", camera_bytes(light, hall.sensor, o.format, noise));
    if (o.preview) {
      std::filesystem::create_directories(folder / "preview");
      write_file(folder / "preview" / (name + ".ppm"),
                 fmt::format("P6\n{} {}\n255\n", light.width, light.height),
                 camera_bytes(light, hall.sensor, PixelFormat::kRgb24, noise));
    }
    truth << truth_json(play, camera, name, frame / kFramesPerSecond).dump() << '\n';
  }
  if (!truth.flush()) throw std::runtime_error("cannot write " + (folder / "truth.jsonl").string());
}

}  // namespace
}  // namespace sslv::halls

int main(int argc, char** argv) {
  using namespace sslv;
  using namespace sslv::halls;
  CLI::App app("Draws frames of a hall with their truth: NUMBER.raw, truth.jsonl, settings.json");
  Options o;
  const auto choice = [&](const std::string& name, auto& value, auto names, const std::string& help) {
    return app.add_option(name, value, help)->transform(CLI::CheckedTransformer(names, CLI::ignore_case));
  };
  choice("--kind", o.hall.kind,
         Names<Kind>{{"acceptance", Kind::kAcceptance}, {"usual", Kind::kUsual}, {"hard", Kind::kHard}},
         "what hall");
  choice("--size", o.hall.size, Names<Size>{{"A", Size::kA}, {"B", Size::kB}, {"C", Size::kC}},
         "A 780x580 over half of 6x4 m, B 1280x1024 over half of 9x6 m, C 2448x2048 over half of 12x9 m");
  choice("--format", o.format,
         Names<PixelFormat>{{"uyvy", PixelFormat::kUyvy},
                            {"rgb24", PixelFormat::kRgb24},
                            {"bayer_rg8", PixelFormat::kBayerRg8}},
         "pixel format");
  choice("--placement", o.play.placement,
         Names<Placement>{{"scatter", Placement::kScatter}, {"paths", Placement::kPaths}},
         "other places in every frame, or slow motion at 60 frames a second");
  choice("--transfer", o.hall.transfer,
         Names<Transfer>{{"linear", Transfer::kLinear}, {"srgb", Transfer::kSrgb}}, "gamma of the camera");
  app.add_option("--seed", o.hall.seed, "which hall of its kind");
  app.add_option("--frames", o.frames, "how many")->check(CLI::Range(1, 1000000));
  app.add_option("--first", o.first, "number of the first frame: the same hall, other places")
      ->check(CLI::Range(1, 1000000));
  app.add_option("--output", o.output, "folder to write to")->required();
  app.add_option("--light", o.light, "fixed factor of all lamps")->check(CLI::Range(0.01, 20.0));
  app.add_option("--lamps", o.lamps, "LOW,HIGH: factor from frame to frame, besides --light")
      ->delimiter(',')
      ->expected(2);
  app.add_option("--px-per-mm", o.hall.px_per_mm, "scale in the middle of the picture")
      ->check(CLI::Range(0.02, 2.0));
  app.add_option("--tilt", o.hall.tilt_deg, "of the camera, degrees")->check(CLI::Range(-30.0, 30.0));
  app.add_option("--robots", o.robots, "of each team")->check(CLI::Range(1, 16));
  app.add_option("--balls", o.balls, "in each frame")->check(CLI::Range(1, 50));
  app.add_option("--speed", o.play.speed_mm_s, "of the fastest robot or ball, mm/s")
      ->check(CLI::Range(0.0, 20000.0));
  app.add_option("--exposure", o.exposure_ms, "ms, over which what moves is smeared")
      ->check(CLI::Range(0.0, 100.0));
  app.add_option(
         "--readout", o.readout_ms,
         "ms from the first row to the last, of a rolling shutter; the truth is that of the middle row")
      ->check(CLI::Range(0.0, 100.0));
  app.add_option("--distractors", o.hall.distractors, "flat things of other shapes on the field")
      ->check(CLI::Range(0, 500));
  app.add_option("--noise", o.hall.noise_grey, "standard deviation at grey 90")->check(CLI::Range(0.0, 60.0));
  app.add_option("--blur", o.hall.blur_px, "of the lens, pixels")->check(CLI::Range(0.0, 5.0));
  app.add_option("--uneven", o.hall.uneven, "of the lamps, share")->check(CLI::Range(0.0, 0.9));
  app.add_option("--vignette", o.hall.vignette, "of the lens, share in the corners")
      ->check(CLI::Range(0.0, 0.9));
  app.add_option("--banding", o.hall.banding, "of flickering lamps, share")->check(CLI::Range(0.0, 0.5));
  app.add_option("--jpeg", o.hall.jpeg_quality, "compressed on the way with this quality; 0: not")
      ->check(CLI::Range(0, 100));
  app.add_option("--mosaic", o.hall.is_mosaic, "1: uyvy and rgb24 are made from a Bayer sensor; 0: not");
  app.add_option("--height-spread", o.hall.height_spread_mm, "mm around the height in the settings")
      ->check(CLI::Range(0.0, 50.0));
  app.add_flag("--preview", o.preview, "each frame as preview/NUMBER.ppm as well");
  CLI11_PARSE(app, argc, argv);
  try {
    draw(o);
  } catch (const std::exception& error) {
    std::cerr << "draw_halls: " << error.what() << '\n';
    return EXIT_FAILURE;
  }
  return EXIT_SUCCESS;
}
