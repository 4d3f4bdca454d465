// SPDX-License-Identifier: Apache-2.0
#include "score.h"

#include "ours.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>

namespace sslv::worlds {

using Eigen::Vector2d, Eigen::Vector3d;

namespace {

/// Time from an image's measurements to the packet.
constexpr double kWork_s = 0.3e-3;
/// Time in which tracks settle, which is not scored; set-up has its own row.
constexpr double kWarm_s = 6;
constexpr double kShortly_s = 0.05;
/// Tracks with at least this visibility count as shown; a track farther off than kElsewhereMm is of another
/// object.
constexpr double kShown = 0.5, kElsewhereMm = 300;

double wrapped(double angle_rad) {
  return std::remainder(angle_rad, 2 * std::numbers::pi);
}

/// No camera sees robots beyond the carpet.
bool is_on_carpet(const Vector2d& place) {
  return std::abs(place.x()) <= 6350 && std::abs(place.y()) <= 4800;
}

class Scorer {
 public:
  Scorer(const World& world, Rival& rival) : world_(world), rival_(rival) {
    const auto robots = static_cast<std::size_t>(world.options().robots);
    robots_.resize(robots);
    kicks_.resize(world.kicks().size());
    for (const KickTruth& kick : world.kicks()) turns_s_.push_back(kick.t_s);
    for (const auto& [t_s, turn] : world.turns()) turns_s_.push_back(t_s);
    std::sort(turns_s_.begin(), turns_s_.end());
  }

  Score score() {
    double work_s = 0, before_s = 0;
    for (const WorldImage& image : world_.images()) {
      const double now_s = image.arrival_s + kWork_s;
      const auto began = std::chrono::steady_clock::now();
      rival_.add(image);
      const auto ball = rival_.ball(now_s);
      work_s += std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
      is_warm_ = now_s > kWarm_s;
      if (image.true_balls > 0) ball_seen_s_ = image.t_true_s;
      for (const RobotSighting& robot : image.sightings.robots) {
        const int seen = World::robot_of(robot.team, robot.id);
        if (seen < world_.options().robots) robots_[static_cast<std::size_t>(seen)].seen_s = image.t_true_s;
      }
      if (set_up_s_ < 0) watch_set_up(now_s);
      for (int i = 0; i < world_.options().robots; ++i)
        score_robot(i, now_s, before_s > 0 ? now_s - before_s : 0);
      if (is_warm_) {
        watch_ghost_robots(now_s);
        watch_ghost_balls(now_s);
      }
      if (is_warm_) score_ball(ball, now_s, before_s > 0 ? now_s - before_s : 0);
      score_kick(now_s);
      before_s = now_s;
    }
    for (std::size_t i = 0; i < kicks_.size(); ++i) {
      const KickTruth& kick = world_.kicks()[i];
      if (kick.t_s < kWarm_s || kick.t_s > world_.options().duration_s - 0.3 || kick.is_hidden) continue;
      ++out_.counts["kicks"];
      if (kicks_[i].number == 0) ++out_.counts["kicks missed"];
    }
    out_.errors["work us"].add(1e6 * work_s / static_cast<double>(world_.images().size()));
    out_.errors["set-up ms"].add(1e3 * set_up_s_);
    out_.scored_s = world_.options().duration_s - kWarm_s;
    return std::move(out_);
  }

 private:
  /// Watches events after which the velocity is wrong for a while.
  struct Watch {
    std::size_t next = 0;
    double began_s = -1;  // time of the watched event; -1: none
    double over_s = 0;    // how long the velocity has been wrong since then
  };
  struct RobotScore {
    double seen_s = -1e9;  // by any camera
    Watch swerve, collision;
    Vector2d error_mm{0, 0};  // at the previous image
    bool had_error = false;
  };
  struct KickScore {
    int number = 0;  // as reported; 0: not reported
    std::array<bool, 3> landing_scored{};
  };

  /// Seconds since the last of these events; begins to watch new ones.
  double since(const std::vector<double>& moments_s, Watch& watch, double now_s) const {
    while (watch.next < moments_s.size() && moments_s[watch.next] < now_s) {
      if (is_warm_ && now_s - moments_s[watch.next] < 0.02) {
        watch.began_s = moments_s[watch.next];
        watch.over_s = 0;
      }
      ++watch.next;
    }
    return watch.next > 0 ? now_s - moments_s[watch.next - 1] : 9;
  }
  void add_error(Watch& watch, const char* name, double velocity_error, double now_s, double passed_s) {
    if (watch.began_s < 0) return;
    if (velocity_error > 100) watch.over_s += passed_s;
    if (now_s - watch.began_s <= 0.25) return;
    out_.errors[name].add(1e3 * watch.over_s);
    watch.began_s = -1;
  }

  /// Counts robots shown as visible far from any robot of that name.
  void watch_ghost_robots(double now_s) {
    for (int of_all = 0; of_all < static_cast<int>(is_ghost_.size()); ++of_all) {
      const auto robot = estimate(of_all, now_s);
      bool is_ghost = robot && robot->visibility >= kShown;
      if (is_ghost && of_all < world_.options().robots) {
        const Vector2d truth = world_.robot(of_all, now_s).place_mm;
        const bool is_seen = now_s - robots_[static_cast<std::size_t>(of_all)].seen_s < kShortly_s;
        is_ghost = is_seen && is_on_carpet(truth) && (robot->place_mm - truth).norm() > kElsewhereMm;
        if (of_all == 0 && world_.options().has_twin && is_ghost)
          is_ghost = (robot->place_mm - World::twin_mm(now_s)).norm() > kElsewhereMm;
      }
      bool& was_ghost = is_ghost_[static_cast<std::size_t>(of_all)];
      if (is_ghost && !was_ghost) ++out_.counts["ghosts of robots"];
      was_ghost = is_ghost;
    }
  }

  void watch_ghost_balls(double now_s) {
    bool is_ghost = false;
    if (now_s - ball_seen_s_ < kShortly_s) {
      const Vector2d truth = world_.ball(now_s).place_mm.head<2>();
      for (const TrackedBall& ball : rival_.balls(now_s)) {
        if (ball.visibility < kShown) continue;
        const Vector2d place = ball.place_mm.head<2>();
        const bool is_second =
            world_.options().has_second_ball && (place - World::kSecondBallMm).norm() < kElsewhereMm;
        is_ghost = is_ghost || (!is_second && (place - truth).norm() > kElsewhereMm);
      }
    }
    if (is_ghost && !was_ghost_ball_) ++out_.counts["ghosts of balls"];
    was_ghost_ball_ = is_ghost;
  }

  bool turns_within(double from_s, double to_s) const {
    const auto first = std::lower_bound(turns_s_.begin(), turns_s_.end(), from_s);
    return first != turns_s_.end() && *first < to_s;
  }
  std::optional<TrackedRobot> estimate(int i, double t_s) {
    return rival_.robot({World::team_of(i), World::id_of(i)}, t_s);
  }

  void watch_set_up(double now_s) {
    int right = 0;
    for (int i = 0; i < world_.options().robots; ++i) {
      const auto robot = estimate(i, now_s);
      const RobotTruth truth = world_.robot(i, now_s);
      if (robot && (robot->place_mm - truth.place_mm).norm() < 15 &&
          (robot->velocity_mm_s - truth.velocity_mm_s).norm() < 300)
        ++right;
    }
    if (right >= world_.options().robots - 2) set_up_s_ = now_s - world_.images().front().arrival_s;
  }

  void score_robot(int i, double now_s, double passed_s) {
    // After neither of the two was seen for a while, no tracker can know which is the right one.
    if (i == 0 && world_.options().has_twin) return;
    RobotScore& state = robots_[static_cast<std::size_t>(i)];
    const RobotTruth truth = world_.robot(i, now_s);
    const double since_swerve_s = std::min(since(world_.swerves_of(i), state.swerve, now_s),
                                           since(world_.collisions_of(i), state.collision, now_s));
    if (!is_on_carpet(truth.place_mm) || !is_on_carpet(world_.robot(i, now_s - 0.6).place_mm)) {
      state.had_error = false;
      state.swerve.began_s = state.collision.began_s = -1;
      return;
    }
    const auto robot = estimate(i, now_s);
    // A tracker cannot know robots that no camera sees, but must not show them as seen.
    constexpr double kUnseen_s = 0.12;
    if (now_s - state.seen_s > kUnseen_s) {
      if (is_warm_ && robot && robot->visibility >= 1) ++out_.counts["unseen robots shown as seen (images)"];
      state.had_error = false;
      state.swerve.began_s = state.collision.began_s = -1;
      return;
    }
    if (!robot) {
      if (is_warm_) ++out_.counts["robots missing (images)"];
      state.had_error = false;
      return;
    }
    const Vector2d error_mm = robot->place_mm - truth.place_mm;
    const double velocity_error = (robot->velocity_mm_s - truth.velocity_mm_s).norm();
    if (is_warm_) {
      out_.errors["robot place"].add(error_mm.norm());
      out_.errors["robot velocity"].add(velocity_error);
      out_.errors["robot orientation deg"].add(wrapped(robot->orientation_rad - truth.angle_rad) * 180 /
                                               std::numbers::pi);
      out_.errors["robot turn"].add(robot->turn_rad_s - truth.turn_rad_s);
      if (since_swerve_s > 0.15) {
        out_.errors["robot velocity steady"].add(velocity_error);
        if (truth.velocity_mm_s.norm() < 20) out_.errors["robot velocity standing"].add(velocity_error);
        if (state.had_error) {
          const bool is_at_border = std::abs(truth.place_mm.x()) < 560 || std::abs(truth.place_mm.y()) < 510;
          out_.errors[is_at_border ? "jump at border" : "jump inside"].add(
              (error_mm - state.error_mm).norm());
        }
      }
    }
    state.error_mm = error_mm;
    state.had_error = true;
    add_error(state.swerve, "swerve ms", velocity_error, now_s, passed_s);
    add_error(state.collision, "collision ms", velocity_error, now_s, passed_s);
  }

  void score_ball(const std::optional<TrackedBall>& ball, double now_s, double passed_s) {
    const BallTruth truth = world_.ball(now_s);
    const bool is_seen = now_s - ball_seen_s_ < kShortly_s;
    if (!ball) {
      if (is_seen) out_.counts["ball missing while seen (s)"] += passed_s;
      return;
    }
    const Vector3d off = ball->place_mm - truth.place_mm;
    const double error_mm = off.head<2>().norm();
    const double speed = truth.velocity_mm_s.head<2>().norm();
    const bool is_flying = truth.place_mm.z() > World::kBallRadiusMm + 1;
    if (is_seen) {
      out_.counts["ball seen (s)"] += passed_s;
      if (error_mm > 300) out_.counts["ball off while seen (s)"] += passed_s;
      if (!turns_within(now_s - 0.1, now_s + 0.006)) {
        const char* kind = truth.is_held                           ? "ball held"
                           : is_flying                             ? "ball flying"
                           : world_.ball_slows_mm_s2(now_s) > 1500 ? "ball sliding"
                                                                   : "ball rolling";
        if (truth.is_held || is_flying || speed > 50)
          out_.errors[kind].add(is_flying ? off.norm() : error_mm);
      }
    }
    const double hidden_s = now_s - ball_seen_s_;
    if (hidden_s < kShortly_s) hidden_scored_ = {};
    constexpr std::array kHidden_s{0.1, 0.2, 0.3};
    static constexpr std::array kFreeNames{"ball hidden 100 ms", "ball hidden 200 ms", "ball hidden 300 ms"};
    static constexpr std::array kHeldNames{"held ball hidden 100 ms", "held ball hidden 200 ms",
                                           "held ball hidden 300 ms"};
    for (std::size_t k = 0; k < kHidden_s.size(); ++k) {
      if (hidden_s < kHidden_s[k] || hidden_s > kHidden_s[k] + 0.02 || hidden_scored_[k]) continue;
      hidden_scored_[k] = true;
      if (turns_within(ball_seen_s_ - 0.1, now_s) || is_flying) continue;
      if (truth.is_held) out_.errors[kHeldNames[k]].add(error_mm);
      if (!truth.is_held && speed > 100) out_.errors[kFreeNames[k]].add(error_mm);
    }
  }

  void score_kick(double now_s) {
    const auto kick = rival_.kick();
    if (!kick) return;
    if (kick->number != last_number_) {
      last_number_ = kick->number;
      score_new_kick(*kick, now_s);
    }
    for (std::size_t i = 0; i < kicks_.size(); ++i) {
      const KickTruth& truth = world_.kicks()[i];
      const double age_s = now_s - truth.t_s;
      if (truth.t_s < kWarm_s || truth.is_hidden || age_s < 0 || age_s > 0.35) continue;
      constexpr std::array kAges_s{0.05, 0.1, 0.2};
      static constexpr std::array kNames{"50 ms", "100 ms", "200 ms"};
      for (std::size_t j = 0; j < kAges_s.size(); ++j) {
        if (age_s < kAges_s[j] || kicks_[i].landing_scored[j]) continue;
        kicks_[i].landing_scored[j] = true;
        const bool is_known = kicks_[i].number != 0 && kick->number == kicks_[i].number;
        score_known_kick(truth, is_known ? &*kick : nullptr, kAges_s[j], kNames[j]);
      }
    }
  }

  void score_known_kick(const KickTruth& truth, const TrackedKick* kick, double age_s,
                        const std::string& name) {
    if (truth.is_chip) {
      const bool counts = truth.landing_s > truth.t_s + age_s && truth.landing_s - truth.t_s < 1.2 &&
                          std::abs(truth.landing_mm.x()) < 5800 && std::abs(truth.landing_mm.y()) < 4300;
      if (!counts) return;
      ++out_.counts["chips at " + name];
      if (!kick || !kick->is_chip) return;
      ++out_.counts["chips called at " + name];
      out_.errors["chip landing at " + name].add((kick->landing_mm - truth.landing_mm).norm());
      return;
    }
    ++out_.counts["flat kicks at " + name];
    if (!kick) return;
    if (kick->is_chip) {
      ++out_.counts["flat kicks called chips at " + name];
      return;
    }
    if (turns_within(truth.t_s + 0.01, truth.t_s + age_s)) return;
    const double speed = kick->velocity_mm_s.head<2>().norm();
    out_.errors["kick speed at " + name].add(speed - truth.velocity_mm_s.head<2>().norm());
    out_.errors["kick time ms at " + name].add(1e3 * (kick->t_s - truth.t_s));
    out_.errors["kick place at " + name].add((kick->place_mm - truth.place_mm).norm());
  }

  void score_new_kick(const TrackedKick& kick, double now_s) {
    double nearest_s = 0.05;
    std::optional<std::size_t> at;
    for (std::size_t i = 0; i < kicks_.size(); ++i) {
      const double off_s = std::abs(world_.kicks()[i].t_s - kick.t_s);
      if (off_s >= nearest_s) continue;
      nearest_s = off_s;
      at = i;
    }
    if (!at) {
      if (!is_warm_) return;
      const bool was_turn = turns_within(kick.t_s - 0.06, kick.t_s + 0.06);
      ++out_.counts[was_turn ? "deflections called kicks" : "false kicks"];
      return;
    }
    const KickTruth& truth = world_.kicks()[*at];
    const bool is_again = kicks_[*at].number != 0;
    kicks_[*at].number = kick.number;
    if (is_again) {
      if (is_warm_) ++out_.counts["kicks reported twice"];
      return;
    }
    if (truth.t_s < kWarm_s || truth.is_hidden) return;
    out_.errors["kick published ms"].add(1e3 * (now_s - truth.t_s));
  }

  const World& world_;
  Rival& rival_;
  Score out_;
  std::vector<RobotScore> robots_;
  std::vector<KickScore> kicks_;
  std::vector<double> turns_s_;
  std::array<bool, 3> hidden_scored_{};
  std::array<bool, 32> is_ghost_{};  // robots of all ids that patterns encode
  bool was_ghost_ball_ = false;
  bool is_warm_ = false;
  double set_up_s_ = -1, ball_seen_s_ = -1;
  int last_number_ = 0;
};

}  // namespace

void Errors::add(double error) {
  values_.push_back(static_cast<float>(std::abs(error)));
  squares_ += error * error;
}

double Errors::rms() const {
  return values_.empty() ? 0 : std::sqrt(squares_ / static_cast<double>(values_.size()));
}

double Errors::quantile(double share) const {
  if (values_.empty()) return 0;
  std::vector<float> values = values_;
  const auto at =
      values.begin() + static_cast<std::ptrdiff_t>(std::min(share * static_cast<double>(values.size()),
                                                            static_cast<double>(values.size() - 1)));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

void Errors::append(const Errors& other) {
  values_.insert(values_.end(), other.values_.begin(), other.values_.end());
  squares_ += other.squares_;
}

void Score::append(const Score& other) {
  for (const auto& [name, more] : other.errors) errors[name].append(more);
  for (const auto& [name, more] : other.counts) counts[name] += more;
  scored_s += other.scored_s;
}

double Score::a_minute(const std::string& count) const {
  const auto found = counts.find(count);
  return found == counts.end() ? 0 : 60 * found->second / scored_s;
}

Score score_later(const World& world, double lag_s) {
  Score out;
  Later later(lag_s);
  std::vector<double> seen_s(static_cast<std::size_t>(world.options().robots), -1e9);
  for (const WorldImage& image : world.images()) {
    const TrackedField& field = later.add(image);
    if (field.t_s < kWarm_s) continue;
    for (const TrackedRobot& robot : field.robots) {
      const int i = World::robot_of(robot.name.team, robot.name.id);
      if (i >= world.options().robots || robot.visibility < 1) continue;
      const RobotTruth truth = world.robot(i, field.t_s);
      if (!is_on_carpet(truth.place_mm)) continue;
      out.errors["robot place"].add((robot.place_mm - truth.place_mm).norm());
      out.errors["robot velocity"].add((robot.velocity_mm_s - truth.velocity_mm_s).norm());
      out.errors["robot turn"].add(robot.turn_rad_s - truth.turn_rad_s);
    }
    if (field.balls.empty()) continue;
    const TrackedBall& ball = field.balls[0];
    const BallTruth truth = world.ball(field.t_s);
    const double error_mm = (ball.place_mm - truth.place_mm).head<2>().norm();
    out.errors[ball.visibility < 1 ? "ball hidden" : "ball"].add(error_mm);
  }
  out.scored_s = world.options().duration_s - kWarm_s;
  return out;
}

Score score(const World& world, Rival& rival) {
  return Scorer(world, rival).score();
}

}  // namespace sslv::worlds
