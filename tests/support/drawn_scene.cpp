// SPDX-License-Identifier: Apache-2.0
#include "support/drawn_scene.h"

#include "base/params_json.h"
#include "capture/simulator/simulator_renderer.h"
#include "vision/lut_from_samples.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <string>
#include <tuple>
#include <utility>

#include <Eigen/Geometry>
#include <fmt/format.h>

namespace sslv {
namespace {

/// The paints' colours, read from an image with a large disc of each.
std::array<Rgb, paint::kCount> read_paints() {
  SimulatorOptions options = plain_options();
  const CameraModel camera(overhead_camera());
  SimulatedScene scene;
  const auto x_mm = [](int paint) { return 300.0 * (paint % 4); };
  const auto y_mm = [](int paint) { return 300.0 * (paint / 4); };
  for (int i = 0; i < paint::kCount; ++i) {
    scene.distractors.push_back(
        {SimulatedDistractor::Shape::kEllipse, static_cast<std::uint8_t>(i), x_mm(i), y_mm(i), 0, 200, 200});
  }
  const LightPicture picture = SimulatorRenderer(options, {}, camera, league_patterns()).background(scene);
  std::array<Rgb, paint::kCount> out;
  for (int i = 0; i < paint::kCount; ++i) {
    const Eigen::Vector2d pixel = *camera.project({x_mm(i), y_mm(i), 0});
    const std::uint16_t* light =
        picture.at(static_cast<int>(std::lround(pixel.x())), static_cast<int>(std::lround(pixel.y())));
    const auto byte = [&](int c) {
      return static_cast<std::uint8_t>(light[c] / static_cast<double>(LightPicture::kPerGrey) + 0.5);
    };
    out[static_cast<std::size_t>(i)] = {byte(0), byte(1), byte(2)};
  }
  return out;
}

/// A table as an admin makes it by clicking each colour at full and at reduced brightness. Cached, because
/// building a table is slow.
std::shared_ptr<const Lut> lut_for(const SimulatorOptions& options) {
  using Light = std::tuple<double, double, double, double>;
  static std::map<Light, std::shared_ptr<const Lut>> made;
  auto& lut = made[{options.light, options.red_gain, options.blue_gain, options.gradient}];
  if (lut) return lut;
  std::vector<ColorSample> samples;
  for (const Label label : {label::kField, label::kOrange, label::kYellow, label::kBlue, label::kPink,
                            label::kGreen, label::kWhite, label::kBlack}) {
    const Rgb color = paint_color(label);
    for (const double shade : {1.0, 0.9, 0.8}) {
      for (const double across : {0.0, 0.5, 1.0}) {
        const double light = shade * options.light * (1 - across * options.gradient);
        const auto byte = [&](double value) {
          return static_cast<std::uint8_t>(std::clamp(value * light, 0.0, 255.0) + 0.5);
        };
        samples.push_back(
            {label, {byte(color.r * options.red_gain), byte(color.g), byte(color.b * options.blue_gain)}});
      }
    }
  }
  lut = std::make_shared<const Lut>(lut_from_samples(samples));
  return lut;
}

}  // namespace

CameraCalibration overhead_camera() {
  CameraCalibration c;
  c.focal_length = 600;
  c.principal_point_x = 389.5, c.principal_point_y = 289.5;
  c.distortion = 0.1;
  c.q0 = std::numbers::sqrt2 / 2, c.q1 = -std::numbers::sqrt2 / 2, c.q2 = 0, c.q3 = 0;
  c.tx = 0, c.ty = 1250, c.tz = 3500;  // above (1250, 0)
  c.pixel_image_width = 780, c.pixel_image_height = 580;
  return c;
}

CameraCalibration oblique_camera() {
  CameraCalibration c = overhead_camera();
  const Eigen::Quaterniond down(c.q3, c.q0, c.q1, c.q2);
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(std::numbers::pi / 6, Eigen::Vector3d::UnitX()));
  const Eigen::Quaterniond q = turn * down;
  const Eigen::Vector3d sight = q.inverse() * Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d eye = Eigen::Vector3d(1250, 0, 0) + sight * (3500 / sight.z());
  const Eigen::Vector3d t = -(q * eye);
  c.q0 = q.x(), c.q1 = q.y(), c.q2 = q.z(), c.q3 = q.w();
  c.tx = t.x(), c.ty = t.y(), c.tz = t.z();
  return c;
}

CameraCalibration wide_camera(double times) {
  CameraCalibration c = overhead_camera();
  c.focal_length /= times;
  return c;
}

SimulatorOptions plain_options(PixelFormat format, double noise_sigma) {
  SimulatorOptions options;
  options.width = 780, options.height = 580;
  options.pixel_format = format;
  options.noise_sigma = noise_sigma;
  options.vignette = 0;
  return options;
}

Rgb paint_color(std::uint8_t paint) {
  static const auto kPaints = read_paints();
  return kPaints.at(paint);
}

DrawnScene::DrawnScene(const SimulatorOptions& options, const CameraCalibration& camera,
                       std::array<double, 2> robot_height_mm, const FieldSize& field)
    : options_(options), sensor_(options, 1) {
  options_.placement = SimulatorPlacement::kScatter;  // draws distractors together with robots and balls
  scene_.field = field;
  scene_.camera.emplace(camera);
  scene_.robot_height_mm = robot_height_mm;
}

const std::shared_ptr<const Lut>& DrawnScene::lut_pointer() {
  if (!lut_) lut_ = lut_for(options_);
  return lut_;
}

void DrawnScene::add_robot(Team team, int id, double x_mm, double y_mm, double angle_rad, int covered_dot) {
  things_.robots.push_back({team, id, x_mm, y_mm, std::remainder(angle_rad, 2 * std::numbers::pi),
                            scene_.height_of(team),
                            covered_dot < 0 ? std::nullopt : std::optional(covered_dot)});
  image_.reset();
}

void DrawnScene::add_ball(double x_mm, double y_mm) {
  things_.balls.push_back({x_mm, y_mm});
  image_.reset();
}

void DrawnScene::add_thing(const SimulatedDistractor& thing) {
  things_.distractors.push_back(thing);
  image_.reset();
}

void DrawnScene::cover(double x_mm, double y_mm, double z_mm, double radius_mm, Rgb color) {
  const Eigen::Vector2d middle(x_mm, y_mm);
  covers_.push_back({[=](const Eigen::Vector2d& p) { return (p - middle).norm() < radius_mm; }, middle, z_mm,
                     radius_mm, color});
  image_.reset();
}

void DrawnScene::cover_bar(double x1_mm, double y1_mm, double x2_mm, double y2_mm, double z_mm,
                           double width_mm, Rgb color) {
  const Eigen::Vector2d from(x1_mm, y1_mm), to(x2_mm, y2_mm), middle = (from + to) / 2;
  const double length_mm = (to - from).norm();
  const Eigen::Vector2d along = (to - from) / length_mm;
  covers_.push_back({[=](const Eigen::Vector2d& p) {
                       const Eigen::Vector2d rel = p - middle;
                       return std::abs(rel.dot(along)) < length_mm / 2 &&
                              std::abs(rel.x() * along.y() - rel.y() * along.x()) < width_mm / 2;
                     },
                     middle, z_mm, (length_mm + width_mm) / 2, color});
  image_.reset();
}

void DrawnScene::clear() {
  things_ = {};
  covers_.clear();
  image_.reset();
}

void DrawnScene::use_lut(std::shared_ptr<const Lut> lut) {
  lut_ = std::move(lut);
  regions_.reset();
}

/// A pixel's coverage is the fraction of a grid of points that is covered.
void DrawnScene::paint(const Cover& cover, LightPicture& picture) const {
  const int points = cover.reach_mm < 60 ? 12 : 4;  // per axis
  const CameraModel& camera = *scene_.camera;
  const auto middle = camera.project({cover.middle_mm.x(), cover.middle_mm.y(), cover.z_mm});
  if (!middle) return;
  const double mm2 = camera.mm2_per_px(*middle, cover.z_mm);
  const double reach_px = 2 * cover.reach_mm / std::sqrt(mm2) + 2;
  const auto from = [&](double at) { return std::max(0, static_cast<int>(at - reach_px)); };
  const auto to = [&](double at, int size) { return std::min(size, static_cast<int>(at + reach_px) + 1); };
  const std::array<double, 3> light{options_.light * options_.red_gain, options_.light,
                                    options_.light * options_.blue_gain};
  const std::array<int, 3> color{cover.color.r, cover.color.g, cover.color.b};
  for (int y = from(middle->y()); y < to(middle->y(), picture.height); ++y) {
    for (int x = from(middle->x()); x < to(middle->x(), picture.width); ++x) {
      int inside = 0;
      for (int i = 0; i < points * points; ++i) {
        const Eigen::Vector2d point(x + (i % points + 0.5) / points - 0.5,
                                    y + (i / points + 0.5) / points - 0.5);
        const auto place = camera.unproject(point, cover.z_mm);
        inside += place && cover.is_in(*place);
      }
      const double share = inside / static_cast<double>(points * points);
      std::uint16_t* out = picture.at(x, y);
      for (std::size_t c = 0; c < 3; ++c) {
        const double ink = color[c] * light[c] * LightPicture::kPerGrey;
        out[c] = static_cast<std::uint16_t>(std::min(65535.0, out[c] + share * (ink - out[c]) + 0.5));
      }
    }
  }
}

namespace {

/// The empty field, cached for all scenes with the same camera, field and light, because drawing it is slow.
const LightPicture& carpet(const SimulatorRenderer& renderer, const SimulatorOptions& options,
                           const Scene& scene) {
  static std::map<std::string, LightPicture> carpets;
  const std::string key =
      fmt::format("{} {} {} {} {} {} {} ", options.width, options.height, options.light, options.gradient,
                  options.vignette, options.red_gain, options.blue_gain) +
      params_to_json(scene.camera->calibration()).dump() + params_to_json(scene.field).dump();
  const auto known = carpets.find(key);
  return known != carpets.end() ? known->second : carpets.emplace(key, renderer.background({})).first->second;
}

}  // namespace

void DrawnScene::draw() {
  const CameraModel& camera = *scene_.camera;
  const SimulatorRenderer renderer(options_, scene_.field, camera, *patterns_);
  LightPicture picture = carpet(renderer, options_, scene_);
  SimulatorRenderer::Boxes boxes;
  renderer.draw({&things_, 1}, picture, boxes);
  for (const Cover& cover : covers_) paint(cover, picture);
  std::vector<std::uint8_t> clean(sensor_.picture_bytes());
  sensor_.develop(picture, {0, 0, options_.width, options_.height}, clean.data());
  bytes_ = std::make_unique<std::uint8_t[]>(clean.size());
  sensor_.add_noise(clean.data(), bytes_.get());
}

const Image& DrawnScene::image() {
  if (!image_) {
    draw();
    const std::ptrdiff_t stride = std::ptrdiff_t{options_.width} * bytes_per_pixel(options_.pixel_format);
    image_.emplace(ImageView{bytes_.get(), options_.width, options_.height, stride, options_.pixel_format},
                   nullptr, nullptr, nullptr);
    regions_.reset();
  }
  return *image_;
}

void DrawnScene::use_single_cells() {
  segmentation_.regions.min_cells = 1;
  regions_.reset();
}

const RegionList& DrawnScene::regions() {
  const Image& picture = image();
  if (!regions_) {
    RunList runs;
    Segment().process(segmentation_, lut(), Mask(), picture, runs, regions_.emplace());
  }
  return *regions_;
}

RobotList DrawnScene::robots(const DetectRobots::Params& params) {
  DetectRobots detector;
  return robots_by(detector, 0, params);
}

RobotList DrawnScene::robots_by(DetectRobots& detector, double t_s, const DetectRobots::Params& params) {
  RobotList out;
  FrameInfo info;
  info.times.t_capture_s = t_s;
  const RegionList& found = regions();
  StageNotes notes;
  detector.process(params, scene_, *patterns_, lut(), Mask(), info, image(), found, out, notes);
  return out;
}

BallList DrawnScene::balls(const DetectBalls::Params& params) {
  BallList out;
  const RegionList& found = regions();
  DetectBalls().process(params, scene_, lut(), Mask(), {}, image(), found, robots(), out);
  return out;
}

}  // namespace sslv
