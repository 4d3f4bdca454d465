// SPDX-License-Identifier: Apache-2.0
#include "incumbent.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace sslv::worlds {

using Eigen::Vector2d;

namespace {

constexpr double kTick_s = 0.01;
constexpr int kMaxHealth = 20, kGrown = 3;
/// Deceleration of a sliding ball, mm/s2.
constexpr double kSlides = 3400;

double wrapped(double angle_rad) {
  return std::remainder(angle_rad, 2 * std::numbers::pi);
}
Vector2d unit(const Vector2d& v) {
  const double length = v.norm();
  return length > 1e-9 ? Vector2d(v / length) : Vector2d(0, 0);
}
/// A filter's weight in the mean.
double weight_of(double variance, int health) {
  return std::pow(std::sqrt(variance) / health, -1.5);
}

}  // namespace

void Incumbent::Axis::begin(double at, double variance, double error, double noise, double time_s,
                            double speed) {
  *this = {};
  place = at;
  velocity = speed;
  place_var = velocity_var = variance;
  model_error = error;
  noise_var = noise;
  t_s = time_s;
}

void Incumbent::Axis::predict(double to_s) {
  const double d = to_s - t_s;
  if (d <= 1e-6) return;
  const double density = 3 * model_error / (d * d * d);
  place += velocity * d;
  place_var += 2 * d * cross_var + d * d * velocity_var + density * d * d * d / 3;
  cross_var += d * velocity_var + density * d * d / 2;
  velocity_var += density * d;
  t_s = to_s;
}

void Incumbent::Axis::correct(double seen) {
  const double spread = place_var + noise_var, gain = place_var / spread, gain_velocity = cross_var / spread;
  const double off = seen - place;
  place += gain * off;
  velocity += gain_velocity * off;
  velocity_var -= gain_velocity * cross_var;
  cross_var -= gain * cross_var;
  place_var -= gain * place_var;
}

void Incumbent::add(const WorldImage& image) {
  const CameraSightings& seen = image.sightings;
  const double t_s = seen.t_capture_s;
  newest_s_ = std::max(newest_s_, t_s);
  constexpr double kRobotGone_s = 0.3, kBallGone_s = 1, kYoungGone_s = 0.1;
  for (auto& [name, filters] : robots_) {
    const auto filter = filters.find(seen.camera);
    if (filter != filters.end() && filter->second.health > 1) --filter->second.health;
  }
  for (const RobotSighting& robot : seen.robots) add_robot(seen.camera, t_s, robot);
  for (auto& [name, filters] : robots_) {
    const auto filter = filters.find(seen.camera);
    if (filter != filters.end() && t_s - filter->second.seen_s > kRobotGone_s) filters.erase(filter);
  }
  for (BallFilter& ball : balls_) {
    if (ball.camera != seen.camera) continue;
    ball.x.predict(t_s);
    ball.y.predict(t_s);
    if (ball.health > 1) --ball.health;
  }
  for (const BallSighting& ball : seen.balls) add_ball(seen.camera, t_s, ball);
  std::erase_if(balls_, [&](const BallFilter& ball) {
    return newest_s_ - ball.seen_s > (ball.sightings >= kGrown ? kBallGone_s : kYoungGone_s);
  });
  while (tick_s_ + kTick_s < image.arrival_s) tick(tick_s_ += kTick_s);
}

void Incumbent::add_robot(int camera, double t_s, const RobotSighting& seen) {
  constexpr double kNew_s = 0.5, kVariance = 100, kModelError = 0.1, kNoise = 20;
  constexpr double kFastest_mm_s = 6000, kFastestTurn = 30;
  const RobotName name{seen.team, seen.id};
  auto& filters = robots_[name];
  const auto known = filters.find(camera);
  if (known == filters.end() || t_s - known->second.seen_s > kNew_s) {
    const TrackedRobot before = robot(name, t_s).value_or(TrackedRobot{});
    RobotFilter& filter = filters[camera];
    filter = {};
    filter.x.begin(seen.place_mm.x(), kVariance, kModelError, kNoise, t_s, before.velocity_mm_s.x());
    filter.y.begin(seen.place_mm.y(), kVariance, kModelError, kNoise, t_s, before.velocity_mm_s.y());
    filter.angle.begin(seen.orientation_rad, kVariance, kModelError, 0.1 * kNoise, t_s, before.turn_rad_s);
    filter.seen_s = t_s;
    return;
  }
  RobotFilter& filter = known->second;
  for (Axis* axis : {&filter.x, &filter.y, &filter.angle}) axis->predict(t_s);
  const double passed_s = t_s - filter.seen_s;
  const double turned = wrapped(seen.orientation_rad - filter.angle.place);
  if ((Vector2d(filter.x.place, filter.y.place) - seen.place_mm).norm() > passed_s * kFastest_mm_s ||
      std::abs(turned) > passed_s * kFastestTurn)
    return;
  filter.health = std::min(kMaxHealth, filter.health + 2);
  filter.seen_s = t_s;
  filter.x.correct(seen.place_mm.x());
  filter.y.correct(seen.place_mm.y());
  filter.angle.correct(filter.angle.place + turned);
}

std::optional<TrackedRobot> Incumbent::robot(const RobotName& name, double t_s) {
  const auto known = robots_.find(name);
  if (known == robots_.end() || known->second.empty()) return {};
  TrackedRobot out;
  out.name = name;
  double place_sum = 0, velocity_sum = 0, angle_sum = 0, turn_sum = 0, angle = 0;
  const double first_angle = known->second.begin()->second.angle.place;
  for (const auto& [camera, filter] : known->second) {
    const double place = weight_of(2 * filter.x.place_var, filter.health),
                 velocity = weight_of(2 * filter.x.velocity_var, filter.health),
                 orientation = weight_of(filter.angle.place_var, filter.health),
                 turn = weight_of(filter.angle.velocity_var, filter.health);
    out.place_mm += place * Vector2d(filter.x.at(t_s), filter.y.at(t_s));
    out.velocity_mm_s += velocity * Vector2d(filter.x.velocity, filter.y.velocity);
    angle += orientation * wrapped(filter.angle.at(t_s) - first_angle);
    out.turn_rad_s += turn * filter.angle.velocity;
    place_sum += place;
    velocity_sum += velocity;
    angle_sum += orientation;
    turn_sum += turn;
  }
  out.place_mm /= place_sum;
  out.velocity_mm_s /= velocity_sum;
  out.orientation_rad = wrapped(first_angle + angle / angle_sum);
  out.turn_rad_s /= turn_sum;
  out.visibility = 1;
  return out;
}

void Incumbent::add_ball(int camera, double t_s, const BallSighting& seen) {
  constexpr double kFastest_mm_s = 15000, kVariance = 1000, kModelError = 0.1, kNoise = 100, kNearMm = 200;
  for (BallFilter& ball : balls_) {
    const double passed_s = t_s - ball.seen_s;
    const double off = (Vector2d(ball.x.place, ball.y.place) - seen.place_mm).norm();
    if (ball.camera != camera || passed_s <= 0 || off >= passed_s * kFastest_mm_s) continue;
    ball.x.correct(seen.place_mm.x());
    ball.y.correct(seen.place_mm.y());
    ball.health = std::min(kMaxHealth, ball.health + 2);
    ball.sightings = std::min(kGrown, ball.sightings + 1);
    ball.seen_s = t_s;
    ball.seen_mm = seen.place_mm;
    return;
  }
  Vector2d velocity(0, 0);
  for (const BallFilter& ball : balls_) {
    if (ball.sightings >= kGrown && (Vector2d(ball.x.place, ball.y.place) - seen.place_mm).norm() < kNearMm)
      velocity = {ball.x.velocity, ball.y.velocity};
  }
  BallFilter ball;
  ball.camera = camera;
  ball.x.begin(seen.place_mm.x(), kVariance, kModelError, kNoise, t_s, velocity.x());
  ball.y.begin(seen.place_mm.y(), kVariance, kModelError, kNoise, t_s, velocity.y());
  ball.seen_s = t_s;
  ball.seen_mm = seen.place_mm;
  balls_.push_back(ball);
}

std::optional<Incumbent::Merged> Incumbent::merged_ball(double t_s) {
  // The filter nearest to the previous ball, preferring recently seen ones.
  const BallFilter* main = nullptr;
  double best = 1e18;
  for (const BallFilter& ball : balls_) {
    if (ball.sightings < kGrown) continue;
    const double age_s = newest_s_ - ball.seen_s;
    const double score = (Vector2d(ball.x.place, ball.y.place) - last_ball_mm_).norm() + 3000 * age_s +
                         (age_s > 0.15 ? 1e5 : 0);
    if (score >= best) continue;
    best = score;
    main = &ball;
  }
  if (!main) return {};
  constexpr double kSameMm = 300;
  const Vector2d at(main->x.place, main->y.place);
  Merged out;
  double sum = 0;
  for (const BallFilter& ball : balls_) {
    if (ball.sightings < kGrown || (Vector2d(ball.x.place, ball.y.place) - at).norm() >= kSameMm) continue;
    const double weight = weight_of(2 * ball.x.place_var, ball.health);
    sum += weight;
    out.place_mm += weight * Vector2d(ball.x.at(t_s), ball.y.at(t_s));
    out.velocity_mm_s += weight * Vector2d(ball.x.velocity, ball.y.velocity);
    out.seen_mm += weight * ball.seen_mm;
    out.seen_s = std::max(out.seen_s, ball.seen_s);
  }
  out.place_mm /= sum;
  out.velocity_mm_s /= sum;
  out.seen_mm /= sum;
  last_ball_mm_ = out.place_mm;
  return out;
}

void Incumbent::tick(double now_s) {
  const auto ball = merged_ball(now_s);
  if (!ball || ball->seen_s <= recorded_s_) return;
  recorded_s_ = ball->seen_s;
  Record record{ball->seen_s, ball->seen_mm, {}};
  for (const auto& [name, filters] : robots_) {
    if (const auto one = robot(name, ball->seen_s)) record.robots.push_back(*one);
  }
  records_.push_back(std::move(record));
  constexpr std::size_t kRecords = 5, kMaxSince = 40;
  if (records_.size() > kRecords) records_.pop_front();
  if (kick_) {
    since_kick_.emplace_back(ball->seen_s, ball->seen_mm);
    if (since_kick_.size() > kMaxSince) since_kick_.pop_front();
    fit_kick();
  }
  if (records_.size() == kRecords && ball->seen_s - kicked_s_ >= 0.1) look_for_kick();
}

/// A kick: the ball leaves a robot's front and moves away from it in each of five consecutive records.
void Incumbent::look_for_kick() {
  constexpr double kNearMm = 90 + World::kBallRadiusMm + 90, kFrontRad = 0.8, kSlowest_mm_s = 600,
                   kAwayMm = 130;
  for (const TrackedRobot& first : records_.front().robots) {
    const auto distance = [&](const Record& record) {
      const auto same = std::find_if(record.robots.begin(), record.robots.end(),
                                     [&](const TrackedRobot& one) { return one.name == first.name; });
      return same == record.robots.end() ? -1 : (record.ball_mm - same->place_mm).norm();
    };
    const Vector2d way = records_.front().ball_mm - first.place_mm;
    if (way.norm() > kNearMm ||
        std::abs(wrapped(std::atan2(way.y(), way.x()) - first.orientation_rad)) > kFrontRad)
      continue;
    bool leaves = true;
    for (std::size_t k = 1; k < records_.size() && leaves; ++k) {
      const double before = distance(records_[k - 1]), after = distance(records_[k]);
      const double passed_s = records_[k].t_s - records_[k - 1].t_s;
      leaves = before >= 0 && after >= before + (k > 1 ? 5 : -1) && passed_s > 0 &&
               (k == 1 || (records_[k].ball_mm - records_[k - 1].ball_mm).norm() / passed_s >= kSlowest_mm_s);
    }
    if (!leaves || distance(records_.back()) < kAwayMm) continue;
    TrackedKick kick;
    kick.number = kick_ ? kick_->number + 1 : 1;
    kick.t_s = kicked_s_ = records_.front().t_s;
    kick.place_mm = records_.front().ball_mm;
    kick.robot = first.name;
    kick_ = kick;
    since_kick_.clear();
    for (std::size_t k = 1; k < records_.size(); ++k)
      since_kick_.emplace_back(records_[k].t_s, records_[k].ball_mm);
    fit_kick();
    return;
  }
}

/// Fits a straight line with constant deceleration.
void Incumbent::fit_kick() {
  constexpr std::size_t kFewest = 3, kMost = 30;
  if (since_kick_.size() < kFewest || since_kick_.size() > kMost) return;
  Vector2d velocity(0, 0);
  for (int pass = 0; pass < 3; ++pass) {
    double count = 0, times = 0, squares = 0;
    Vector2d places(0, 0), products(0, 0);
    for (const auto& [t_s, place] : since_kick_) {
      const double u = t_s - kick_->t_s;
      const Vector2d even = place + unit(velocity) * (0.5 * kSlides * u * u);
      ++count;
      times += u;
      squares += u * u;
      places += even;
      products += even * u;
    }
    const double spread = count * squares - times * times;
    if (spread < 1e-12) break;
    velocity = (products * count - places * times) / spread;
  }
  kick_->velocity_mm_s << velocity, 0;
}

std::optional<TrackedBall> Incumbent::ball(double t_s) {
  const auto ball = merged_ball(t_s);
  if (!ball) return {};
  TrackedBall out;
  out.place_mm << ball->place_mm, World::kBallRadiusMm;
  out.velocity_mm_s << ball->velocity_mm_s, 0;
  out.visibility = newest_s_ - ball->seen_s < 0.03 ? 1 : 0;
  return out;
}

}  // namespace sslv::worlds
