// SPDX-License-Identifier: Apache-2.0
#include "tracking/clocks.h"

#include <algorithm>
#include <cmath>

namespace sslv {

using Eigen::Vector2d;

void Evenness::add(const CameraSightings& seen, double even_s, double jitter_s) {
  Image& now = images_[count_++ % images_.size()];
  now.stamp_s = seen.t_capture_s;
  now.moved_s = even_s - seen.t_capture_s;
  now.robots.clear();
  for (const RobotSighting& robot : seen.robots)
    now.robots.push_back({{robot.team, robot.id}, robot.place_mm, robot.place_cov_mm2.trace() / 2});
  if (count_ >= images_.size())
    compare(images_[count_ % images_.size()], images_[(count_ + 1) % images_.size()], now);
  // What holds until robots move: small differences are jitter.
  constexpr double kJitter_s = 0.5e-3, kInformation = 4;
  const double likely = 1 / (1 + std::pow(jitter_s / kJitter_s, 2));
  share_ = std::clamp((weighted_ + kInformation * likely) / (information_ + kInformation), 0.0, 1.0);
}

void Evenness::compare(const Image& before, const Image& middle, const Image& after) {
  constexpr double kLongest_s = 0.25, kRemembers_s = 20;
  const double passed_s = after.stamp_s - before.stamp_s, part = (middle.stamp_s - before.stamp_s) / passed_s;
  if (!(passed_s > 0 && passed_s < kLongest_s && part > 0 && part < 1)) return;
  const double keeps = std::exp(-(after.stamp_s - middle.stamp_s) / kRemembers_s);
  information_ *= keeps;
  weighted_ *= keeps;
  const double moved_s = middle.moved_s - (1 - part) * before.moved_s - part * after.moved_s;
  const auto find = [](const Image& image, const RobotName& name) {
    return std::ranges::find(image.robots, name, &Robot::name);
  };
  for (const Robot& robot : middle.robots) {
    const auto a = find(before, robot.name), b = find(after, robot.name);
    if (a == before.robots.end() || b == after.robots.end()) continue;
    const Vector2d way = b->place_mm - a->place_mm, off = robot.place_mm - a->place_mm - part * way;
    // A robot that goes farther is another one that was misread.
    constexpr double kFastest_mm_s = 6000, kMaxOffMm = 40, kAcceleration_mm_s2 = 1500;
    if (way.norm() > kFastest_mm_s * passed_s || off.norm() > kMaxOffMm) continue;
    const Vector2d moves_mm = way / passed_s * moved_s;
    const double turns_mm = kAcceleration_mm_s2 * passed_s * passed_s / 8,
                 var_mm2 = robot.var_mm2 + (a->var_mm2 + b->var_mm2) / 4 + turns_mm * turns_mm;
    information_ += moves_mm.squaredNorm() / var_mm2;
    weighted_ += moves_mm.dot(off) / var_mm2;
  }
}

}  // namespace sslv
