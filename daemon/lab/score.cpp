// SPDX-License-Identifier: Apache-2.0
#include "lab/score.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <istream>
#include <map>
#include <numbers>
#include <stdexcept>

#include <fmt/format.h>

namespace sslv {
namespace {

constexpr double kMatchMm = 100;

/// A robot or ball from either file; balls have neither team nor id nor orientation.
struct Thing {
  std::string team;
  int id = 0;
  double x_mm = 0, y_mm = 0, orientation_rad = 0;
  double visible_share = 1;  // in the truth only
};
struct FrameThings {
  std::vector<Thing> robots, balls;
  bool checked = true;  // in the truth only
};
using Frames = std::map<std::string, FrameThings>;

double visible_share_of(const Json& thing) {
  return thing.value("visible_share", thing.value("visible", true) ? 1.0 : 0.0);
}

FrameThings things_of(const Json& line) {
  FrameThings out;
  for (const Json& robot : line.at("robots")) {
    out.robots.push_back({robot.at("team"), robot.at("id"), robot.at("x"), robot.at("y"),
                          robot.at("orientation"), visible_share_of(robot)});
  }
  for (const Json& ball : line.at("balls")) {
    out.balls.push_back({"", 0, ball.at("x"), ball.at("y"), 0, visible_share_of(ball)});
  }
  out.checked = line.value("checked", true);
  return out;
}

Frames read_frames(std::istream& in, const char* what) {
  Frames frames;
  std::string text;
  for (int number = 1; std::getline(in, text); ++number) {
    if (text.find_first_not_of(" \t\r") == std::string::npos) continue;
    try {
      const Json line = parse_own_json(text);
      const std::string frame = line.at("frame");
      if (!frames.emplace(frame, things_of(line)).second) {
        throw std::runtime_error("frame \"" + frame + "\" comes twice");
      }
    } catch (const std::exception& error) {
      throw std::runtime_error(fmt::format("{}, line {}: {}", what, number, error.what()));
    }
  }
  return frames;
}

struct Pair {
  const Thing* detection;
  const Thing* truth;
  double distance_mm;
};

/// Pairs each detection and each true thing at most once, nearest pairs first.
std::vector<Pair> match(const std::vector<Thing>& detections, const std::vector<Thing>& truth) {
  std::vector<Pair> near;
  for (const Thing& d : detections) {
    for (const Thing& t : truth) {
      const double distance_mm = std::hypot(d.x_mm - t.x_mm, d.y_mm - t.y_mm);
      if (d.team == t.team && distance_mm <= kMatchMm) near.push_back({&d, &t, distance_mm});
    }
  }
  std::stable_sort(near.begin(), near.end(),
                   [](const Pair& a, const Pair& b) { return a.distance_mm < b.distance_mm; });
  std::vector<Pair> pairs;
  for (const Pair& pair : near) {
    const bool taken = std::any_of(pairs.begin(), pairs.end(), [&](const Pair& other) {
      return other.detection == pair.detection || other.truth == pair.truth;
    });
    if (!taken) pairs.push_back(pair);
  }
  return pairs;
}

/// Counts one frame's robots, or its balls, and returns the pairs whose errors are scored.
std::vector<Pair> count(const std::vector<Thing>& detections, const std::vector<Thing>& truth,
                        double min_visible_share, FoundCounts& counts) {
  const auto is_expected = [&](const Thing& t) { return t.visible_share >= min_visible_share; };
  const std::vector<Pair> pairs = match(detections, truth);
  std::vector<Pair> found;
  for (const Pair& pair : pairs) {
    if (pair.detection->id != pair.truth->id) {
      ++counts.wrong_id;
    } else if (is_expected(*pair.truth)) {
      found.push_back(pair);
    }
  }
  counts.expected += static_cast<std::size_t>(std::count_if(truth.begin(), truth.end(), is_expected));
  counts.found += found.size();
  counts.invented += detections.size() - pairs.size();
  return found;
}

ErrorStatistics statistics_of(std::vector<double> errors) {
  ErrorStatistics out;
  out.count = errors.size();
  if (errors.empty()) return out;
  std::sort(errors.begin(), errors.end());
  const auto n = static_cast<double>(errors.size());
  double sum = 0, squares = 0;
  for (const double error : errors) {
    sum += error;
    squares += error * error;
  }
  out.mean = sum / n;
  out.rms = std::sqrt(squares / n);
  out.p95 = errors[static_cast<std::size_t>(std::ceil(0.95 * n)) - 1];
  out.max = errors.back();
  return out;
}

Json json_of(const ErrorStatistics& e) {
  return {{"count", e.count}, {"mean", e.mean}, {"rms", e.rms}, {"p95", e.p95}, {"max", e.max}};
}

Json json_of(const FoundCounts& c) {
  return {{"expected", c.expected}, {"found", c.found},     {"wrong_id", c.wrong_id},
          {"invented", c.invented}, {"recall", c.recall()}, {"precision", c.precision()}};
}

double share(std::size_t part, std::size_t whole) {
  return whole == 0 ? 1 : static_cast<double>(part) / static_cast<double>(whole);
}

}  // namespace

double FoundCounts::recall() const {
  return share(found, expected);
}
double FoundCounts::precision() const {
  return share(found, found + wrong_id + invented);
}

Score score(std::istream& detections, std::istream& truth, const ScoreOptions& options) {
  const Frames detected = read_frames(detections, "detections"), true_frames = read_frames(truth, "truth");
  Score out;
  std::vector<double> position_mm, orientation_deg, ball_mm;
  for (const auto& [frame, expected] : true_frames) {
    const auto found = detected.find(frame);
    if (found == detected.end()) {
      out.frames_without_detections.push_back(frame);
      continue;
    }
    ++out.frames_compared;
    if (!expected.checked) out.frames_not_checked.push_back(frame);
    for (const Pair& pair :
         count(found->second.robots, expected.robots, options.min_robot_share, out.robots)) {
      position_mm.push_back(pair.distance_mm);
      const double turn_rad =
          std::remainder(pair.detection->orientation_rad - pair.truth->orientation_rad, 2 * std::numbers::pi);
      orientation_deg.push_back(std::abs(turn_rad) * 180 / std::numbers::pi);
    }
    for (const Pair& pair : count(found->second.balls, expected.balls, options.min_ball_share, out.balls))
      ball_mm.push_back(pair.distance_mm);
  }
  for (const auto& [frame, things] : detected) {
    if (true_frames.count(frame) == 0) out.frames_without_truth.push_back(frame);
  }
  out.robot_position_mm = statistics_of(std::move(position_mm));
  out.robot_orientation_deg = statistics_of(std::move(orientation_deg));
  out.ball_position_mm = statistics_of(std::move(ball_mm));
  return out;
}

Score score_files(const std::string& detections_file, const std::string& truth_file,
                  const ScoreOptions& options) {
  std::ifstream detections(detections_file), truth(truth_file);
  if (!detections) throw std::runtime_error("cannot read " + detections_file);
  if (!truth) throw std::runtime_error("cannot read " + truth_file);
  return score(detections, truth, options);
}

Json score_json(const Score& score) {
  return {{"frames_compared", score.frames_compared},
          {"frames_without_detections", score.frames_without_detections},
          {"frames_without_truth", score.frames_without_truth},
          {"frames_not_checked", score.frames_not_checked},
          {"robots", json_of(score.robots)},
          {"robot_position_mm", json_of(score.robot_position_mm)},
          {"robot_orientation_deg", json_of(score.robot_orientation_deg)},
          {"balls", json_of(score.balls)},
          {"ball_position_mm", json_of(score.ball_position_mm)}};
}

std::string score_text(const Score& score) {
  std::string out = fmt::format("{} frames compared\n", score.frames_compared);
  const auto name_missing = [&](const std::vector<std::string>& frames, std::string_view what) {
    if (frames.empty()) return;
    out += fmt::format("{} frames without {}: {}\n", frames.size(), what, fmt::join(frames, " "));
  };
  name_missing(score.frames_without_detections, "detections");
  name_missing(score.frames_without_truth, "truth");
  name_missing(score.frames_not_checked, "a person's look at their truth");
  out += fmt::format("\n{:<22}{:>10}{:>10}{:>10}{:>10}{:>10}{:>10}\n", "", "expected", "found", "wrong id",
                     "invented", "recall", "precision");
  const auto count_row = [&](std::string_view name, const FoundCounts& c) {
    out += fmt::format("{:<22}{:>10}{:>10}{:>10}{:>10}{:>10.4f}{:>10.4f}\n", name, c.expected, c.found,
                       c.wrong_id, c.invented, c.recall(), c.precision());
  };
  count_row("robots", score.robots);
  count_row("balls", score.balls);
  out += fmt::format("\n{:<22}{:>10}{:>10}{:>10}{:>10}\n", "error", "mean", "rms", "p95", "max");
  const auto error_row = [&](std::string_view name, const ErrorStatistics& e) {
    out += fmt::format("{:<22}{:>10.3f}{:>10.3f}{:>10.3f}{:>10.3f}\n", name, e.mean, e.rms, e.p95, e.max);
  };
  error_row("robot position, mm", score.robot_position_mm);
  error_row("orientation, degrees", score.robot_orientation_deg);
  error_row("ball position, mm", score.ball_position_mm);
  return out;
}

}  // namespace sslv
