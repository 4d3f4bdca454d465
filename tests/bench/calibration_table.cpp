// SPDX-License-Identifier: Apache-2.0
// Calibration accuracy, as a table in Markdown: images of exactly known cameras, with robots on the field and
// noise of sigma 4. Takes many minutes. The first argument, 1 or 2, leaves the larger images out; a second
// one is the name of the only table to print (main() has them).
#include "calibration/calibrate.h"
#include "calibration/refine_jointly.h"
#include "calibration/way_round.h"
#include "support/painted_floor.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <numbers>
#include <random>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Geometry>

namespace sslv {
namespace {

constexpr std::array kSizeNames{"780x580", "1280x1024", "2448x2048"};

/// Values of one kind; text() gives "median (maximum)".
class Figures {
 public:
  void add(double value) { values_.push_back(value); }
  std::string text(int digits = 3) const {
    if (values_.empty()) return "";
    std::vector<double> sorted = values_;
    std::sort(sorted.begin(), sorted.end());
    char out[64];
    std::snprintf(out, sizeof out, "%.*f (%.*f)", digits, sorted[sorted.size() / 2], digits, sorted.back());
    return out;
  }

 private:
  std::vector<double> values_;
};

struct Share {
  int yes = 0, all = 0;
  void add(bool one) {
    yes += one ? 1 : 0;
    ++all;
  }
  std::string text() const { return std::to_string(yes) + "/" + std::to_string(all); }
};

struct Shot {
  LensCamera camera;
  PaintedFloor floor;
  MeanPicture picture;
};

Shot take(const FloorSetting& setting, PaintedFloor floor) {
  Shot out{floor_camera(setting), std::move(floor), {}};
  out.floor.field = floor_field(setting.size);
  const FloorPicture drawn = draw_floor(out.floor, out.camera);
  out.picture.add(drawn.view);
  return out;
}

/// Four corners or crossings in view, clicked with noise of `sigma_px`, in random order or as named.
CalibrationTask clicked(const Shot& shot, FloorView view, double sigma_px, std::mt19937& random,
                        bool as_named = false) {
  CalibrationTask task;
  task.field = shot.floor.field;
  task.plus_x = view == FloorView::kHalf ? PlusX::kUp : PlusX::kRight;
  using Names = std::vector<const char*>;
  const Names names =
      view == FloorView::kWhole
          ? Names{"corner left bottom", "corner left top", "corner right top", "corner right bottom"}
      : view == FloorView::kHalf
          ? Names{"halfway line bottom", "halfway line top", "corner right top", "corner right bottom"}
          : Names{"centre", "halfway line top", "corner right top", "goal line middle right"};
  const auto points = named_points(painted_curves(task.field));
  std::normal_distribution<double> normal;
  std::vector<Eigen::Vector2d> pixels;
  for (const char* name : names) {
    const auto point =
        std::find_if(points.begin(), points.end(), [&](const NamedPoint& one) { return one.name == name; });
    const auto pixel = shot.camera.project({point->place_mm.x(), point->place_mm.y(), 0});
    pixels.push_back(*pixel + sigma_px * Eigen::Vector2d(normal(random), normal(random)));
  }
  if (!as_named) std::shuffle(pixels.begin(), pixels.end(), random);
  for (std::size_t i = 0; i < pixels.size(); ++i) task.clicks.push_back({pixels[i], names[i], {}});
  return task;
}

void give_height(CalibrationTask& task, const Shot& shot, std::mt19937& random) {
  constexpr double kSigmaMm = 10;
  task.height_sigma_mm = kSigmaMm;
  task.height_mm = shot.camera.position_mm.z() + kSigmaMm * std::normal_distribution<double>()(random);
}

struct Run {
  CalibrationReport report;
  double floor_mm, robots_mm, seconds;
};

Run run(const Shot& shot, const CalibrationTask& task) {
  const std::clock_t begin = std::clock();  // CPU time: independent of other load
  Run out{calibrate(shot.picture, task), 1e6, 1e6, 0};
  out.seconds = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
  if (out.report.found) {
    out.floor_mm = field_error_mm(shot.camera, out.report.camera, shot.floor.field, 0);
    out.robots_mm = field_error_mm(shot.camera, out.report.camera, shot.floor.field, 150);
  }
  return out;
}

bool is_right(const Run& one) {
  return one.report.found && one.floor_mm < 20;
}

bool names(const CalibrationReport& report, const char* what) {
  return std::find(report.held.begin(), report.held.end(), what) != report.held.end();
}

constexpr std::array kViews{FloorView::kWhole, FloorView::kHalf, FloorView::kQuarter};

void four_clicks(int sizes) {
  std::printf(
      "\n| four clicks, 1 and 4 px off, any order | right | z = 0, mm | z = 150, height within 10 mm | z = "
      "150, no "
      "height | height and focal length named as held | covered z = 0; 150 | seconds |\n"
      "|---|---:|---:|---:|---:|---:|---:|---:|\n");
  for (int size = 0; size < sizes; ++size) {
    Figures floor, with_height, without, seconds;
    Share right, held, covered, covered_robots;
    unsigned seed = 1;
    for (const FloorView view : kViews) {
      for (const auto& [tilt, k1] :
           {std::pair{0.0, 0.08}, {1.5, 0.0}, {1.5, 0.08}, {1.5, 0.4}, {10.0, 0.2}, {25.0, 0.08}}) {
        PaintedFloor painted;
        painted.seed = seed++;
        const Shot shot = take({size, view, tilt, k1, 0}, painted);
        std::mt19937 random(seed);
        for (const double sigma_px : {1.0, 4.0}) {
          for (const bool height : {false, true}) {
            CalibrationTask task = clicked(shot, view, sigma_px, random);
            task.click_sigma_px = sigma_px;
            if (height) give_height(task, shot, random);
            const Run one = run(shot, task);
            right.add(is_right(one));
            seconds.add(one.seconds);
            if (!is_right(one)) {
              std::fprintf(stderr,
                           "not right: %s, view %d, tilt %.1f, k1 %.2f, clicks %.0f px off, height %s: %.0f "
                           "mm off, %s\n",
                           kSizeNames[static_cast<std::size_t>(size)], static_cast<int>(view), tilt, k1,
                           sigma_px, height ? "given" : "not given", one.floor_mm,
                           one.report.accepted ? "accepted" : "not accepted");
              continue;
            }
            floor.add(one.floor_mm);
            covered.add(one.floor_mm < 2 * one.report.expected_on_floor_mm);
            covered_robots.add(one.robots_mm < 2 * one.report.expected_at_150_mm);
            if (height) {
              with_height.add(one.robots_mm);
            } else if (tilt >= 1 && k1 >= 0.05) {
              without.add(one.robots_mm);
            } else if (tilt == 0) {
              held.add(names(one.report, "height") && names(one.report, "focal length"));
            }
          }
        }
      }
    }
    std::printf("| %s | %s | %s | %s | %s | %s | %s; %s | %s |\n", kSizeNames[static_cast<std::size_t>(size)],
                right.text().c_str(), floor.text().c_str(), with_height.text().c_str(),
                without.text().c_str(), held.text().c_str(), covered.text().c_str(),
                covered_robots.text().c_str(), seconds.text(2).c_str());
    std::fflush(stdout);
  }
}

/// Accuracy by field and lens.
void conditions(int sizes) {
  struct Condition {
    const char* name;
    PaintedFloor floor;
    double k1 = 0.08, k2 = 0;
  };
  std::vector<Condition> all(9);
  all[0].name = "lines wavy by 1 mm rms";
  all[0].floor.wavy_mm = 1;
  all[1].name = "lines wavy by 2 mm rms";
  all[1].floor.wavy_mm = 2;
  all[2].name = "lens with k2 = .05";
  all[2].k1 = 0.1;
  all[2].k2 = 0.05;
  all[3].name = "noise of sigma 10";
  all[3].floor.noise_sigma = 10;
  all[4].name = "blur of 1.2 px";
  all[4].floor.blur_px = 1.2;
  all[5].name = "light falling to 40 %";
  all[5].floor.dim_to = 0.4;
  all[6].name = "16 robots, half of them on lines";
  all[6].floor.robots = 16;
  all[6].floor.robots_on_lines = true;
  all[7].name = "three lines and the circle missing";
  all[7].floor.missing = {"CenterLine", "CenterCircle", "TopTouchLine", "RightFieldLeftPenaltyStretch"};
  all[8].name = "sizes measured to the lines' outer edges";
  all[8].floor.measured = LinesMeasured::kToOuterEdge;
  std::printf(
      "\n| half a field, clicks 2 px off, height within 10 mm | picture | right | z = 0, mm | z = 150, mm | "
      "covered z = 0 |\n|---|---|---:|---:|---:|---:|\n");
  for (const Condition& condition : all) {
    for (int size = 0; size < std::min(sizes, 2); ++size) {
      Figures floor, robots;
      Share right, covered;
      for (unsigned seed = 1; seed <= 6; ++seed) {
        PaintedFloor painted = condition.floor;
        painted.seed = seed;
        const Shot shot = take({size, FloorView::kHalf, 1.5, condition.k1, condition.k2}, painted);
        std::mt19937 random(seed);
        CalibrationTask task = clicked(shot, FloorView::kHalf, 2, random);
        give_height(task, shot, random);
        const Run one = run(shot, task);
        right.add(is_right(one));
        if (!is_right(one)) continue;
        floor.add(one.floor_mm);
        robots.add(one.robots_mm);
        covered.add(one.floor_mm < 2 * one.report.expected_on_floor_mm);
      }
      std::printf("| %s | %s | %s | %s | %s | %s |\n", condition.name,
                  kSizeNames[static_cast<std::size_t>(size)], right.text().c_str(), floor.text().c_str(),
                  robots.text().c_str(), covered.text().c_str());
      std::fflush(stdout);
    }
  }
}

void no_clicks(int sizes) {
  std::printf(
      "\n| no clicks | picture | right | accepted | wrong and accepted | seconds |\n"
      "|---|---|---:|---:|---:|---:|\n");
  constexpr std::array kNames{"whole field", "half", "quarter"};
  for (std::size_t v = 0; v < kViews.size(); ++v) {
    unsigned seed = 1;
    for (int size = 0; size < sizes; ++size) {
      Share right, accepted, wrong;
      Figures seconds;
      for (const double tilt : {0.0, 1.5, 10.0, 25.0}) {
        for (const double k1 : {0.0, 0.08, 0.2, 0.4}) {
          PaintedFloor painted;
          painted.seed = seed++;
          painted.robots_on_lines = seed % 2 == 0;
          const Shot shot = take({size, kViews[v], tilt, k1, 0}, painted);
          CalibrationTask task;
          task.field = shot.floor.field;
          task.plus_x = kViews[v] == FloorView::kHalf ? PlusX::kUp : PlusX::kRight;
          const Run one = run(shot, task);
          right.add(is_right(one));
          accepted.add(one.report.accepted);
          wrong.add(one.report.accepted && !is_right(one));
          seconds.add(one.seconds);
        }
      }
      std::printf("| %s | %s | %s | %s | %s | %s |\n", kNames[v], kSizeNames[static_cast<std::size_t>(size)],
                  right.text().c_str(), accepted.text().c_str(), wrong.text().c_str(),
                  seconds.text(2).c_str());
      std::fflush(stdout);
    }
  }
  // A field whose size differs from the given one must be rejected.
  Share wrong;
  for (const double scale : {0.9, 0.95, 1.05, 1.1}) {
    const Shot shot = take({0, FloorView::kHalf, 1.5, 0.08, 0}, {});
    CalibrationTask task;
    task.field = shot.floor.field;
    task.field.field_length = static_cast<int>(scale * task.field.field_length);
    wrong.add(run(shot, task).report.accepted);
  }
  std::printf("| half, field of another length | 780x580 | | %s | %s | |\n", wrong.text().c_str(),
              wrong.text().c_str());
}

void wrong_clicks() {
  struct Outcome {
    Share flagged, named, solved, quiet, false_alarm;
    Figures seconds;
  };
  std::array<Outcome, 2> outcomes;
  for (const bool as_named : {true, false}) {
    Outcome& out = outcomes[as_named ? 0 : 1];
    for (const FloorView view : kViews) {
      for (const double tilt : {1.5, 25.0}) {
        const Shot shot = take({0, view, tilt, 0.15, 0}, {});
        std::mt19937 random(static_cast<unsigned>(tilt) + 3);
        for (std::size_t wrong = 0; wrong <= 4; ++wrong) {
          CalibrationTask task = clicked(shot, view, 2, random, as_named);
          give_height(task, shot, random);
          if (wrong < 4) {
            const double angle = std::uniform_real_distribution<double>(0, 2 * std::numbers::pi)(random);
            task.clicks[wrong].pixel +=
                200 * shot.camera.width / 1280.0 * Eigen::Vector2d(std::cos(angle), std::sin(angle));
          }
          const Run one = run(shot, task);
          out.seconds.add(one.seconds);
          const auto& clicks = one.report.click_figures;
          const bool any = std::any_of(clicks.begin(), clicks.end(),
                                       [](const ClickFigure& click) { return click.suspect; });
          if (wrong == 4) {
            out.false_alarm.add(any || !one.report.accepted);
            continue;
          }
          out.flagged.add(any || !one.report.accepted);
          out.named.add(clicks.size() == 4 && clicks[wrong].suspect);
          out.solved.add(is_right(one));
          out.quiet.add(one.report.accepted && !is_right(one));
        }
      }
    }
  }
  std::printf(
      "\n| one of four clicks 200 px of 1280 off | right names | names in random order |\n|---|---:|---:|\n");
  const auto row = [&](const char* what, auto figure) {
    std::printf("| %s | %s | %s |\n", what, figure(outcomes[0]).c_str(), figure(outcomes[1]).c_str());
  };
  row("flagged", [](const Outcome& one) { return one.flagged.text(); });
  row("the right one named", [](const Outcome& one) { return one.named.text(); });
  row("solved in spite of it", [](const Outcome& one) { return one.solved.text(); });
  row("accepted though wrong", [](const Outcome& one) { return one.quiet.text(); });
  row("false alarms without it", [](const Outcome& one) { return one.false_alarm.text(); });
  row("processor time, s", [](const Outcome& one) { return one.seconds.text(2); });
}

/// A camera with one of five lenses, tilted by up to 45 degrees in any direction, over any part of a field.
LensCamera drawn_camera(const FieldSize& field, int size, double tilt_deg, std::mt19937& random) {
  const auto between = [&](double low, double high) {
    return std::uniform_real_distribution(low, high)(random);
  };
  struct Lens {
    double focal_share, k1;
  };
  constexpr std::array kLenses{Lens{0.55, 0.25}, Lens{0.7, 0.15}, Lens{0.85, 0.08}, Lens{1.05, 0.05},
                               Lens{1.3, 0}};
  const Lens& lens = kLenses[std::uniform_int_distribution<std::size_t>(0, kLenses.size() - 1)(random)];
  LensCamera out = floor_camera({size});
  out.focal_px = lens.focal_share * out.width;
  out.k1 = lens.k1 * between(0.7, 1.3);
  const double turn = std::numbers::pi / 2 * std::uniform_int_distribution(0, 3)(random) + between(-0.3, 0.3);
  const double towards = between(0, 2 * std::numbers::pi);
  Eigen::Matrix3d down;
  down << std::cos(turn), std::sin(turn), 0, std::sin(turn), -std::cos(turn), 0, 0, 0, -1;
  const Eigen::Vector3d axis(std::cos(towards), std::sin(towards), 0);
  out.rotation = down * Eigen::AngleAxisd(tilt_deg * std::numbers::pi / 180, axis).toRotationMatrix();
  const Eigen::Vector3d aim(between(-0.3, 0.3) * field.field_length, between(-0.2, 0.2) * field.field_width,
                            0);
  const double distance_mm = between(0.5, 1.1) * field.field_length * lens.focal_share;
  out.position_mm = aim - distance_mm * out.rotation.row(2).transpose();
  return out;
}

/// The side of the image where the field's +x lies.
PlusX plus_x_of(const LensCamera& camera) {
  const Eigen::Vector2d side = camera.rotation.col(0).head<2>();
  if (std::abs(side.x()) > std::abs(side.y())) return side.x() > 0 ? PlusX::kRight : PlusX::kLeft;
  return side.y() > 0 ? PlusX::kDown : PlusX::kUp;
}

/// Three to eleven correct clicks on any points in view that are not all in one place, named or not, 1.5 px
/// off.
void any_clicks() {
  constexpr int kDraws = 1000, kBins = 5, kMaxTilt_deg = 45;
  constexpr double kMinArea = 0.04;  // twice the area of the largest triangle, as a share of the image
  std::array<Share, kBins> named, unnamed, none;
  Figures named_mm, unnamed_mm, none_mm, seconds;
  Share worse;
  std::mt19937 random(7);
  std::normal_distribution<double> click_px(0, 1.5);
  for (int drawn = 0; drawn < kDraws;) {
    const double tilt_deg = std::uniform_real_distribution<double>(0, kMaxTilt_deg)(random);
    const int size = std::bernoulli_distribution(0.3)(random) ? 1 : 0;
    Shot shot{{}, {}, {}};
    shot.floor.field = floor_field(size);
    shot.floor.seed = static_cast<unsigned>(drawn);
    shot.camera = drawn_camera(shot.floor.field, size, tilt_deg, random);
    std::vector<ClickedPoint> clicks;
    for (const NamedPoint& point : named_points(painted_curves(shot.floor.field))) {
      const auto pixel = shot.camera.project({point.place_mm.x(), point.place_mm.y(), 0});
      if (pixel && shot.camera.is_in_picture(*pixel, 3)) clicks.push_back({*pixel, point.name, {}});
    }
    const auto count = std::uniform_int_distribution<std::size_t>(3, 11)(random);
    if (clicks.size() < count) continue;
    std::shuffle(clicks.begin(), clicks.end(), random);
    clicks.resize(count);
    double area = 0;
    for (const ClickedPoint& a : clicks)
      for (const ClickedPoint& b : clicks)
        for (const ClickedPoint& c : clicks) {
          const Eigen::Vector2d ab = b.pixel - a.pixel, ac = c.pixel - a.pixel;
          area = std::max(area, ab.x() * ac.y() - ab.y() * ac.x());
        }
    if (area < kMinArea * shot.camera.width * shot.camera.height) continue;
    ++drawn;
    const FloorPicture picture = draw_floor(shot.floor, shot.camera);
    shot.picture.add(picture.view);
    CalibrationTask task;
    task.field = shot.floor.field;
    task.plus_x = plus_x_of(shot.camera);
    const Run without = run(shot, task);
    const bool is_named = std::bernoulli_distribution(0.5)(random);
    for (ClickedPoint& click : clicks) {
      click.pixel += Eigen::Vector2d(click_px(random), click_px(random));
      if (!is_named) click.name.clear();
    }
    task.clicks = clicks;
    const Run with = run(shot, task);
    const auto good = [](const Run& one) { return one.report.accepted && is_right(one); };
    const auto bin =
        std::min<std::size_t>(kBins - 1, static_cast<std::size_t>(tilt_deg * kBins / kMaxTilt_deg));
    (is_named ? named : unnamed)[bin].add(good(with));
    none[bin].add(good(without));
    if (good(with)) (is_named ? named_mm : unnamed_mm).add(with.floor_mm);
    if (good(without)) none_mm.add(without.floor_mm);
    worse.add(good(without) && !(good(with) && with.floor_mm < without.floor_mm + 0.5));
    seconds.add(with.seconds);
  }
  std::printf(
      "\n| 3 to 11 clicks, right and accepted | named | not named | no clicks |\n|---|---:|---:|---:|\n");
  for (int i = 0; i < kBins; ++i) {
    const auto bin = static_cast<std::size_t>(i);
    std::printf("| tilted by %d to %d degrees | %s | %s | %s |\n", i * kMaxTilt_deg / kBins,
                (i + 1) * kMaxTilt_deg / kBins, named[bin].text().c_str(), unnamed[bin].text().c_str(),
                none[bin].text().c_str());
  }
  std::printf(
      "| z = 0 | %s | %s | %s |\n\nWorse than without clicks by .5 mm or more: %s. Processor time: %s s.\n",
      named_mm.text().c_str(), unnamed_mm.text().c_str(), none_mm.text().c_str(), worse.text().c_str(),
      seconds.text(2).c_str());
}

/// Two cameras over the halves of a field whose lines are displaced, calibrated separately and jointly.
void overlap() {
  std::printf(
      "\n| overlap of two cameras, 780x580, height within 10 mm | z = 0 apart, mm | together | z = 150 apart "
      "| "
      "together | together with 30 robots: z = 0 | z = 150 |\n|---|---:|---:|---:|---:|---:|---:|\n");
  for (const double off_mm : {1.0, 2.0}) {
    for (const bool wavy : {false, true}) {
      std::array<Figures, 6> figures;
      for (unsigned seed = 1; seed <= 5; ++seed) {
        PaintedFloor floor;
        floor.seed = seed;
        (wavy ? floor.wavy_mm : floor.shifted_mm) = off_mm;
        floor.field = floor_field(0);
        LensCamera a = floor_camera({}), b = turned_round(a);
        b.center_x += 4;
        const auto curves = painted_curves(floor.field);
        std::mt19937 random(seed);
        std::normal_distribution<double> normal;
        std::vector<RefinedCamera> seen;
        for (const LensCamera& camera : {a, b}) {
          MeanPicture picture;
          picture.add(draw_floor(floor, camera).view);
          CameraPrior prior = camera_prior(camera.width, camera.height);
          prior.height_mm = camera.position_mm.z() + 10 * normal(random);
          prior.height_sigma_mm = 10;
          auto refined = refine_camera(find_line_pixels(picture, 1.5), camera, curves, prior, {20, false});
          if (refined) seen.push_back(*refined);
        }
        if (seen.size() < 2) continue;
        std::vector<OverlapTie> ties;
        for (int i = 0; i < 30; ++i) {
          const Eigen::Vector3d place(std::uniform_real_distribution<double>(-300, 300)(random),
                                      std::uniform_real_distribution<double>(-1900, 1900)(random), 140);
          const auto p = a.project(place), q = b.project(place);
          if (!p || !q || !a.is_in_picture(*p) || !b.is_in_picture(*q)) continue;
          const auto miss = [&] { return Eigen::Vector2d(0.1 * normal(random), 0.1 * normal(random)); };
          ties.push_back({0, 1, *p + miss(), *q + miss(), 140, 0.1});
        }
        const auto add = [&](std::size_t i, const LensCamera& one, const LensCamera& other,
                             double height_mm) {
          figures[i].add(overlap_error_mm(a, b, one, other, floor.field, height_mm));
        };
        const JointCalibration lines = refine_jointly(seen, curves, {}),
                               robots = refine_jointly(seen, curves, ties);
        add(0, seen[0].camera, seen[1].camera, 0);
        add(1, lines.cameras[0], lines.cameras[1], 0);
        add(2, seen[0].camera, seen[1].camera, 150);
        add(3, lines.cameras[0], lines.cameras[1], 150);
        add(4, robots.cameras[0], robots.cameras[1], 0);
        add(5, robots.cameras[0], robots.cameras[1], 150);
      }
      std::printf("| lines %s by %.0f mm", wavy ? "wavy" : "shifted", off_mm);
      for (const Figures& one : figures) std::printf(" | %s", one.text(2).c_str());
      std::printf(" |\n");
      std::fflush(stdout);
    }
  }
}

}  // namespace
}  // namespace sslv

int main(int argc, char** argv) {
  const int sizes = argc > 1 ? std::clamp(std::atoi(argv[1]), 1, 3) : 3;
  const auto wants = [&](std::string_view table) { return argc < 3 || argv[2] == table; };
  if (wants("four-clicks")) sslv::four_clicks(sizes);
  if (wants("conditions")) sslv::conditions(sizes);
  if (wants("no-clicks")) sslv::no_clicks(sizes);
  if (wants("wrong-clicks")) sslv::wrong_clicks();
  if (wants("any-clicks")) sslv::any_clicks();
  if (wants("overlap")) sslv::overlap();
}
