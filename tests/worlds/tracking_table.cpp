// SPDX-License-Identifier: Apache-2.0
// Track quality of our tracker and of the league's usual one, on the same measurements: a Markdown table with
// limits; exit code 1 if one is missed.
//   tracking_table [--seeds 3] [--first-seed 1] [--seconds 60] [--details]
// --details: all measured values of every scenario.

#include "incumbent.h"
#include "ours.h"
#include "score.h"
#include "tracking/ball_model_learner.h"

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>

namespace sslv::worlds {
namespace {

/// Scores of both trackers over all seeds.
struct Scores {
  Score usual, ours;
};

struct Scenario {
  const char* name;
  std::function<void(WorldOptions&)> change;
};

const std::vector<Scenario>& scenarios() {
  static const std::vector<Scenario> kAll{
      {"play", [](WorldOptions&) {}},
      {"wobble .3 mm", [](WorldOptions& world) { world.wobble_mm = 0.3; }},
      {"jitter .5 ms", [](WorldOptions& world) { world.jitter_sigma_s = 0.5e-3; }},
      {"good hardware",
       [](WorldOptions& world) {
         world.latency_s = 0.005;
         world.jitter_sigma_s = 0.02e-3;
         world.clock_offset_sigma_s = 0.1e-3;
       }},
      {"only chips", [](WorldOptions& world) { world.only_chips = true; }},
      {"robots' heights +- 8 mm",
       [](WorldOptions& world) {
         world.robot_height_spread_mm = 8;
         world.robot_bias_mm = world.floor_bias_mm = 0;
       }},
      {"two balls", [](WorldOptions& world) { world.has_second_ball = true; }},
      {"a camera dies", [](WorldOptions& world) { world.camera_dies_s = 20; }},
      {"robots stand among false balls",
       [](WorldOptions& world) {
         world.robots_stand = true;
         world.false_ball_share = 0.2;
       }},
      {"occlusions with false balls",
       [](WorldOptions& world) {
         world.occlusions_per_s = 1;
         world.false_ball_share = 0.1;
       }},
      {"robots collide", [](WorldOptions& world) { world.robots_collide = true; }},
      {"patterns misread", [](WorldOptions& world) { world.misread_share = 0.002; }},
      {"a robot's id seen twice", [](WorldOptions& world) { world.has_twin = true; }},
      {"a ball on a robot", [](WorldOptions& world) { world.has_ball_on_robot = true; }},
      {"hands and shirts", [](WorldOptions& world) { world.hands_share = 0.5; }},
      {"uneven images",
       [](WorldOptions& world) {
         world.uneven_sigma_s = 2.5e-3;
         world.jitter_sigma_s = 0.02e-3;
       }},
      {"cameras see 20 mm too far out", [](WorldOptions& world) { world.outwards_mm = 20; }},
      {"other kickers",
       [](WorldOptions& world) {
         world.kick_takes_s = 6e-3;
         world.kick_passes_on = 1;
         world.chip_rises_from_deg = 30;
         world.chip_rises_to_deg = 60;
       }},
  };
  return kAll;
}

/// Delay of the smoothed tracks in recordings.
constexpr double kLater_s = 0.25;

constexpr const char* kBallModel = "ball's model after 20 kicks";

using Figure = std::function<double(const Score&)>;

double rms(const Score& score, const char* name) {
  const auto found = score.errors.find(name);
  return found == score.errors.end() ? 0 : found->second.rms();
}
double quantile(const Score& score, const char* name, double share) {
  const auto found = score.errors.find(name);
  return found == score.errors.end() ? 0 : found->second.quantile(share);
}
double count(const Score& score, const char* name) {
  const auto found = score.counts.find(name);
  return found == score.counts.end() ? 0 : found->second;
}
Figure rms_of(const char* name) {
  return [name](const Score& score) { return rms(score, name); };
}
Figure share_of(const char* name, double share) {
  return [name, share](const Score& score) { return quantile(score, name, share); };
}
Figure a_minute(const char* name) {
  return [name](const Score& score) { return score.a_minute(name); };
}
Figure an_hour(const char* name) {
  return [name](const Score& score) { return 60 * score.a_minute(name); };
}
Figure percent(const char* name, const char* of) {
  return
      [name, of](const Score& score) { return 100 * count(score, name) / std::max(1e-9, count(score, of)); };
}

struct Row {
  const char *what, *scenario;
  Figure figure;
  double most;  // limit; negative: lower limit, without its sign
};

std::vector<Row> rows() {
  return {
      {"robot velocity, rms (mm/s)", "play", rms_of("robot velocity"), 25},
      {"robot velocity, p50 (mm/s)", "play", share_of("robot velocity", 0.5), 9},
      {"standing robot's velocity, p50 (mm/s)", "play", share_of("robot velocity standing", 0.5), 1},
      {"more than 100 mm/s off after a change of direction, rms (ms)", "play", rms_of("swerve ms"), 30},
      {"the same", "good hardware", rms_of("swerve ms"), 10},
      {"robot velocity, rms (mm/s)", "wobble .3 mm", rms_of("robot velocity"), 50},
      {"robot velocity, rms (mm/s)", "jitter .5 ms", rms_of("robot velocity"), 30},
      {"robot's jump at a border, p99 (mm)", "play", share_of("jump at border", 0.99), 0.8},
      {"orientation, rms (degrees)", "play", rms_of("robot orientation deg"), 0.3},
      {"angular velocity, rms (rad/s)", "play", rms_of("robot turn"), 0.4},
      {"ball rolling, p50 (mm)", "play", share_of("ball rolling", 0.5), 1.4},
      {"ball rolling, p99 (mm)", "play", share_of("ball rolling", 0.99), 8},
      {"ball sliding, p50 (mm)", "play", share_of("ball sliding", 0.5), 1.4},
      {"ball sliding, p99 (mm)", "play", share_of("ball sliding", 0.99), 10},
      {"ball more than 300 mm off while seen (%)", "play",
       percent("ball off while seen (s)", "ball seen (s)"), 0.1},
      {"kick published, p50 (ms)", "play", share_of("kick published ms", 0.5), 38},
      {"kick published, p99 (ms)", "play", share_of("kick published ms", 0.99), 55},
      {"kick's time after 100 ms, rms (ms)", "play", rms_of("kick time ms at 100 ms"), 1.4},
      {"kick's place after 100 ms, rms (mm)", "play", rms_of("kick place at 100 ms"), 3.7},
      {"kick's speed after 100 ms, rms (mm/s)", "play", rms_of("kick speed at 100 ms"), 12},
      {"false kicks (a minute)", "play", a_minute("false kicks"), 0.2},
      {"deflections reported as kicks (a minute)", "play", a_minute("deflections called kicks"), 0.5},
      {"chip's landing after 100 ms, p50 (mm)", "only chips", share_of("chip landing at 100 ms", 0.5), 80},
      {"chip's landing after 200 ms, p50 (mm)", "only chips", share_of("chip landing at 200 ms", 0.5), 25},
      {"chips recognised after 100 ms (%)", "only chips",
       percent("chips called at 100 ms", "chips at 100 ms"), -85},
      {"chips recognised after 200 ms (%)", "only chips",
       percent("chips called at 200 ms", "chips at 200 ms"), -95},
      {"ball hidden for 100 ms, p50 (mm)", "play", share_of("ball hidden 100 ms", 0.5), 1.7},
      {"ball hidden for 200 ms, p50 (mm)", "play", share_of("ball hidden 200 ms", 0.5), 7},
      {"the same", "occlusions with false balls", share_of("ball hidden 200 ms", 0.5), 10},
      {"held ball hidden for 300 ms, p50 (mm)", "play", share_of("held ball hidden 300 ms", 0.5), 2},
      {"images in which a robot is missing", "play",
       [](const Score& score) { return count(score, "robots missing (images)"); }, 0},
      {"the same", "robots stand among false balls",
       [](const Score& score) { return count(score, "robots missing (images)"); }, 0},
      {"ghosts of robots (an hour)", "play", an_hour("ghosts of robots"), 0},
      {"the same", "patterns misread", an_hour("ghosts of robots"), 0},
      {"the same", "a robot's id seen twice", an_hour("ghosts of robots"), 0},
      {"the same", "hands and shirts", an_hour("ghosts of robots"), 0},
      {"ghosts of balls (an hour)", "play", an_hour("ghosts of balls"), 0},
      {"the same", "robots stand among false balls", an_hour("ghosts of balls"), 0},
      {"the same", "a ball on a robot", an_hour("ghosts of balls"), 0},
      {"the same", "hands and shirts", an_hour("ghosts of balls"), 0},
      {"set-up (ms)", "play", rms_of("set-up ms"), 30},
      {"robot's place, p50 (mm)", "robots' heights +- 8 mm", share_of("robot place", 0.5), 0.5},
      {"robot's height, rms (mm)", "robots' heights +- 8 mm", rms_of("height"), 1.5},
      {"ball more than 300 mm off while seen (%)", "two balls",
       percent("ball off while seen (s)", "ball seen (s)"), 0.5},
      {"the same", "occlusions with false balls", percent("ball off while seen (s)", "ball seen (s)"), 0.5},
      {"the same", "a ball on a robot", percent("ball off while seen (s)", "ball seen (s)"), 0.1},
      {"the same", "hands and shirts", percent("ball off while seen (s)", "ball seen (s)"), 1},
      {"kicks missed (%)", "hands and shirts", percent("kicks missed", "kicks"), 5},
      {"more than 100 mm/s off after a collision, rms (ms)", "robots collide", rms_of("collision ms"), 70},
      {"kick's speed after 100 ms, rms (mm/s)", "other kickers", rms_of("kick speed at 100 ms"), 25},
      {"chip's landing after 200 ms, p50 (mm)", "other kickers", share_of("chip landing at 200 ms", 0.5),
       100},
      {"robot velocity, rms (mm/s)", "uneven images", rms_of("robot velocity"), 30},
      {"ball sliding, p99 (mm)", "uneven images", share_of("ball sliding", 0.99), 10},
      {"ball more than 300 mm off while seen (%)", "uneven images",
       percent("ball off while seen (s)", "ball seen (s)"), 0.1},
      {"robot's place, p50 (mm)", "cameras see 20 mm too far out", share_of("robot place", 0.5), 20},
      {"robot's place, p99 (mm)", "cameras see 20 mm too far out", share_of("robot place", 0.99), 28},
      {"robot velocity, p50 (mm/s)", "a camera dies", share_of("robot velocity", 0.5), 9},
      {"robot velocity, rms (mm/s)", "a camera dies", rms_of("robot velocity"), 40},
      {"images in which a robot that is not seen is shown as seen", "a camera dies",
       [](const Score& score) { return count(score, "unseen robots shown as seen (images)"); }, 0},
      {"false kicks (a minute)", "robots stand among false balls", a_minute("false kicks"), 0.2},
      {"the same", "occlusions with false balls", a_minute("false kicks"), 0.5},
      {"ball's sliding, most off (%)", kBallModel, share_of("slides", 1), 3},
      {"ball's rolling, most off (%)", kBallModel, share_of("rolls", 1), 3},
      {"where it begins to roll, most off (%)", kBallModel, share_of("rolls from", 1), 3},
      {"speed left by the first hop, most off (%)", kBallModel, share_of("first hop", 1), 3},
      {"speed left by later hops, most off (%)", kBallModel, share_of("later hops", 1), 3},
      {"upward speed left by hops, most off (%)", kBallModel, share_of("hops up", 1), 3},
      {"robot velocity .25 s later, rms (mm/s)", "play", rms_of("later: robot velocity"), 10},
      {"angular velocity .25 s later, rms (rad/s)", "play", rms_of("later: robot turn"), 0.1},
      {"ball's place .25 s later, p99 (mm)", "play", share_of("later: ball", 0.99), 50},
      {"work for an image (us)", "play", rms_of("work us"), 60},
  };
}

/// Consecutive seeds.
struct Seeds {
  int first = 1, count = 3;
};

Scores play(const Scenario& scenario, const Seeds& seeds, double seconds) {
  Scores out;
  for (int seed = seeds.first; seed < seeds.first + seeds.count; ++seed) {
    WorldOptions options;
    options.seed = static_cast<std::uint64_t>(seed);
    options.duration_s = seconds;
    scenario.change(options);
    const World world(options);
    Ours ours;
    Incumbent usual;
    out.ours.append(score(world, ours));
    out.usual.append(score(world, usual));
    // A tracker without smoothing has the same estimate later.
    for (const auto& [what, errors] : score_later(world, kLater_s).errors) {
      out.ours.errors["later: " + what].append(errors);
      if (const auto at_once = out.usual.errors.find(what); at_once != out.usual.errors.end())
        out.usual.errors["later: " + what] = at_once->second;
    }
    for (int i = 0; i < options.robots; ++i) {
      const double truth_mm = world.height_of(i) - World::kRobotHeightMm;
      const auto height = ours.agreement().height_of({World::team_of(i), World::id_of(i)});
      out.ours.errors["height"].add((height ? height->more_mm : 0) - truth_mm);
      out.usual.errors["height"].add(truth_mm);
    }
  }
  return out;
}

/// Errors of the ball model after `kKicks` kicks of each kind, in percent.
Scores learn_ball(const Seeds& seeds) {
  constexpr int kKicks = 20;
  constexpr double kLongest_s = 400;
  Scores out;
  for (const bool only_chips : {false, true}) {
    for (int seed = seeds.first; seed < seeds.first + seeds.count; ++seed) {
      WorldOptions options;
      options.seed = static_cast<std::uint64_t>(seed);
      options.duration_s = kLongest_s;
      options.only_chips = only_chips;
      const World world(options);
      Ours ours;
      KickWatch watch;
      BallModelLearner learner;
      TrackedField tracked;
      int kicks = 0;
      double work_s = 0;
      for (const WorldImage& image : world.images()) {
        ours.add(image);
        ours.tracker().at(image.arrival_s, tracked);
        const auto began = std::chrono::steady_clock::now();
        if (const WatchedKick* kick = watch.add(ours.observations(), tracked)) learner.learn(*kick, {});
        work_s =
            std::max(work_s, std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count());
        const LearntBallModel& now = learner.learnt();
        kicks = only_chips ? now.chips : now.kicks;
        if (kicks >= kKicks) break;
      }
      const LearntBallModel& learnt = learner.learnt();
      const auto add = [&](const char* what, const LearntBallModel::Value& value, double truth) {
        out.ours.errors[what].add(100 * (value.value / truth - 1));
        out.ours.errors[std::string(what) + ", sigmas"].add((value.value - truth) /
                                                            std::max(1e-9, value.sigma));
      };
      out.ours.errors["learning takes ms"].add(work_s * 1e3);
      if (only_chips) {
        add("first hop", learnt.first_hop_xy, 0.75);
        add("later hops", learnt.later_hops_xy, 0.95);
        add("hops up", learnt.hops_z, 0.6);
      } else {
        add("slides", learnt.slides_mm_s2, world.slides_mm_s2());
        add("rolls", learnt.rolls_mm_s2, world.rolls_mm_s2());
        add("rolls from", learnt.rolls_from_share, 5.0 / 7);
      }
      out.ours.counts[only_chips ? "chips" : "kicks"] += kicks;
    }
  }
  return out;
}

void print_details(const std::string& name, const Scores& scores) {
  const auto print = [&](const char* whose, const Score& score) {
    fmt::print("\n{}, {}\n", name, whose);
    for (const auto& [what, errors] : score.errors) {
      fmt::print("  {:32} rms {:9.3f} p50 {:9.3f} p99 {:9.3f} of {}\n", what, errors.rms(),
                 errors.quantile(0.5), errors.quantile(0.99), errors.count());
    }
    for (const auto& [what, number] : score.counts) fmt::print("  {:32} {:9.2f}\n", what, number);
  };
  print("as usual", scores.usual);
  print("ours", scores.ours);
}

/// Prints the table; returns false if a limit is missed.
bool table(const Seeds& seeds, double seconds, bool with_details) {
  std::map<std::string_view, Scores> all;
  for (const Scenario& scenario : scenarios()) all[scenario.name] = play(scenario, seeds, seconds);
  all[kBallModel] = learn_ball(seeds);
  fmt::print("| what | scenario | as usual | ours | must reach | |\n|---|---|---:|---:|---:|---|\n");
  bool is_reached = true;
  for (const Row& row : rows()) {
    const Scores& scores = all.at(row.scenario);
    const double usual = row.figure(scores.usual), ours = row.figure(scores.ours);
    const bool is_good = row.most < 0 ? ours >= -row.most : ours <= row.most;
    is_reached = is_reached && is_good;
    fmt::print("| {} | {} | {:.3g} | {:.3g} | {} {} | {} |\n", row.what, row.scenario, usual, ours,
               row.most < 0 ? ">=" : "<=", std::abs(row.most), is_good ? "" : "missed");
  }
  if (with_details) {
    for (const auto& [name, scores] : all) print_details(std::string(name), scores);
  }
  return is_reached;
}

}  // namespace
}  // namespace sslv::worlds

int main(int argc, char** argv) {
  sslv::worlds::Seeds seeds;
  double seconds = 60;
  bool with_details = false;
  for (int i = 1; i < argc; ++i) {
    const std::string_view name = argv[i];
    if (name == "--details") {
      with_details = true;
    } else if (name == "--seeds" && i + 1 < argc) {
      seeds.count = std::atoi(argv[++i]);
    } else if (name == "--first-seed" && i + 1 < argc) {
      seeds.first = std::atoi(argv[++i]);
    } else if (name == "--seconds" && i + 1 < argc) {
      seconds = std::atof(argv[++i]);
    } else {
      fmt::print(stderr,
                 "tracking_table: expected [--seeds N] [--first-seed N] [--seconds S] [--details], not {}\n",
                 name);
      return 64;
    }
  }
  return sslv::worlds::table(seeds, seconds, with_details) ? 0 : 1;
}
