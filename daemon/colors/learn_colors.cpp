// SPDX-License-Identifier: Apache-2.0
#include "colors/learn_colors.h"

#include "colors/learn_background.h"
#include "colors/learn_balls.h"
#include "colors/learn_robots.h"
#include "colors/name_dots.h"
#include "colors/small_picture.h"
#include "colors/surfaces.h"
#include "vision/color_name.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace sslv {
namespace {

/// Number of robots needed. Fewer robots, but at least two, are enough if all their fits are beyond doubt.
constexpr std::size_t kEnoughRobots = 5;
constexpr double kClearR2 = 0.7, kClearRmsMm = 1.5;
constexpr double kMaxClippedShare = 0.35, kMinBright = 15, kMinColorfulness = 3;
/// Share of the learnt dots that the table must name correctly.
constexpr double kMinNamed = 0.9;
constexpr const char* kNeeded =
    "put at least five robots (both teams, and a ball) on the field, in the light of the match";

Color3 color_of(const Rgb& c) {
  return {static_cast<double>(c.r), static_cast<double>(c.g), static_cast<double>(c.b)};
}
Rgb rgb_of(const Color3& color) {
  const auto byte = [](double value) {
    return static_cast<std::uint8_t>(std::clamp(value + 0.5, 0.0, 255.0));
  };
  return {byte(color[0]), byte(color[1]), byte(color[2])};
}

bool is_background(Label label) {
  return label == label::kClear || label == label::kField || label == label::kWhite || label == label::kBlack;
}

/// Contrast of a label's print to black under these gains of the light.
Color3 print_contrast(Label label, const Color3& gains) {
  return (print_color(label) - print_color(label::kBlack)).cwiseProduct(gains);
}

/// Brightness of the light on each robot, and contrast of the robot's dots in that light.
class RobotLights {
 public:
  struct LitDot {
    double light;
    Color3 contrast;
  };

  void add(const SeenRobot& robot, const std::vector<Label>& labels, const NamedDots& dots) {
    std::vector<double> ratios;
    const auto contrast_of = [&](std::size_t i) {
      return unclipped_contrast(robot.dots[i], dots.chromaticities.at(labels[i]));
    };
    for (std::size_t i = 0; i < robot.dots.size(); ++i)
      ratios.push_back(contrast_of(i).sum() / std::max(1.0, print_contrast(labels[i], dots.gains).sum()));
    std::nth_element(ratios.begin(), ratios.begin() + static_cast<std::ptrdiff_t>(ratios.size() / 2),
                     ratios.end());
    const double light = std::max(0.01, ratios[ratios.size() / 2]);
    for (std::size_t i = 0; i < robot.dots.size(); ++i) dots_[labels[i]].push_back({light, contrast_of(i)});
    lights_.push_back(light);
  }

  /// For each robot: the median of its dots' contrasts, relative to the contrasts of prints.
  const std::vector<double>& lights() const { return lights_; }
  const std::map<Label, std::vector<LitDot>>& dots() const { return dots_; }
  /// Sum of the contrasts of a label's dots, each divided by its light; nothing without dots.
  std::optional<Color3> summed_contrast(Label label) const {
    const auto lit = dots_.find(label);
    if (lit == dots_.end()) return {};
    Color3 sum = Color3::Zero();
    for (const auto& [light, contrast] : lit->second) sum += contrast / light;
    return sum;
  }

 private:
  std::vector<double> lights_;
  std::map<Label, std::vector<LitDot>> dots_;
};

class Learner {
 public:
  explicit Learner(const LearnTask& task)
      : task_(task), search_{task.frames, {}, {}, task.patterns, task.mask, task.stop} {}

  LearntColors learn() {
    for (const auto step : {&Learner::look_at_pictures, &Learner::see_robots, &Learner::name_colors,
                            &Learner::see_background_and_balls, &Learner::predict, &Learner::make_table}) {
      (this->*step)();
      if (task_.stop.stop_requested()) out_.problem = "learning was stopped";
      if (!out_.problem.empty()) break;
    }
    if (!out_.problem.empty()) out_.lut = nullptr;
    describe();
    return std::move(out_);
  }

 private:
  /// Each of the task's frames at smaller scales, and its noise.
  struct SmallFrames {
    std::vector<SmallPictures> pictures;
    std::vector<double> noise_grey;
  };
  /// The labels that the images show.
  struct Sightings {
    std::map<Label, std::size_t> counts;
    std::vector<Label> unseen;  // to be predicted
  };

  void look_at_pictures() {
    if (task_.frames.empty()) {
      out_.problem = "no image was given";
      return;
    }
    const ImageView& first = task_.frames.front();
    small_frames_.pictures.reserve(task_.frames.size());
    double bright = 0, clipped = 0, colorfulness = 0;
    for (const ImageView& image : task_.frames) {
      if (task_.stop.stop_requested()) return;
      if (image.empty() || image.format != first.format || image.width != first.width ||
          image.height != first.height) {
        out_.problem = "the images are not all of one size and format";
        return;
      }
      if (!has_colors(image.format)) {
        out_.problem = "the camera sends grey images: choose a pixel format with colours";
        return;
      }
      constexpr int kMinSide = 32;
      if (std::min(image.width, image.height) < kMinSide) {
        out_.problem =
            fmt::format("images of {} x {} pixels are too small to learn from", image.width, image.height);
        return;
      }
      const PictureExposure exposure =
          exposure_of(small_frames_.pictures.emplace_back(image, task_.mask).of(2));
      const double per = 1 / static_cast<double>(task_.frames.size());
      bright = std::max(bright, exposure.bright);
      clipped += exposure.clipped_share * per;
      colorfulness += exposure.colorfulness * per;
      small_frames_.noise_grey.push_back(noise_of(image));
      out_.noise_grey += small_frames_.noise_grey.back() * per;
    }
    search_.noise_grey = small_frames_.noise_grey;
    search_.pictures = small_frames_.pictures;
    if (bright < kMinBright) {
      out_.problem = fmt::format(
          "the image is too dark: its brightest parts reach {:.0f} of 255; open the lens, "
          "raise exposure or gain, or switch the light on",
          bright);
    } else if (clipped > kMaxClippedShare) {
      out_.problem = fmt::format(
          "the image is over-exposed: {:.0f} % of it is saturated; lower exposure or gain", 100 * clipped);
    } else if (colorfulness < kMinColorfulness) {
      out_.problem = "the image is grey: check the camera's saturation and pixel format";
    }
  }

  void see_robots() {
    const ImageView& first = task_.frames.front();
    double mm_per_px = 0;
    std::vector<double> heights_mm{0};
    if (task_.scene.camera) {
      camera_ = task_.scene.camera;
      heights_mm = {task_.scene.robot_height_mm[0]};
      if (task_.scene.robot_height_mm[1] != heights_mm.front())
        heights_mm.push_back(task_.scene.robot_height_mm[1]);
    } else {
      mm_per_px = find_scale(search_);
      if (mm_per_px > 0) camera_ = flat_camera(first.width, first.height, mm_per_px);
    }
    if (camera_) {
      robots_ = task_.scene.camera ? find_patterns(search_, *camera_, heights_mm)
                                   : find_patterns_flat(search_, mm_per_px);
      const double area = camera_->mm2_per_px({first.width / 2.0, first.height / 2.0}, heights_mm.front());
      if (area > 0) out_.mm_per_px = std::sqrt(area);
    }
    if (!task_.scene.camera && !robots_.empty()) {
      std::vector<double> scales;
      for (const SeenRobot& robot : robots_) scales.push_back(1 / robot.px_per_mm);
      std::nth_element(scales.begin(), scales.begin() + static_cast<std::ptrdiff_t>(scales.size() / 2),
                       scales.end());
      out_.mm_per_px = scales[scales.size() / 2];
    }
    if (robots_.empty()) {
      out_.problem = fmt::format(
          "no robot was found{}: {}",
          camera_ && task_.scene.camera
              ? fmt::format(" (with patterns {} mm above the floor)", fmt::join(heights_mm, " and "))
              : "",
          kNeeded);
      return;
    }
    const bool clear_cut = std::all_of(robots_.begin(), robots_.end(), [](const SeenRobot& robot) {
      return robot.min_r2 > kClearR2 && robot.rms_mm < kClearRmsMm;
    });
    if (robots_.size() < kEnoughRobots && (robots_.size() < 2 || !clear_cut)) {
      out_.problem = fmt::format(
          "only {} robot{} found{}: {}", robots_.size(), robots_.size() == 1 ? " was" : "s were",
          task_.frames.size() > 1 ? fmt::format(" in {} images", task_.frames.size()) : "", kNeeded);
    } else if (robots_.size() < kEnoughRobots) {
      out_.notes.push_back(
          fmt::format("only {} robots were found: with more robots all over the field, the table would fit a "
                      "wider range of light",
                      robots_.size()));
    }
  }

  void name_colors() {
    dots_ = name_dots(robots_, task_.patterns, task_.guide);
    out_.problem = dots_.problem;
    for (const std::string& note : dots_.notes) out_.notes.push_back(note);
    if (!out_.problem.empty()) return;
    for (std::size_t i = 0; i < robots_.size(); ++i) {
      const SeenRobot& robot = robots_[i];
      lights_.add(robot, dots_.labels[i], dots_);
      for (std::size_t j = 0; j < robot.dots.size(); ++j) add(dots_.labels[i][j], robot.dots[j].color);
      add(label::kBlack, robot.black);
    }
  }

  void see_background_and_balls() {
    const auto carpet = carpet_chromaticity(search_, robots_);
    if (!carpet) {
      out_.problem =
          fmt::format("no carpet was found: the robots do not stand on one even surface; {}", kNeeded);
      return;
    }
    carpet_shares_ = *carpet;
    const CarpetAndLines ground = carpet_and_lines(search_, robots_, *carpet, dots_.gains);
    out_.samples.insert(out_.samples.end(), ground.samples.begin(), ground.samples.end());
    Color3 guided = Color3::Zero();
    for (const ColorSample& sample : task_.guide) {
      if (sample.label == label::kOrange) guided += color_of(sample.color);
    }
    balls_ = find_balls({search_, *camera_, task_.scene.field, task_.scene.camera.has_value(), robots_,
                         ground.white_chromaticity, *carpet, lights_.summed_contrast(label::kYellow),
                         guided.sum() > 0 ? std::optional(chromaticity_of(guided)) : std::nullopt});
    for (const SeenBall& ball : balls_) {
      for (const Color3& shade : ball.shades) add(label::kOrange, shade);
    }
  }

  /// Adds samples for unseen labels, and for seen labels at light levels at which they were not seen.
  void predict() {
    if (balls_.empty()) {
      sightings_.unseen.push_back(label::kOrange);
    }
    for (const Label label : dots_.unseen) {
      if (std::find(sightings_.unseen.begin(), sightings_.unseen.end(), label) == sightings_.unseen.end() &&
          !has_samples(label))
        sightings_.unseen.push_back(label);
    }
    for (const ColorSample& sample : task_.guide) {
      out_.samples.push_back(sample);
      std::erase(sightings_.unseen, sample.label);
    }
    // Drops predictions that look like a seen colour.
    constexpr double kTooAlike = 0.1;  // distance of chromaticities
    std::erase_if(sightings_.unseen, [&](Label label) {
      Color3 predicted = Color3::Zero();
      for (std::size_t i = 0; i < robots_.size(); ++i)
        predicted += robots_[i].black + lights_.lights()[i] * print_contrast(label, dots_.gains);
      predicted = chromaticity_of(predicted);
      for (const ColorSample& sample : out_.samples) {
        if (is_background(sample.label) ||
            (chromaticity_of(color_of(sample.color)) - predicted).norm() > kTooAlike)
          continue;
        out_.notes.push_back(
            fmt::format("{} was not seen and is left out: it would probably look like {} here",
                        label::kNames[label], label::kNames[sample.label]));
        return true;
      }
      return false;
    });
    for (const Label label : sightings_.unseen) {
      const Color3 contrast = print_contrast(label, dots_.gains);
      for (std::size_t i = 0; i < robots_.size(); ++i)
        add(label, robots_[i].black + lights_.lights()[i] * contrast);
    }
    if (std::find(sightings_.unseen.begin(), sightings_.unseen.end(), label::kOrange) !=
        sightings_.unseen.end())
      out_.notes.push_back("no ball was found: orange is predicted from the other colours");
    std::vector<std::string_view> names;
    for (const Label label : sightings_.unseen) {
      if (label != label::kOrange) names.push_back(label::kNames[label]);
    }
    if (!names.empty())
      out_.notes.push_back(
          fmt::format("not seen, and predicted from the other colours: {}", fmt::join(names, ", ")));

    // Predicts each colour in the darkest and in the brightest light on any robot.
    const std::vector<double>& lights = lights_.lights();
    if (lights.empty()) return;
    const auto [least, most] = std::minmax_element(lights.begin(), lights.end());
    const Color3 dim_black = robots_[static_cast<std::size_t>(least - lights.begin())].black,
                 bright_black = robots_[static_cast<std::size_t>(most - lights.begin())].black;
    std::vector<std::pair<Label, Color3>> more;
    for (const auto& [label, lit] : lights_.dots()) {
      double low = 1e9, high = 0;
      Color3 per_light = Color3::Zero();
      for (const auto& [light, contrast] : lit) {
        low = std::min(low, light);
        high = std::max(high, light);
        per_light += contrast / light / static_cast<double>(lit.size());
      }
      if (*least < 0.8 * low) more.emplace_back(label, dim_black + *least * per_light);
      if (*most > 1.25 * high) more.emplace_back(label, bright_black + *most * per_light);
    }
    for (const auto& [label, color] : more) add(label, color);
  }

  void make_table() {
    // The noise that a table allows for is also the allowed difference between colours. The table is too
    // narrow if it does not clearly name the dots from which it was learnt.
    constexpr double kMinNoiseGrey = 6, kWider = 1.6;
    constexpr int kWidths = 3;
    std::size_t best = 0;
    double noise_grey = std::max(out_.noise_grey, kMinNoiseGrey);
    const SurfaceColors surfaces = see_surfaces();
    const Prints prints = prints_of_samples();
    for (int i = 0; i < kWidths && !task_.stop.stop_requested(); ++i, noise_grey *= kWider) {
      ColorTable table = table_from_samples(out_.samples, BackgroundLabels::kClear, noise_grey);
      table.prints = prints;
      clear_surfaces(table, surfaces, {},
                     [this](Label label, Yuv color) { return is_like_seen(label, color); });
      auto lut = std::make_shared<const Lut>(std::move(table));
      const std::size_t named = count_named(*lut);
      if (named <= best) continue;
      best = named;
      out_.lut = std::move(lut);
      out_.table_noise_grey = noise_grey;
      if (named == dot_count()) break;
    }
    if (static_cast<double>(best) < kMinNamed * static_cast<double>(dot_count())) {
      out_.problem = fmt::format(
          "the colours cannot be distinguished: a table would name only {} of {} dots reliably; there is too "
          "little light, or too much noise",
          best, dot_count());
    } else if (out_.lut) {
      out_.margins = table_margins(*out_.lut, surfaces, task_.stop);
    }
  }

  /// Print colours of the labels, computed as detectors compare them: from the contrast to black for dots,
  /// from the colour for balls.
  Prints prints_of_samples() const {
    std::map<Label, std::vector<Color3>> chromaticities;
    for (const auto& [label, lit] : lights_.dots()) {
      for (const auto& [light, contrast] : lit) chromaticities[label].push_back(chromaticity_of(contrast));
    }
    for (const SeenBall& ball : balls_) chromaticities[label::kOrange].push_back(chromaticity_of(ball.body));
    for (const Label label : sightings_.unseen) {
      const Color3 seen = label == label::kOrange ? Color3(print_color(label).cwiseProduct(dots_.gains))
                                                  : print_contrast(label, dots_.gains);
      chromaticities[label].push_back(chromaticity_of(seen));
    }
    Prints out;
    for (const auto& [label, all] : chromaticities) {
      Color3 mean = Color3::Zero();
      for (const Color3& one : all) mean += one / static_cast<double>(all.size());
      double square = 0;
      for (const Color3& one : all) square += (one - mean).squaredNorm() / static_cast<double>(all.size());
      // Allows for other makers' prints, which the images need not show. An unseen label may also differ from
      // the usual print by the same amount.
      const double other_makers = label == label::kOrange ? 0.15 : 0.09;  // balls have highlights and shade
      const bool is_seen =
          std::find(sightings_.unseen.begin(), sightings_.unseen.end(), label) == sightings_.unseen.end();
      const double unknown = is_seen ? other_makers : std::numbers::sqrt2 * other_makers;
      PrintColor print{};
      for (int c = 0; c < 3; ++c)
        print.chromaticity[static_cast<std::size_t>(c)] =
            static_cast<std::uint16_t>(std::lround(PrintColor::kUnit * std::max(0.0, mean[c]) / mean.sum()));
      print.spread =
          static_cast<std::uint16_t>(std::lround(PrintColor::kUnit * std::hypot(std::sqrt(square), unknown)));
      out[label] = print;
    }
    return out;
  }
  SurfaceColors see_surfaces() {
    constexpr double kRobotReachMm = 130, kBallReach = 1.6;
    std::vector<PixelDisc> left_out;
    for (const SeenRobot& robot : robots_)
      left_out.push_back({robot.frame, robot.pixel_x, robot.pixel_y, kRobotReachMm * robot.px_per_mm});
    for (const SeenBall& ball : balls_)
      left_out.push_back({ball.frame, ball.pixel_x, ball.pixel_y, kBallReach * ball.radius_px});
    const double largest_mm =
        std::max(task_.patterns.center_diameter_mm, 2.0 * task_.scene.field.ball_radius);
    return find_surfaces({task_.frames,
                          small_frames_.pictures,
                          task_.mask,
                          left_out,
                          largest_mm * largest_px_per_mm(),
                          carpet_shares_,
                          {},
                          task_.stop});
  }
  /// Whether a colour is one of the label's samples in more or less light.
  bool is_like_seen(Label label, Yuv color) const {
    constexpr double kDarkest = 0.4, kBrightest = 1.7;
    const Color3 here = color_of(to_rgb(color));
    return std::any_of(out_.samples.begin(), out_.samples.end(), [&](const ColorSample& sample) {
      if (sample.label != label) return false;
      const Color3 seen = color_of(sample.color);
      const double factor = here.dot(seen) / std::max(1.0, seen.squaredNorm());
      return factor > kDarkest && factor < kBrightest &&
             (here - factor * seen).norm() < 6 + out_.noise_grey + 0.13 * here.norm();
    });
  }
  std::size_t dot_count() const { return robots_.size() * (task_.patterns.dots.size() + 1); }
  /// Number of dots that the table names with certainty.
  std::size_t count_named(const Lut& lut) const {
    constexpr double kMinMargin = 0.4, kMaxOff = 1.3;
    std::size_t count = 0;
    for (std::size_t i = 0; i < robots_.size(); ++i) {
      for (std::size_t j = 0; j < robots_[i].dots.size(); ++j) {
        const SeenDot& dot = robots_[i].dots[j];
        const auto array = [](const Color3& color) { return std::array{color[0], color[1], color[2]}; };
        const ColorName name = name_color(
            array(dot.contrast), array(dot.color), lut,
            j == 0 ? std::span<const Label>(task_.patterns.team_colors) : task_.patterns.side_colors);
        if (name.color == dots_.labels[i][j] && name.margin > kMinMargin && name.off < kMaxOff) ++count;
      }
    }
    return count;
  }

  /// Adds the used robots, balls and samples to the report.
  void describe() {
    for (std::size_t i = 0; i < robots_.size() && i < dots_.labels.size(); ++i) {
      const SeenRobot& seen = robots_[i];
      const std::vector<Label>& labels = dots_.labels[i];
      LearntRobot robot{seen.frame,
                        labels.front() == task_.patterns.team_colors[1] ? Team::kBlue : Team::kYellow,
                        -1,
                        seen.pixel_x,
                        seen.pixel_y,
                        seen.pose.angle_rad,
                        seen.px_per_mm,
                        {}};
      for (const PatternTable::Code& code : task_.patterns.codes) {
        if (std::equal(code.colors.begin(), code.colors.end(), labels.begin() + 1, labels.end()))
          robot.id = code.id;
      }
      for (std::size_t j = 0; j < seen.dots.size(); ++j)
        robot.dots.push_back(
            {labels[j], seen.dots[j].pixel_x, seen.dots[j].pixel_y, rgb_of(seen.dots[j].color)});
      out_.robots.push_back(std::move(robot));
    }
    for (const SeenBall& ball : balls_)
      out_.balls.push_back({ball.frame, ball.pixel_x, ball.pixel_y, ball.radius_px, rgb_of(ball.body)});
    for (std::size_t i = 0; i < label::kCount; ++i) {
      const auto label = static_cast<Label>(i);
      LearntLabel one{label, 0, 0, {}, 0};
      Color3 mean = Color3::Zero(), square = Color3::Zero();
      double count = 0;
      for (const ColorSample& sample : out_.samples) {
        if (sample.label != label) continue;
        const Color3 color = color_of(sample.color);
        mean += color;
        square += color.cwiseProduct(color);
        ++count;
      }
      if (count == 0) continue;
      mean /= count;
      one.mean = rgb_of(mean);
      one.spread = std::sqrt(std::max(0.0, (square / count - mean.cwiseProduct(mean)).sum()));
      one.guided = static_cast<std::size_t>(
          std::count_if(task_.guide.begin(), task_.guide.end(),
                        [&](const ColorSample& sample) { return sample.label == label; }));
      const bool predicted =
          std::find(sightings_.unseen.begin(), sightings_.unseen.end(), label) != sightings_.unseen.end();
      if (is_background(label)) {
        one.seen = static_cast<std::size_t>(count) - one.guided;
      } else if (const auto seen = sightings_.counts.find(label);
                 seen != sightings_.counts.end() && !predicted) {
        one.seen = seen->second;
      }
      out_.labels.push_back(one);
    }
  }

  void add(Label label, const Color3& color) {
    out_.samples.push_back({label, rgb_of(color)});
    ++sightings_.counts[label];
  }
  bool has_samples(Label label) const {
    return std::any_of(out_.samples.begin(), out_.samples.end(),
                       [&](const ColorSample& sample) { return sample.label == label; });
  }
  double largest_px_per_mm() const {
    double out = 0;
    for (const SeenRobot& robot : robots_) out = std::max(out, robot.px_per_mm);
    return out;
  }

  const LearnTask& task_;
  SmallFrames small_frames_;
  RobotSearch search_;
  std::optional<CameraModel> camera_;
  std::vector<SeenRobot> robots_;
  NamedDots dots_;
  RobotLights lights_;
  Sightings sightings_;
  std::vector<SeenBall> balls_;
  Color3 carpet_shares_ = Color3::Zero();
  LearntColors out_;
};

}  // namespace

std::size_t LearntColors::robots_of(Team team) const {
  return static_cast<std::size_t>(std::count_if(
      robots.begin(), robots.end(), [&](const LearntRobot& robot) { return robot.team == team; }));
}

LearntColors learn_colors(const LearnTask& task) {
  return Learner(task).learn();
}

}  // namespace sslv
