// SPDX-License-Identifier: Apache-2.0
// The cost of detecting robots and balls: the fits alone for each instruction set of this CPU, the whole
// stages, and worst-case input. Medians of many runs over a few images, one thread, in microseconds.
#include "capture/simulator/simulator.h"
#include "capture/simulator/simulator_camera.h"
#include "colors/learn_colors.h"
#include "support/simd_target.h"
#include "vision/detect_balls.h"
#include "vision/detect_robots.h"
#include "vision/disc_kernel.h"
#include "vision/lut_from_samples.h"
#include "vision/segment.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <random>
#include <vector>

#include <Eigen/Geometry>
#include <fmt/format.h>

namespace sslv {
namespace {

constexpr int kPictures = 6, kRuns = 60;

/// A camera over one half of a field, as in docs/accuracy.md.
struct Setting {
  const char* name;
  int width, height, field_length, field_width;
  double camera_height_mm;
};
constexpr std::array kSettings{
    Setting{"780x580, half of 6x4 m", 780, 580, 6000, 4000, 4000},
    Setting{"1280x1024, half of 9x6 m", 1280, 1024, 9000, 6000, 5000},
    Setting{"2448x2048, half of 12x9 m", 2448, 2048, 12000, 9000, 6000},
};
constexpr std::array kFormats{PixelFormat::kUyvy, PixelFormat::kRgb24, PixelFormat::kBayerRg8};

Scene scene_of(const Setting& setting) {
  Scene scene;
  scene.field.field_length = setting.field_length / 2;
  scene.field.field_width = setting.field_width;
  CameraCalibration c;
  const double px_per_mm = std::min(setting.height / (scene.field.field_length + 400.0),
                                    setting.width / (scene.field.field_width + 400.0));
  c.focal_length = 0.97 * px_per_mm * setting.camera_height_mm;
  c.principal_point_x = setting.width / 2.0 + 3;
  c.principal_point_y = setting.height / 2.0 - 2;
  c.distortion = 0.08;
  const Eigen::Quaterniond turn = Eigen::AngleAxisd(M_PI - 0.02, Eigen::Vector3d::UnitX()) *
                                  Eigen::AngleAxisd(M_PI / 2 + 0.01, Eigen::Vector3d::UnitZ());
  const Eigen::Vector3d shift = -(turn * Eigen::Vector3d(20, -30, setting.camera_height_mm));
  c.q0 = turn.x(), c.q1 = turn.y(), c.q2 = turn.z(), c.q3 = turn.w();
  c.tx = shift.x(), c.ty = shift.y(), c.tz = shift.z();
  c.pixel_image_width = setting.width, c.pixel_image_height = setting.height;
  scene.camera.emplace(c);
  return scene;
}

struct Picture {
  std::vector<std::uint8_t> bytes;
  ImageView view;
  SimulatedScene truth;
};

std::vector<Picture> draw(const Setting& setting, PixelFormat format, const Scene& scene, int robots_each,
                          int balls) {
  const Json options{{"width", setting.width},
                     {"height", setting.height},
                     {"pixel_format", name_of(format)},
                     {"noise_sigma", 4},
                     {"gradient", 0.3},
                     {"vignette", 0.15},
                     {"placement", "scatter"},
                     {"touching", 4},
                     {"touching_gap_mm", 8},
                     {"robots_yellow", robots_each},
                     {"robots_blue", robots_each},
                     {"balls", balls}};
  SimulatedCamera camera(simulator_options(options, ""), {0, scene}, league_patterns());
  std::vector<Picture> out(kPictures);
  for (int i = 0; i < kPictures; ++i) {
    Picture& picture = out[static_cast<std::size_t>(i)];
    picture.bytes.resize(camera.picture_bytes());
    camera.draw(i, picture.bytes.data());
    picture.view = camera.layout();
    picture.view.data = picture.bytes.data();
    picture.truth = camera.scene_at(i);
  }
  return out;
}

/// Samples of the simulator's paints at three brightnesses, as an admin would click.
std::shared_ptr<const Lut> table() {
  const ColorSample paints[] = {{label::kOrange, {238, 108, 32}}, {label::kYellow, {224, 198, 38}},
                                {label::kBlue, {28, 92, 196}},    {label::kPink, {230, 64, 150}},
                                {label::kGreen, {108, 212, 62}},  {label::kField, {30, 92, 62}},
                                {label::kWhite, {205, 205, 200}}, {label::kBlack, {24, 24, 27}}};
  std::vector<ColorSample> samples;
  for (const double light : {0.55, 0.75, 1.0}) {
    for (const auto& [label, c] : paints) {
      const auto dim = [&](std::uint8_t v) { return static_cast<std::uint8_t>(light * v); };
      samples.push_back({label, {dim(c.r), dim(c.g), dim(c.b)}});
    }
  }
  return std::make_shared<const Lut>(lut_from_samples(samples));
}

/// Instruction sets of this CPU that the fits are compiled for, best first.
std::vector<std::int64_t> targets() {
  std::vector<std::int64_t> out;
  for (const std::int64_t target : cpu_targets()) {
    const OnlyTarget only(target);
    if (name_of_target(target) == disc_kernel_target()) out.push_back(target);
  }
  return out;
}

template <class Work>
double median_us(std::size_t pictures, const Work& work) {
  std::vector<double> us;
  for (int run = -2; run < kRuns; ++run) {  // the first two runs warm up
    for (std::size_t i = 0; i < pictures; ++i) {
      const auto begin = std::chrono::steady_clock::now();
      work(i);
      const std::chrono::duration<double, std::micro> took = std::chrono::steady_clock::now() - begin;
      if (run >= 0) us.push_back(took.count());
    }
  }
  std::nth_element(us.begin(), us.begin() + static_cast<std::ptrdiff_t>(us.size() / 2), us.end());
  return us[us.size() / 2];
}

/// 12 robots, 60 dots, one fit from about where the regions' centroids would start it.
void bench_fits(const Lut& lut) {
  std::printf("\nFits of 12 robots (60 dots), by instruction set\n%-28s%-11s", "", "");
  for (const std::int64_t target : targets()) std::printf("%10s", name_of_target(target).c_str());
  std::printf("\n");
  for (const Setting& setting : kSettings) {
    const Scene scene = scene_of(setting);
    for (const PixelFormat format : kFormats) {
      const std::vector<Picture> pictures = draw(setting, format, scene, 6, 0);
      std::printf("%-28s%-11s", setting.name, std::string(name_of(format)).c_str());
      for (const std::int64_t target : targets()) {
        const OnlyTarget only(target);
        PatternFitter fitter;
        const double us = median_us(pictures.size(), [&](std::size_t i) {
          const PatternFitter::Frame frame{pictures[i].view, *scene.camera, league_patterns(), lut, 0.55};
          int n = 0;
          for (const SimulatedRobot& robot : pictures[i].truth.robots) {
            const double dx = 0.25 * (n % 3 - 1), dy = 0.3 * (n % 2 - 0.5), turn = 0.004 * (n % 4 - 1.5);
            ++n;
            fitter.fit(frame, {robot.x_mm + dx, robot.y_mm + dy, robot.orientation_rad + turn},
                       robot.height_mm, 1);
          }
        });
        std::printf("%10.1f", us);
      }
      std::printf("\n");
    }
  }
}

struct Stages {
  DetectRobots robots;
  DetectBalls balls;
  RobotList robot_list;
  BallList ball_list;
  StageNotes notes;
};

void bench_stages(const std::shared_ptr<const Lut>& lut) {
  std::printf("\nWhole stages, 22 robots and 6 balls\n%-28s%-11s%14s%14s%10s%12s%10s\n", "", "",
              "detect_robots", "detect_balls", "together", "robots", "balls");
  for (const Setting& setting : kSettings) {
    const Scene scene = scene_of(setting);
    for (const PixelFormat format : kFormats) {
      const std::vector<Picture> pictures = draw(setting, format, scene, 11, 6);
      Stages stages;
      DetectRobots::Params no_memory;
      no_memory.memory_ms = 0;  // the images are unrelated
      std::vector<RegionList> regions(pictures.size());
      std::vector<RobotList> robots(pictures.size());
      double found_robots = 0, found_balls = 0;
      for (std::size_t i = 0; i < pictures.size(); ++i) {
        RunList runs;
        Segment().process({}, *lut, Mask(), Image(pictures[i].view, nullptr, nullptr, nullptr), runs,
                          regions[i]);
      }
      const double robots_us = median_us(pictures.size(), [&](std::size_t i) {
        stages.robots.process(no_memory, scene, league_patterns(), *lut, Mask(), {},
                              Image(pictures[i].view, nullptr, nullptr, nullptr), regions[i], robots[i],
                              stages.notes);
      });
      const double balls_us = median_us(pictures.size(), [&](std::size_t i) {
        stages.balls.process({}, scene, *lut, Mask(), {}, Image(pictures[i].view, nullptr, nullptr, nullptr),
                             regions[i], robots[i], stages.ball_list);
        found_balls = static_cast<double>(stages.ball_list.balls.size());
      });
      for (const RobotList& list : robots)
        found_robots += static_cast<double>(list.robots.size()) / kPictures;
      std::printf("%-28s%-11s%14.1f%14.1f%10.1f%12.1f%10.1f\n", setting.name,
                  std::string(name_of(format)).c_str(), robots_us, balls_us, robots_us + balls_us,
                  found_robots, found_balls);
    }
  }
}

/// Dot-sized squares in all print colours everywhere: each might belong to a robot.
void bench_hostile(const std::shared_ptr<const Lut>& lut) {
  const Setting& setting = kSettings[2];
  const Scene scene = scene_of(setting);
  constexpr std::array<std::array<std::uint8_t, 3>, 5> kPaints{
      {{238, 108, 32}, {224, 198, 38}, {28, 92, 196}, {230, 64, 150}, {108, 212, 62}}};
  std::printf("\nHostile pictures, %s, rgb24: squares of the prints' colours\n%-28s%10s%14s%14s%8s%8s\n",
              setting.name, "", "regions", "detect_robots", "detect_balls", "robots", "capped");
  for (const int pitch_px : {48, 24, 16, 12}) {
    std::vector<std::uint8_t> bytes(
        static_cast<std::size_t>(setting.width) * static_cast<std::size_t>(setting.height) * 3, 24);
    std::mt19937 random(1);
    for (int y = 0; y + pitch_px <= setting.height; y += pitch_px) {
      for (int x = 0; x + pitch_px <= setting.width; x += pitch_px) {
        const auto& paint = kPaints[random() % kPaints.size()];
        for (int j = 0; j < std::min(10, pitch_px - 3); ++j) {
          for (int i = 0; i < std::min(10, pitch_px - 3); ++i)
            std::copy(paint.begin(), paint.end(), bytes.begin() + 3 * ((y + j) * setting.width + x + i));
        }
      }
    }
    const ImageView view{bytes.data(), setting.width, setting.height, setting.width * 3, PixelFormat::kRgb24};
    const Image image(view, nullptr, nullptr, nullptr);
    RunList runs;
    RegionList regions;
    Segment().process({}, *lut, Mask(), image, runs, regions);
    Stages stages;
    const double robots_us = median_us(1, [&](std::size_t) {
      stages.robots.process({}, scene, league_patterns(), *lut, Mask(), {}, image, regions, stages.robot_list,
                            stages.notes);
    });
    const double balls_us = median_us(1, [&](std::size_t) {
      stages.balls.process({}, scene, *lut, Mask(), {}, image, regions, stages.robot_list, stages.ball_list);
    });
    std::printf("%-28s%10zu%14.0f%14.0f%8zu%8s\n", fmt::format("every {} px", pitch_px).c_str(),
                regions.regions.size(), robots_us, balls_us, stages.robot_list.robots.size(),
                stages.robot_list.capped || stages.ball_list.capped ? "yes" : "no");
  }
}

/// Learning colours from three images, with and without a calibration.
void bench_learning() {
  std::printf("\nLearning colours from three pictures, milliseconds\n%-28s%-11s%14s%14s\n", "", "",
              "calibrated", "without");
  for (const Setting& setting : kSettings) {
    const Scene scene = scene_of(setting);
    Scene uncalibrated = scene;
    uncalibrated.camera.reset();
    const Scene& without = uncalibrated;
    for (const PixelFormat format : kFormats) {
      const std::vector<Picture> pictures = draw(setting, format, scene, 6, 1);
      std::printf("%-28s%-11s", setting.name, std::string(name_of(format)).c_str());
      for (const Scene* one : {&scene, &without}) {
        const LearnTask task{{pictures[0].view, pictures[1].view, pictures[2].view}, *one, league_patterns()};
        std::vector<double> ms;
        for (int run = 0; run < 5; ++run) {
          const auto begin = std::chrono::steady_clock::now();
          const bool learnt = learn_colors(task).problem.empty();
          const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - begin;
          if (learnt) ms.push_back(took.count());
        }
        std::sort(ms.begin(), ms.end());
        std::printf("%14s", ms.empty() ? "not learnt" : fmt::format("{:.0f}", ms[ms.size() / 2]).c_str());
      }
      std::printf("\n");
    }
  }
}

}  // namespace
}  // namespace sslv

int main() {
  const auto lut = sslv::table();
  sslv::bench_fits(*lut);
  sslv::bench_stages(lut);
  sslv::bench_hostile(lut);
  sslv::bench_learning();
}
