// SPDX-License-Identifier: Apache-2.0
#include "lab/track_score.h"

#include "base/clock.h"
#include "base/error.h"
#include "capture/simulator/simulator.h"
#include "ctl/table.h"
#include "net/multicast_receiver.h"
#include "net/parse.h"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <numbers>
#include <thread>

#include <fmt/format.h>

namespace sslv {
namespace {

using Eigen::Vector2d;

constexpr double kMmPerMeter = 1000;
/// Number of packets that are not compared at first: a new track is not yet good.
constexpr std::size_t kSettles = 150;
constexpr double kWrongBallMm = 300;

double degrees(double rad) {
  return rad * 180 / std::numbers::pi;
}
double wrapped(double rad) {
  return std::remainder(rad, 2 * std::numbers::pi);
}

/// Time step for the derivatives of the true state.
constexpr double kStep_s = 1e-3;

}  // namespace

double TrackScorer::Errors::quantile(double share) const {
  if (values.empty()) return 0;
  std::vector<float> sorted = values;
  const auto at = static_cast<std::size_t>(share * static_cast<double>(sorted.size() - 1));
  std::nth_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(at), sorted.end());
  return static_cast<double>(sorted[at]);
}

double TrackScorer::Errors::rms() const {
  double squares = 0;
  for (const float value : values) squares += static_cast<double>(value) * static_cast<double>(value);
  return values.empty() ? 0 : std::sqrt(squares / static_cast<double>(values.size()));
}

void TrackScorer::add(const TrackedFrame& frame, double now_s) {
  if (++packets_ <= kSettles) return;
  const double t_s = frame.timestamp();
  const SimulatedScene before = world_.at(t_s - kStep_s), now = world_.at(t_s),
                       after = world_.at(t_s + kStep_s);
  const auto note = [&](const char* what, double error) {
    errors_[what].values.push_back(static_cast<float>(std::abs(error)));
  };
  note("packet's age ms", (now_s - t_s) * 1e3);

  std::set<Key> seen;
  for (const auto& robot : frame.robots()) {
    const Key key{robot.robot_id().team() == ::BLUE ? 1 : 0, static_cast<int>(robot.robot_id().id())};
    std::size_t i = 0;
    while (i < now.robots.size() && Key{static_cast<int>(now.robots[i].team), now.robots[i].id} != key) ++i;
    if (i == now.robots.size() || !seen.insert(key).second) {
      ++ghosts_;
      continue;
    }
    const SimulatedRobot& truth = now.robots[i];
    const Vector2d off(robot.pos().x() * kMmPerMeter - truth.x_mm,
                       robot.pos().y() * kMmPerMeter - truth.y_mm);
    const Vector2d velocity((after.robots[i].x_mm - before.robots[i].x_mm) / (2 * kStep_s),
                            (after.robots[i].y_mm - before.robots[i].y_mm) / (2 * kStep_s));
    note("robot's place mm", off.norm());
    note("robot's velocity mm/s",
         (Vector2d(robot.vel().x(), robot.vel().y()) * kMmPerMeter - velocity).norm());
    note("robot's orientation deg", degrees(wrapped(robot.orientation() - truth.orientation_rad)));
    const double turn =
        wrapped(after.robots[i].orientation_rad - before.robots[i].orientation_rad) / (2 * kStep_s);
    note("robot's turn rad/s", robot.vel_angular() - turn);
    if (const auto last = last_error_mm_.find(key); last != last_error_mm_.end())
      note("robot's jump mm", (off - last->second).norm());
    last_error_mm_[key] = off;
  }
  robots_expected_ += now.robots.size();
  robots_missing_ += now.robots.size() - seen.size();

  if (now.balls.empty()) return;
  if (frame.balls_size() == 0) {
    ++balls_missing_;
    return;
  }
  const auto& ball = frame.balls(0);
  const Vector2d place(ball.pos().x() * kMmPerMeter, ball.pos().y() * kMmPerMeter);
  std::size_t nearest = 0;
  double off_mm = 1e9;
  for (std::size_t i = 0; i < now.balls.size(); ++i) {
    const double distance = (place - Vector2d(now.balls[i].x_mm, now.balls[i].y_mm)).norm();
    if (distance >= off_mm) continue;
    off_mm = distance;
    nearest = i;
  }
  if (off_mm > kWrongBallMm) {
    ++balls_wrong_;
    return;
  }
  const Vector2d velocity((after.balls[nearest].x_mm - before.balls[nearest].x_mm) / (2 * kStep_s),
                          (after.balls[nearest].y_mm - before.balls[nearest].y_mm) / (2 * kStep_s));
  note("ball's place mm", off_mm);
  note("ball's velocity mm/s", (Vector2d(ball.vel().x(), ball.vel().y()) * kMmPerMeter - velocity).norm());
}

SimulatedWorld simulated_world(const Config& config) {
  for (std::size_t i = 0; i < config.cameras.size(); ++i) {
    const Json& source = config.cameras[i].source;
    if (source.at("backend") != "simulator") continue;
    Json options = source;
    options.erase("backend");
    return {simulator_options(options, fmt::format("/cameras/{}/source", i)),
            config.field,
            {config.teams.yellow.robot_height, config.teams.blue.robot_height}};
  }
  throw SettingsError("no camera of the service is simulated: nobody knows the truth of what it sees");
}

TrackScorer score_tracks(const Config& config, const SimulatedWorld& world, double seconds) {
  const TrackerSettings& tracker = config.network.tracker;
  if (!tracker.enabled)
    throw SettingsError("the service sends no tracks: set network/tracker/enabled to true");
  TrackScorer scorer(world);
  std::mutex mutex;
  MulticastReceiver receiver("tracks",
                             [&](std::span<const std::byte> datagram, const boost::asio::ip::udp::endpoint&) {
                               TrackerWrapperPacket packet;
                               const double now_s = unix_time_s();
                               if (!parse(packet, datagram) || packet.source_name() != tracker.source_name)
                                 return;
                               const std::lock_guard lock(mutex);
                               scorer.add(packet.tracked_frame(), now_s);
                             });
  receiver.listen(GroupAddress{tracker.group, tracker.port, config.network.vision.interface});
  std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
  const std::string error = receiver.error();
  receiver.listen(std::nullopt);
  if (!error.empty()) throw SettingsError(error);
  if (scorer.packets() == 0)
    throw SettingsError(
        fmt::format("no tracks came from {}:{} in {} s", tracker.group, tracker.port, seconds));
  return scorer;
}

Json track_score_json(const TrackScorer& scorer) {
  Json out{{"packets", scorer.packets()},
           {"robots_expected", scorer.robots_expected()},
           {"robots_missing", scorer.robots_missing()},
           {"ghosts", scorer.ghosts()},
           {"balls_missing", scorer.balls_missing()},
           {"balls_wrong", scorer.balls_wrong()},
           {"errors", Json::object()}};
  for (const auto& [what, errors] : scorer.errors()) {
    out["errors"][what] = {{"count", errors.values.size()},
                           {"p50", errors.quantile(0.5)},
                           {"p99", errors.quantile(0.99)},
                           {"rms", errors.rms()}};
  }
  return out;
}

std::string track_score_text(const TrackScorer& scorer) {
  std::vector<std::vector<std::string>> rows;
  for (const auto& [what, errors] : scorer.errors()) {
    rows.push_back({what, std::to_string(errors.values.size()), fmt::format("{:.3g}", errors.quantile(0.5)),
                    fmt::format("{:.3g}", errors.quantile(0.99)), fmt::format("{:.3g}", errors.rms())});
  }
  return table_text({{"error of"}, {"count", true}, {"p50", true}, {"p99", true}, {"rms", true}}, rows) +
         fmt::format(
             "\n{} packets; robots missing {} of {}, not there {}; ball missing {}, more than {:.0f} mm off "
             "{}\n",
             scorer.packets(), scorer.robots_missing(), scorer.robots_expected(), scorer.ghosts(),
             scorer.balls_missing(), kWrongBallMm, scorer.balls_wrong());
}

}  // namespace sslv
