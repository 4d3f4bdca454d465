// SPDX-License-Identifier: Apache-2.0
#include "vision/detect_robots.h"

#include "geometry/limits.h"
#include "vision/cut_off.h"
#include "vision/miss_text.h"

#include <algorithm>
#include <bitset>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <span>
#include <utility>

#include <fmt/format.h>

namespace sslv {
namespace {

/// In start poses, a region further than this from a side dot's place does not belong to the dot.
constexpr double kNearMm = 16;
/// If all side dots are this near to their places, the search for a better arrangement ends.
constexpr double kSureMm = 2;
/// Maximum number of regions around one centre that are tried as side dots; more regions are clutter.
constexpr std::size_t kMaxNear = 24;
/// Least PatternDotFit::margin of a proven colour.
constexpr double kMinMargin = 0.05;
/// Largest distance of a dot's colour from the table's colour, in spreads. With a larger distance, the object
/// is not a dot but, for example, a sticker or a hand. The limit for the centre dot is larger, because the
/// team colours are further apart than the colours of side dots may be, and because yellow turns to orange in
/// dim light.
constexpr double kMaxOff = 1.6, kMaxCenterOff = 2.5;
constexpr int kFewPasses = 4, kManyPasses = 6;
constexpr double kDuplicateShare = 0.25;
/// Largest differences in position and heading between a remembered robot and the same robot now.
constexpr double kSamePlaceMm = 60, kSameHeadingRad = 0.5;

/// Misses of an image that are remembered until all robots are known, which many of them turn out to be.
constexpr std::size_t kMaxKeptMisses = 4 * limits::kMaxMisses;

using Ids = std::bitset<256>;

/// std::hypot without its protection against overflow, which takes longer than the rest of the function.
double distance(double dx, double dy) {
  return std::sqrt(dx * dx + dy * dy);
}

double disc_area_mm2(double diameter_mm) {
  return std::numbers::pi * diameter_mm * diameter_mm / 4;
}

/// Area of the region on the plane z = `height_mm`, as a share of a dot's.
double area_ratio(const Region& region, const PatternFitter::Frame& frame, double height_mm,
                  double dot_area_mm2) {
  return region.area_px * frame.camera.mm2_per_px({region.x_px, region.y_px}, height_mm) / dot_area_mm2;
}

bool has_size_of_dot(double ratio, const DetectRobots::Params& params) {
  return ratio >= params.min_area_ratio && ratio <= params.max_area_ratio;
}

/// Position of the region on the plane z = `height_mm`; nullopt if the mask cuts the region.
std::optional<Eigen::Vector2d> place_of(const Region& region, const PatternFitter::Frame& frame,
                                        const Mask& mask, double height_mm) {
  if (is_cut_off(region, frame.image, mask)) return std::nullopt;
  return frame.camera.unproject({region.x_px, region.y_px}, height_mm);
}

bool is_nearer(const RobotMiss& a, const RobotMiss& b) {
  return a.why != b.why ? a.why > b.why : a.dots > b.dots;
}

}  // namespace

void DetectRobots::process(const Params& params, const Scene& scene, const PatternTable& patterns,
                           const Lut& lut, const Mask& mask, const FrameInfo& info, const Image& image,
                           const RegionList& regions, RobotList& out, StageNotes& notes) noexcept {
  out.robots.clear();
  out.second_robots.clear();
  out.misses.clear();
  candidates_.clear();
  misses_.clear();
  misses_.reserve(kMaxKeptMisses);
  out.misses.reserve(limits::kMaxMisses);
  centers_ = {};
  explained_.assign(regions.regions.size(), 0);
  fitter_.reset_work();
  work_ = 0;
  if (!scene.camera || image.view().empty()) return stop_telling(notes);
  const Frame frame{image.view(), *scene.camera, patterns, lut, params.blur_px};
  const double now_s = info.times.t_capture_s;
  memory_.forget(now_s, params.memory_ms * 1e-3);
  rows_ = RowTimes(params.rolling_shutter_ms * 1e-3, info.whole, image.view().height);
  expected_.clear();
  for (const RobotMemory::Entry& entry : memory_.entries())
    expected_.push_back(expected_in_picture(frame, scene, entry, now_s));

  double dots_height_mm = std::numeric_limits<double>::quiet_NaN();
  for (const Team team : {Team::kYellow, Team::kBlue}) {
    const double height_mm = scene.height_of(team);
    const bool same_dots = height_mm == dots_height_mm;
    if (!same_dots) collect_dots(params, frame, height_mm, mask, regions);
    dots_height_mm = height_mm;
    search_from_centers(params, frame, team, height_mm, mask, regions);
  }
  search_from_memory(params, frame, scene, mask);
  // Searches for robots whose centre dot has no region, from the remaining side dots. This is the last
  // search, because a board beside the carpet may have enough regions of these colours to use up the work
  // limit.
  for (const Team team : {Team::kYellow, Team::kBlue}) {
    const double height_mm = scene.height_of(team);
    if (team == Team::kBlue && height_mm == scene.height_of(Team::kYellow)) break;
    if (height_mm != dots_height_mm) collect_dots(params, frame, height_mm, mask, regions);
    dots_height_mm = height_mm;
    search_from_side_dots(params, frame, height_mm);
  }
  choose(params, frame, scene, out);
  out.capped = !time_left(params);
  report(params, now_s, out, notes);
  if (params.memory_ms == 0) return;
  memory_.remember(out, now_s, rows_);
  if (rows_.rolls()) memory_.move_to_frame(out);
}

DetectRobots::Expected DetectRobots::expected_in_picture(const Frame& frame, const Scene& scene,
                                                         const RobotMemory::Entry& entry,
                                                         double now_s) const {
  Expected out{entry.at(now_s), Eigen::Vector2d::Zero()};
  if (!rows_.rolls()) return out;
  const auto pixel = frame.camera.project({out.pose.x_mm, out.pose.y_mm, scene.height_of(entry.team)});
  if (pixel) out.pose = entry.at(now_s + rows_.delay_s(pixel->y()));
  out.mm_per_row = Eigen::Vector2d(entry.x_mm_s, entry.y_mm_s) * rows_.s_per_row();
  return out;
}

Eigen::Vector2d DetectRobots::mm_per_row_at(const PatternPose& pose) const {
  double min_mm = kSamePlaceMm;
  Eigen::Vector2d out = Eigen::Vector2d::Zero();
  if (!rows_.rolls()) return out;
  for (const Expected& expected : expected_) {
    const double away_mm = distance(expected.pose.x_mm - pose.x_mm, expected.pose.y_mm - pose.y_mm);
    if (away_mm >= min_mm) continue;
    min_mm = away_mm;
    out = expected.mm_per_row;
  }
  return out;
}

void DetectRobots::collect_dots(const Params& params, const Frame& frame, double height_mm, const Mask& mask,
                                const RegionList& regions) {
  dots_.clear();
  // Uses the mean area for dots of all sizes; the limits of the area ratio are wide enough.
  double area_mm2 = 0;
  for (const PatternDot& dot : frame.patterns.dots)
    area_mm2 += disc_area_mm2(dot.diameter_mm) / static_cast<double>(frame.patterns.dots.size());
  for (const Label label : frame.patterns.side_colors) {
    for (const Region& region : regions.of(label)) {
      if (!has_size_of_dot(area_ratio(region, frame, height_mm, area_mm2), params)) continue;
      const auto place = place_of(region, frame, mask, height_mm);
      if (place)
        dots_.push_back({place->x(), place->y(), static_cast<std::size_t>(&region - regions.regions.data())});
    }
  }
  std::sort(dots_.begin(), dots_.end(), [](const Dot& a, const Dot& b) { return a.x_mm < b.x_mm; });
}

std::vector<DetectRobots::Dot>::iterator DetectRobots::first_dot_right_of(double x_mm) {
  return std::lower_bound(dots_.begin(), dots_.end(), x_mm,
                          [](const Dot& dot, double x) { return dot.x_mm < x; });
}

/// Marks the side dots of a robot that was found, so that no other robot is searched from these dots.
void DetectRobots::explain_dots(const PatternTable& patterns, const Candidate& found) {
  const double c = std::cos(found.fit.pose.angle_rad), s = std::sin(found.fit.pose.angle_rad);
  for (std::size_t i = 0; i < patterns.dots.size(); ++i) {
    const PatternDot& dot = patterns.dots[i];
    const double x_mm = found.fit.pose.x_mm + c * dot.x_mm - s * dot.y_mm;
    const double y_mm = found.fit.pose.y_mm + s * dot.x_mm + c * dot.y_mm;
    const double within_mm = dot.diameter_mm / 2;
    for (auto near = first_dot_right_of(x_mm - within_mm);
         near != dots_.end() && near->x_mm < x_mm + within_mm; ++near) {
      if (distance(near->x_mm - x_mm, near->y_mm - y_mm) < within_mm) explained_[near->region] = 1;
    }
  }
}

/// Finds the rotation of the pattern about a centre dot for which the largest number of side dots lie on
/// regions, and the pose that fits these regions and the centre best.
DetectRobots::Start DetectRobots::arrange(const PatternTable& patterns, double x_mm, double y_mm) {
  using Point = std::complex<double>;
  std::array<Point, kMaxNear> near;  // positions relative to the centre dot
  std::size_t count = 0;
  const double reach_mm = patterns.arm_mm + kNearMm;
  for (auto dot = first_dot_right_of(x_mm - reach_mm);
       dot != dots_.end() && dot->x_mm < x_mm + reach_mm && count < kMaxNear; ++dot) {
    const Point at(dot->x_mm - x_mm, dot->y_mm - y_mm);
    if (std::norm(at) < reach_mm * reach_mm) near[count++] = at;
  }
  const auto tried = static_cast<double>(count * patterns.dots.size());
  work_ += 0.1 + tried * tried / 500;
  const std::size_t sides = patterns.dots.size();
  std::array<Point, PatternTable::kMaxDots> place_of_dot;
  std::array<double, PatternTable::kMaxDots> length_of_dot;
  for (std::size_t i = 0; i < sides; ++i) {
    place_of_dot[i] = {patterns.dots[i].x_mm - patterns.center_x_mm,
                       patterns.dots[i].y_mm - patterns.center_y_mm};
    length_of_dot[i] = std::sqrt(std::norm(place_of_dot[i]));
  }
  int most = 0;
  double min_error = 0;
  Point turn_dots(0, 0), shift(0, 0);  // rotation and shift of the best arrangement
  double matched_weight = 1;
  const auto is_sure = [&] {
    return most == static_cast<int>(sides) && min_error < most * kSureMm * kSureMm;
  };
  for (std::size_t i = 0; i < count && !is_sure(); ++i) {
    const double length = std::sqrt(std::norm(near[i]));
    for (std::size_t dot = 0; dot < sides && !is_sure(); ++dot) {
      if (std::abs(length - length_of_dot[dot]) > kNearMm || length == 0) continue;
      const Point turn = near[i] * std::conj(place_of_dot[dot]) / (length_of_dot[dot] * length);
      int matched = 0;
      double error = 0;
      Point sum_turn(0, 0), sum_seen(0, 0), sum_model(0, 0);
      for (std::size_t other = 0; other < sides; ++other) {
        const Point place = turn * place_of_dot[other];
        double nearest = kNearMm * kNearMm;
        const Point* seen = nullptr;
        for (std::size_t k = 0; k < count; ++k) {
          const double distance = std::norm(near[k] - place);
          if (distance < nearest) {
            nearest = distance;
            seen = &near[k];
          }
        }
        if (seen == nullptr) continue;
        ++matched;
        error += nearest;
        sum_turn += *seen * std::conj(place_of_dot[other]);
        sum_seen += *seen;
        sum_model += place_of_dot[other];
      }
      if (matched > most || (matched == most && error < min_error)) {
        most = matched;
        min_error = error;
        // Least squares with the centre dot as an additional point, which is at 0 in both point sets (Umeyama
        // 1991, without scale).
        matched_weight = 1.0 / (matched + 1);
        turn_dots = sum_turn - sum_seen * std::conj(sum_model) * matched_weight;
        turn_dots = std::abs(turn_dots) > 0 ? turn_dots / std::abs(turn_dots) : turn;
        shift = (sum_seen - turn_dots * sum_model) * matched_weight;
      }
    }
  }
  if (most == 0) return {{x_mm, y_mm, 0}, 0};
  return {patterns.with_center_at(x_mm + shift.real(), y_mm + shift.imag(), std::arg(turn_dots)), most};
}

void DetectRobots::search_from_centers(const Params& params, const Frame& frame, Team team, double height_mm,
                                       const Mask& mask, const RegionList& regions) {
  const Label color = frame.patterns.team_colors[static_cast<std::size_t>(team)];
  const double area_mm2 = disc_area_mm2(frame.patterns.center_diameter_mm);
  Centers& centers = centers_[static_cast<std::size_t>(team)];
  const auto misfit = [](double ratio) { return std::max(ratio, 1 / ratio); };
  const auto search = [&](Label label) {
    for (const Region& region : regions.of(label)) {
      const double ratio = area_ratio(region, frame, height_mm, area_mm2);
      const bool has_size = has_size_of_dot(ratio, params);
      if (label == color) {
        ++(has_size ? centers.count : centers.other);
        if (!has_size && misfit(ratio) < misfit(centers.nearest)) centers.nearest = ratio;
      }
      if (!has_size) continue;
      const auto place = place_of(region, frame, mask, height_mm);
      if (!place) continue;
      if (!time_left(params)) return;
      // A wooden floor may have many regions that look like centre dots. Regions without side dots beside
      // them may use only a part of the work limit; the rest is kept for robots, wherever they are in the
      // list.
      constexpr double kShareOfBlobsAlone = 0.5;
      constexpr int kFewDots = 2;
      const int min_matched = work_done() < kShareOfBlobsAlone * params.max_work ? 0 : kFewDots;
      search_around(params, frame, place->x(), place->y(), height_mm, min_matched);
    }
  };
  search(color);
  // Yellow is labelled orange in dim light and if a channel is clipped. Balls are orange, too, but a ball is
  // not a disc on black. Side dots may have no regions: in the shade, green dots are as dark as carpet.
  if (color == label::kYellow) search(label::kOrange);
}

void DetectRobots::search_around(const Params& params, const Frame& frame, double x_mm, double y_mm,
                                 double height_mm, int min_matched) {
  const int all = static_cast<int>(frame.patterns.dots.size()) + 1;
  const Start start = arrange(frame.patterns, x_mm, y_mm);
  if (start.matched < min_matched) return;
  Candidate best{};
  if (start.matched + 1 == all) {
    best = examine(params, frame, start.pose, height_mm, kFewPasses);
    if (best.proven_dots == all) return keep(params, frame, best);
  }
  // The regions alone do not prove a robot, so the search continues in the image.
  const auto center = fitter_.fit_center(frame, x_mm, y_mm, height_mm);
  if (!center.seen) return;
  const auto try_start = [&](const PatternPose& pose) {
    const Candidate candidate = examine(params, frame, pose, height_mm, kManyPasses);
    if (best.fit.seen == 0 || candidate.proven_dots > best.proven_dots ||
        (candidate.proven_dots == best.proven_dots && candidate.confidence > best.confidence)) {
      best = candidate;
    }
    return best.proven_dots == all;
  };
  if (start.matched >= 2 && start.matched + 1 < all &&
      try_start(frame.patterns.with_center_at(center.x_mm, center.y_mm, start.pose.angle_rad)))
    return keep(params, frame, best);
  std::array<double, PatternFitter::kMaxHeadings> headings;
  const std::size_t count = fitter_.find_headings(frame, center.x_mm, center.y_mm, height_mm, headings);
  for (std::size_t i = 0; i < count; ++i) {
    if (try_start(frame.patterns.with_center_at(center.x_mm, center.y_mm, headings[i]))) break;
  }
  keep(params, frame, best);
}

void DetectRobots::search_from_side_dots(const Params& params, const Frame& frame, double height_mm) {
  const PatternTable& patterns = frame.patterns;
  const double reach_mm = 2 * patterns.reach_mm;
  constexpr std::size_t kMaxTries = 8;  // tries per dot
  constexpr double kWorkOfAPair = 0.05;
  for (std::size_t i = 0; i < dots_.size(); ++i) {
    std::size_t tries = 0;
    for (std::size_t k = i + 1; k < dots_.size() && dots_[k].x_mm < dots_[i].x_mm + reach_mm; ++k) {
      if (!time_left(params)) return;
      if (explained_[dots_[i].region] != 0 || tries >= kMaxTries) break;
      if (explained_[dots_[k].region] != 0) continue;
      work_ += kWorkOfAPair;
      const double dx = dots_[k].x_mm - dots_[i].x_mm, dy = dots_[k].y_mm - dots_[i].y_mm;
      const double apart_mm = distance(dx, dy);
      if (apart_mm > reach_mm) continue;
      const auto try_as = [&](const PatternDot& a, const PatternDot& b) {
        const double mx = b.x_mm - a.x_mm, my = b.y_mm - a.y_mm;
        if (std::abs(distance(mx, my) - apart_mm) > 0.5 * kNearMm) return;
        // Rotation that maps the two pattern dots to the two regions.
        const double length2 = apart_mm * distance(mx, my);
        const double c = (dx * mx + dy * my) / length2, s = (dy * mx - dx * my) / length2;
        const double ahead_mm = patterns.center_x_mm - a.x_mm, left_mm = patterns.center_y_mm - a.y_mm;
        const Start start = arrange(patterns, dots_[i].x_mm + c * ahead_mm - s * left_mm,
                                    dots_[i].y_mm + s * ahead_mm + c * left_mm);
        if (start.matched < 3) return;
        ++tries;
        keep(params, frame, examine(params, frame, start.pose, height_mm, kManyPasses));
      };
      for (std::size_t a = 0; a < patterns.dots.size(); ++a) {
        for (std::size_t b = 0; b < patterns.dots.size(); ++b) {
          if (a != b && explained_[dots_[i].region] == 0) try_as(patterns.dots[a], patterns.dots[b]);
        }
      }
    }
  }
}

void DetectRobots::search_from_memory(const Params& params, const Frame& frame, const Scene& scene,
                                      const Mask& mask) {
  for (std::size_t i = 0; i < expected_.size(); ++i) {
    if (!time_left(params)) return;
    const RobotMemory::Entry& entry = memory_.entries()[i];
    const PatternPose expected = expected_[i].pose;
    const bool found = std::any_of(candidates_.begin(), candidates_.end(), [&](const Candidate& candidate) {
      return distance(candidate.fit.pose.x_mm - expected.x_mm, candidate.fit.pose.y_mm - expected.y_mm) <
             kSamePlaceMm;
    });
    if (found) continue;
    const double height_mm = scene.height_of(entry.team);
    const auto pixel = frame.camera.project({expected.x_mm, expected.y_mm, height_mm});
    if (!pixel || !mask.shows(pixel->x(), pixel->y())) continue;
    Candidate candidate = examine(params, frame, expected, height_mm, kManyPasses);
    if (candidate.proven_dots < static_cast<int>(frame.patterns.dots.size())) {
      const auto [x_mm, y_mm] = frame.patterns.center_of(expected);
      const auto center = fitter_.fit_center(frame, x_mm, y_mm, height_mm);
      if (center.seen) {
        search_around(params, frame, center.x_mm, center.y_mm, height_mm, 0);
        continue;
      }
    }
    keep(params, frame, candidate);
  }
}

DetectRobots::Candidate DetectRobots::examine(const Params& params, const Frame& frame,
                                              const PatternPose& start, double height_mm, int max_passes) {
  Candidate out{};
  out.fit = fitter_.fit(frame, start, height_mm, max_passes, mm_per_row_at(start));
  out.height_mm = height_mm;
  if (out.fit.seen == 0 || out.fit.rms_mm > params.max_rms_mm) return out;
  const auto is_proven = [](const PatternDotFit& dot, double max_off) {
    return dot.seen && dot.margin > kMinMargin && dot.off < max_off;
  };
  RobotEvidence evidence;
  evidence.min_sure = std::numeric_limits<double>::infinity();
  const auto count = [&](const PatternDotFit& dot) {
    evidence.min_sure = std::min(evidence.min_sure, dot.margin * dot.snr);
    ++out.proven_dots;
  };
  const PatternDotFit& center = out.fit.dots[PatternFit::kCenter];
  if (is_proven(center, kMaxCenterOff)) {
    out.team = center.color == frame.patterns.team_colors[0] ? Team::kYellow : Team::kBlue;
    count(center);
  }
  for (std::size_t i = 0; i < frame.patterns.dots.size(); ++i) {
    out.proven[i] = is_proven(out.fit.dots[i], kMaxOff);
    if (out.proven[i]) count(out.fit.dots[i]);
  }
  evidence.rms_mm = out.fit.rms_mm;
  evidence.min_r2 = out.fit.min_r2;
  evidence.mean_r2 = out.fit.mean_r2;
  evidence.unproven = static_cast<int>(frame.patterns.dots.size()) + 1 - out.proven_dots;
  out.confidence = confidence_of(evidence);
  return out;
}

/// Adds the candidate to candidates_. Drops it if more than one of its dots is unproven, because then it
/// cannot become a robot.
void DetectRobots::keep(const Params& params, const Frame& frame, const Candidate& candidate) {
  using enum RobotMiss::Why;
  const int all = static_cast<int>(frame.patterns.dots.size()) + 1;
  if (candidate.proven_dots + 1 < all || candidate.proven_dots < 3) {
    if (candidate.fit.seen + 1 < all) return miss(frame, candidate, kDots);
    if (candidate.fit.rms_mm > params.max_rms_mm)
      return miss(frame, candidate, kFit, candidate.fit.rms_mm, params.max_rms_mm);
    return miss(frame, candidate, kColors);
  }
  candidates_.push_back(candidate);
  if (candidate.proven_dots == all) explain_dots(frame.patterns, candidate);
}

/// Remembers the nearest miss at each place. Robots that the image's edge cuts are no misses.
void DetectRobots::miss(const Frame& frame, const Candidate& candidate, RobotMiss::Why why, double value,
                        double limit) {
  const PatternFit& fit = candidate.fit;
  if (fit.seen == 0) return;
  RobotMiss miss{why,         fit.pixel_x,
                 fit.pixel_y, frame.patterns.reach_mm * fit.px_per_mm,
                 fit.seen,    static_cast<int>(frame.patterns.dots.size()) + 1,
                 value,       limit};
  if (why == RobotMiss::Why::kColors) miss.dots = candidate.proven_dots;
  const double r = miss.radius_px;
  if (miss.pixel_x < r || miss.pixel_x + r > frame.image.width || miss.pixel_y < r ||
      miss.pixel_y + r > frame.image.height)
    return;
  const auto same = std::find_if(misses_.begin(), misses_.end(), [&](const RobotMiss& other) {
    return distance(other.pixel_x - miss.pixel_x, other.pixel_y - miss.pixel_y) < r;
  });
  if (same == misses_.end() && misses_.size() < kMaxKeptMisses) return misses_.push_back(miss);
  RobotMiss& worst =
      same != misses_.end() ? *same : *std::max_element(misses_.begin(), misses_.end(), is_nearer);
  if (is_nearer(miss, worst)) worst = miss;
}

/// Reports why there are no robots, or no more.
void DetectRobots::report(const Params& params, double now_s, RobotList& out, StageNotes& notes) {
  std::sort(misses_.begin(), misses_.end(), is_nearer);
  for (const RobotMiss& miss : misses_) {
    const bool is_robot = std::any_of(chosen_.begin(), chosen_.end(), [&](const Candidate* robot) {
      return distance(robot->fit.pixel_x - miss.pixel_x, robot->fit.pixel_y - miss.pixel_y) <
             2 * miss.radius_px;
    });
    if (!is_robot && out.misses.size() < limits::kMaxMisses) out.misses.push_back(miss);
  }
  // Notes change at most once per second, so that they can be read.
  constexpr double kInterval_s = 1;
  if (is_telling_ && std::abs(now_s - told_s_) < kInterval_s) return;
  const bool has_blobs = centers_[0].count + centers_[0].other + centers_[1].count + centers_[1].other > 0;
  if (out.misses.empty() && (!out.robots.empty() || !has_blobs)) return stop_telling(notes);
  is_telling_ = true;
  told_s_ = now_s;

  std::array<char, StageNotes::kMaxText> text;
  std::size_t length = 0;
  const auto add = [&]<class... Args>(fmt::format_string<Args...> format, Args&&... args) {
    const std::size_t left = text.size() - length;
    const auto end = fmt::format_to_n(text.data() + length, left, format, std::forward<Args>(args)...);
    length += std::min(left, end.size);
  };
  if (out.misses.empty()) {
    add("nothing resembles a robot");
  } else {
    const RobotMiss& nearest = out.misses.front();
    add("{}{} a robot, {}at pixel {:.0f}, {:.0f}: ", out.misses.size(),
        out.misses.size() == 1                    ? " thing resembles"
        : out.misses.size() == limits::kMaxMisses ? " or more things resemble"
                                                  : " things resemble",
        out.misses.size() == 1 ? "" : "the closest ", nearest.pixel_x, nearest.pixel_y);
    length += miss_text(nearest, std::span(text).subspan(length));
  }
  if (out.robots.empty()) {
    for (const Team team : {Team::kYellow, Team::kBlue}) {
      const Centers& centers = centers_[static_cast<std::size_t>(team)];
      if (centers.count > 0) {
        add("; {} blobs as large as a centre dot: {}", name_of(team), centers.count);
      } else if (centers.other > 0) {
        add("; of {} {} blobs, the closest in size has {:.0f} % of a centre dot's area, allowed {:.0f} to "
            "{:.0f}",
            centers.other, name_of(team), 100 * centers.nearest, 100 * params.min_area_ratio,
            100 * params.max_area_ratio);
      }
    }
  }
  notes.say({text.data(), length});
}

void DetectRobots::stop_telling(StageNotes& notes) {
  if (std::exchange(is_telling_, false)) notes.clear();
}

void DetectRobots::choose(const Params& params, const Frame& frame, const Scene& scene, RobotList& out) {
  const PatternTable& patterns = frame.patterns;
  const std::size_t sides = patterns.dots.size();
  order_.clear();
  chosen_.clear();
  for (const Candidate& candidate : candidates_) order_.push_back(&candidate);
  std::sort(order_.begin(), order_.end(), [](const Candidate* a, const Candidate* b) {
    return a->proven_dots != b->proven_dots ? a->proven_dots > b->proven_dots : a->confidence > b->confidence;
  });
  // Two robots never share a dot.
  const auto share_a_dot = [&](const Candidate& a, const Candidate& b) {
    const double reach_px = 2 * patterns.reach_mm * a.fit.px_per_mm;
    if (distance(a.fit.pixel_x - b.fit.pixel_x, a.fit.pixel_y - b.fit.pixel_y) > 1.2 * reach_px) return false;
    const double within_px = 0.5 * patterns.center_diameter_mm * a.fit.px_per_mm;
    const auto dot_at = [&](std::size_t i) { return i == sides ? PatternFit::kCenter : i; };
    for (std::size_t i = 0; i <= sides; ++i) {
      for (std::size_t k = 0; k <= sides; ++k) {
        const PatternDotFit &one = a.fit.dots[dot_at(i)], &other = b.fit.dots[dot_at(k)];
        if (one.seen && other.seen &&
            distance(one.pixel_x - other.pixel_x, one.pixel_y - other.pixel_y) < within_px)
          return true;
      }
    }
    return false;
  };
  std::array<Ids, 2> taken;
  for (const Candidate* candidate : order_) {
    const bool shares = std::any_of(chosen_.begin(), chosen_.end(),
                                    [&](const Candidate* other) { return share_a_dot(*candidate, *other); });
    if (shares) continue;
    const auto remembered = std::find_if(
        memory_.entries().begin(), memory_.entries().end(), [&](const RobotMemory::Entry& entry) {
          const PatternPose& expected =
              expected_[static_cast<std::size_t>(&entry - memory_.entries().data())].pose;
          const PatternPose& pose = candidate->fit.pose;
          return (!candidate->team || *candidate->team == entry.team) &&
                 distance(expected.x_mm - pose.x_mm, expected.y_mm - pose.y_mm) < kSamePlaceMm &&
                 std::abs(std::remainder(expected.angle_rad - pose.angle_rad, 2 * std::numbers::pi)) <
                     kSameHeadingRad;
        });
    const bool is_remembered = remembered != memory_.entries().end();
    if (!candidate->team && !is_remembered) {
      miss(frame, *candidate, RobotMiss::Why::kTeam);
      continue;
    }
    const Team team = candidate->team ? *candidate->team : remembered->team;
    const auto team_index = static_cast<std::size_t>(team);

    Ids possible;
    for (const PatternTable::Code& code : patterns.codes) {
      bool fits = true;
      for (std::size_t i = 0; i < sides; ++i)
        fits = fits && (!candidate->proven[i] || candidate->fit.dots[i].color == code.colors[i]);
      if (fits) possible.set(static_cast<std::size_t>(code.id));
    }
    if (possible.count() > 1) {
      possible &= ~taken[team_index];
      if (scene.roster[team_index].any()) possible &= scene.roster[team_index];
      if (possible.count() > 1 && is_remembered) {
        Ids last;
        last.set(remembered->id);
        possible &= last;
      }
    }
    if (possible.count() != 1) {
      miss(frame, *candidate, RobotMiss::Why::kId, static_cast<double>(possible.count()));
      continue;
    }
    // A candidate on the plane of the other team's height has a wrong position.
    if (candidate->height_mm != scene.height_of(team)) continue;
    const auto id = static_cast<int>(possible._Find_first());
    const PatternFit& fit = candidate->fit;
    Robot robot{team,
                id,
                fit.pose.x_mm,
                fit.pose.y_mm,
                fit.pose.angle_rad,
                candidate->height_mm,
                fit.pixel_x,
                fit.pixel_y,
                candidate->confidence};
    if (taken[team_index].test(static_cast<std::size_t>(id))) {
      if (params.duplicates == Duplicates::kDrop) {
        // A robot with an unproven dot may have another id.
        const bool is_proven = candidate->proven_dots == static_cast<int>(sides) + 1;
        if (is_proven && robot.confidence >= params.min_confidence) out.second_robots.push_back(robot);
        continue;
      }
      robot.confidence *= kDuplicateShare;
    } else if (robot.confidence < params.min_confidence) {
      miss(frame, *candidate, RobotMiss::Why::kConfidence, robot.confidence, params.min_confidence);
      continue;
    }
    taken[team_index].set(static_cast<std::size_t>(id));
    chosen_.push_back(candidate);
    out.robots.push_back(robot);
  }
  std::sort(out.robots.begin(), out.robots.end(),
            [](const Robot& a, const Robot& b) { return a.confidence > b.confidence; });
}

}  // namespace sslv
