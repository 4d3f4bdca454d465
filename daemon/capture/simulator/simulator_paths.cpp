// SPDX-License-Identifier: Apache-2.0
#include "capture/simulator/simulator_paths.h"

#include "capture/simulator/simulator_prints.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>

namespace sslv {
namespace {

constexpr double kTwoPi = 2 * std::numbers::pi;
constexpr double kFromLinesMm = 30;  // robots stay inside the field's lines

/// The minimum angle between neighbours on a ring so that `count` things, at least `radius_mm` from the
/// centre, are at least `apart_mm` apart; nothing if the things do not fit.
std::optional<double> min_angle(int count, double radius_mm, double apart_mm) {
  if (count < 2) return 0.0;
  if (apart_mm > 2 * radius_mm) return std::nullopt;
  const double angle = 2 * std::asin(apart_mm / (2 * radius_mm));
  if (angle * count > kTwoPi) return std::nullopt;
  return angle;
}

}  // namespace

double SimulatorPaths::Swing::at(double t_s) const {
  return middle + reach * std::sin(kTwoPi * rate_hz * t_s + phase);
}

SimulatorPaths::SimulatorPaths(const SimulatorOptions& options, const FieldSize& field,
                               const std::array<double, 2>& robot_height_mm)
    : speed_(options.speed) {
  SimulatorRandom random(static_cast<std::uint64_t>(options.seed));
  lay_paths(options, field, random);
  const auto dots = choose_covered_dots(drivers_.size(), options.covered_dots, random);
  const HallOptions hall = resolved(options.hall);
  for (std::size_t i = 0; i < dots.size(); ++i) {
    Driver& driver = drivers_[i];
    driver.covered_dot = dots[i];
    driver.height_mm =
        print_height_mm(hall, driver.team, driver.id, robot_height_mm[static_cast<std::size_t>(driver.team)]);
  }
  for (int i = 0; i < options.distractors; ++i) {
    SimulatedDistractor& one = distractors_.emplace_back(make_distractor(random));
    one.x_mm = random.uniform(-0.5, 0.5) * field.field_length;
    one.y_mm = random.uniform(-0.5, 0.5) * field.field_width;
  }
}

void SimulatorPaths::lay_paths(const SimulatorOptions& options, const FieldSize& field,
                               SimulatorRandom& random) {
  const double edge_mm = field.max_robot_radius + kFromLinesMm;
  const double half_x = field.field_length / 2.0 - edge_mm, half_y = field.field_width / 2.0 - edge_mm;
  const double disc_mm = std::min(half_x, half_y);
  const double robots_apart_mm = 2 * field.max_robot_radius + kSimulatorClearanceMm;
  const double balls_apart_mm = 2 * field.ball_radius + kSimulatorClearanceMm;
  const double robot_to_ball_mm = field.max_robot_radius + field.ball_radius + kSimulatorClearanceMm;
  const double min_pitch_mm = 2 * robot_to_ball_mm + 10;  // between two rings, including a lane for balls
  if (disc_mm < min_pitch_mm) throw no_room("robots", options, field);
  stretch_x_ = half_x / disc_mm;
  stretch_y_ = half_y / disc_mm;

  SimulatedRoster roster = roster_of(options);
  // Use more rings for more robots, if the field is wide enough.
  const auto robots = static_cast<int>(roster.size());
  const int wanted_rings = std::max(1, static_cast<int>(std::lround(std::sqrt(0.75 * robots))));
  const int rings = std::min(wanted_rings, static_cast<int>(disc_mm / min_pitch_mm));
  const double pitch_mm = disc_mm / rings;
  const double wobble_mm = 0.2 * (pitch_mm - min_pitch_mm);
  const auto ring_radius_mm = [&](int ring) { return (ring + 0.8) * pitch_mm; };

  // Distribute the robots over the rings in proportion to the rings' lengths.
  std::vector<int> on_ring(static_cast<std::size_t>(rings), 0);
  for (int robot = 0; robot < robots; ++robot) {
    int best = -1;
    for (int ring = 0; ring < rings; ++ring) {
      const int count = on_ring[static_cast<std::size_t>(ring)] + 1;
      if (!min_angle(count, ring_radius_mm(ring) - wobble_mm, robots_apart_mm)) continue;
      if (best < 0 || count / ring_radius_mm(ring) <
                          (on_ring[static_cast<std::size_t>(best)] + 1) / ring_radius_mm(best)) {
        best = ring;
      }
    }
    if (best < 0) throw no_room("robots", options, field);
    ++on_ring[static_cast<std::size_t>(best)];
  }

  shuffle(roster, random);

  /// `count` orbits with a common rotation, evenly spaced, each oscillating as far as `apart_mm` permits.
  const auto orbits = [&](int count, const Swing& radius, double apart_mm, double speed_mm_s) {
    const double turn_rad_s = (random.bits() % 2 == 0 ? 1 : -1) * speed_mm_s / radius.middle;
    const double start = random.angle();
    const double least = *min_angle(count, radius.middle - radius.reach, apart_mm);
    const double spare = 0.499 * (kTwoPi / std::max(count, 1) - least);
    std::vector<Orbit> out;
    for (int i = 0; i < count; ++i) {
      Orbit& orbit = out.emplace_back();
      orbit.radius_mm = {radius.middle, radius.reach, random.uniform(0.03, 0.12), random.angle()};
      // The oscillation along the ring is at most 500 mm, so that it stays slower than the rotation.
      orbit.angle_rad = {start + i * kTwoPi / count, std::min(spare, 500 / radius.middle),
                         random.uniform(0.04, 0.12), random.angle()};
      orbit.turn_rad_s = turn_rad_s;
    }
    return out;
  };

  std::size_t next = 0;
  for (int ring = 0; ring < rings; ++ring) {
    const Swing radius{ring_radius_mm(ring), wobble_mm, 0, 0};
    const double speed_mm_s = random.uniform(400, 900);
    for (const Orbit& orbit :
         orbits(on_ring[static_cast<std::size_t>(ring)], radius, robots_apart_mm, speed_mm_s)) {
      const auto [team, id] = roster[next++];
      drivers_.push_back(
          {team, id, orbit, {random.angle(), 2.0, random.uniform(0.05, 0.2), random.angle()}, 0, {}});
    }
  }

  // Lane n lies inside ring n. Lanes get equal numbers of balls; the remaining balls are added from the
  // middle lane on.
  for (int lane = 0; lane < rings; ++lane) {
    const int offset = (lane - rings / 2 + rings) % rings;
    const int count = options.balls / rings + (offset < options.balls % rings ? 1 : 0);
    const double margin_mm = wobble_mm + robot_to_ball_mm;
    const double inner_mm = lane == 0 ? 0.15 * pitch_mm : ring_radius_mm(lane - 1) + margin_mm;
    const double outer_mm = ring_radius_mm(lane) - margin_mm;
    if (!min_angle(count, inner_mm, balls_apart_mm)) throw no_room("robots", options, field);
    const Swing radius{(inner_mm + outer_mm) / 2, (outer_mm - inner_mm) / 2, 0, 0};
    const double speed_mm_s = random.uniform(500, 1200);
    for (const Orbit& orbit : orbits(count, radius, balls_apart_mm, speed_mm_s)) balls_.push_back(orbit);
  }
}

SimulatorPaths::Point SimulatorPaths::on_field(const Orbit& orbit, double t_s) const {
  const double radius = orbit.radius_mm.at(t_s);
  const double angle = orbit.angle_rad.at(t_s) + orbit.turn_rad_s * t_s;
  const double c = std::cos(angle), s = std::sin(angle);
  const double forward = orbit.turn_rad_s < 0 ? -1 : 1;
  return {stretch_x_ * radius * c, stretch_y_ * radius * s,
          std::atan2(forward * stretch_y_ * c, -forward * stretch_x_ * s)};
}

SimulatedScene SimulatorPaths::at(double t_s) const {
  const double t = speed_ * t_s;
  SimulatedScene scene;
  for (const Driver& driver : drivers_) {
    const Point point = on_field(driver.orbit, t);
    scene.robots.push_back({driver.team, driver.id, point.x_mm, point.y_mm,
                            normalized(point.travel_rad + driver.heading_rad.at(t)), driver.height_mm,
                            driver.covered_dot});
  }
  for (const Orbit& orbit : balls_) {
    const Point point = on_field(orbit, t);
    scene.balls.push_back({point.x_mm, point.y_mm});
  }
  scene.distractors.assign(distractors_.begin(), distractors_.end());
  return scene;
}

}  // namespace sslv
