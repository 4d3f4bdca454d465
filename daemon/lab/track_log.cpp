// SPDX-License-Identifier: Apache-2.0
#include "lab/track_log.h"

#include "base/error.h"
#include "config/stages.h"
#include "ctl/table.h"
#include "net/heard_cameras.h"
#include "pipeline/pipeline.h"
#include "recording/match_log_reader.h"
#include "tracking/smoother.h"
#include "tracking/tracks_json.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <optional>
#include <ostream>
#include <set>
#include <utility>
#include <vector>

#include <fmt/format.h>

namespace sslv {
namespace {

using Eigen::Vector2d;

/// Speeds above anything in the league, and the largest error of a measurement.
constexpr double kRobotFastest_mm_s = 5000, kBallFastest_mm_s = 9000, kOffMm = 15;

/// The last position of one thing.
class Watch {
 public:
  void see(double t_s, const Vector2d& place_mm, double fastest_mm_s, Steadiness& out) {
    ++out.seen;
    if (last_) {
      const double passed_s = t_s - last_->first;
      const double way_mm = (place_mm - last_->second).norm();
      if (passed_s > Steadiness::kGap_s && passed_s < Steadiness::kBack_s) {
        ++out.gaps;
        out.gaps_s += passed_s;
      } else if (passed_s <= Steadiness::kGap_s && way_mm > fastest_mm_s * std::max(0.0, passed_s) + kOffMm) {
        ++out.jumps;
        out.worst_jump_mm = std::max(out.worst_jump_mm, way_mm);
      }
    }
    last_ = {t_s, place_mm};
  }

 private:
  std::optional<std::pair<double, Vector2d>> last_;
};

struct Sink : FieldSink {
  void publish(const TrackedField&) noexcept override {}
};

/// Arrival time of the log's current packet.
struct LogClock : FieldClock {
  double t_s = 0;
  double now_s() const noexcept override { return t_s; }
};

}  // namespace

TrackedLog track_log(const std::filesystem::path& file, const Config& config,
                     const TrackLogOptions& options) {
  MatchLogReader reader(file);
  FieldPipeline pipeline(field_stage_table(), config.field.stack, "/field/stack");
  const auto parameters = pipeline.parameters_of(config.field.stage_params);
  const BallModel ball = ball_model_of(config);
  FieldFrame frame;
  Sink sink;
  LogClock clock;
  HeardCameras cameras;
  std::optional<Smoother> smoother;
  if (options.later_s > 0) smoother.emplace(options.later_s).set_ball_model(ball);
  TrackedField later;
  TrackedLog out;
  std::map<RobotName, Watch> before, after;
  Watch ball_before, ball_after;
  const auto take = [&](const TrackedField& tracked) {
    for (const TrackedRobot& robot : tracked.robots)
      after[robot.name].see(tracked.t_s, robot.place_mm, kRobotFastest_mm_s, out.robots_after);
    if (!tracked.balls.empty())
      ball_after.see(tracked.t_s, tracked.balls[0].place_mm.head<2>(), kBallFastest_mm_s, out.ball_after);
    if (tracked.kick) out.kicks = static_cast<std::size_t>(tracked.kick->number);
    if (options.tracks) *options.tracks << json_text(to_json(tracked)) << "\n";
  };
  const auto take_later = [&](const Observations& seen, double now_s) {
    smoother->add(seen, now_s);
    if (!smoother->at(later)) return;
    ++later.number;
    take(later);
  };
  std::set<int> ids;
  std::optional<double> first_s;
  LoggedMessage message;
  while (reader.next(message)) {
    if (message.type != LoggedMessage::kVision2014) continue;
    const auto vision = VisionMessage::read(message.bytes);
    if (!vision) continue;
    ++out.packets;
    const double now_s = static_cast<double>(message.time_ns) * 1e-9;
    if (!cameras.hear(*vision, "log", true, now_s, now_s, frame.arrived)) continue;
    frame.arrived.image.is_of_other_computer = false;  // no camera of a log is ours: treat all alike
    const CameraSightings& image = frame.arrived.image;
    ids.insert(image.camera);
    clock.t_s = now_s;
    if (!first_s) first_s = clock.t_s;
    out.seconds = clock.t_s - *first_s;
    for (const RobotSighting& robot : image.robots) {
      before[{robot.team, robot.id}].see(image.t_capture_s, robot.place_mm, kRobotFastest_mm_s,
                                         out.robots_before);
    }
    const auto surest = std::max_element(
        image.balls.begin(), image.balls.end(),
        [](const BallSighting& a, const BallSighting& b) { return a.confidence < b.confidence; });
    if (surest != image.balls.end())
      ball_before.see(image.t_capture_s, surest->place_mm, kBallFastest_mm_s, out.ball_before);

    pipeline.run({frame, config.field, ball, clock, sink}, parameters);
    if (!smoother) take(frame.tracked);
    if (smoother) take_later(frame.observations, now_s);
  }
  if (!reader.problem().empty()) throw StorageError(reader.problem());
  // Output the tracks that are still delayed.
  constexpr double kPeriod_s = 1.0 / 75;
  for (double t_s = 0; smoother && first_s && t_s < options.later_s; t_s += kPeriod_s)
    take_later({}, clock.t_s + t_s);
  out.cameras = ids.size();
  return out;
}

Json tracked_log_json(const TrackedLog& log) {
  const auto steadiness = [](const Steadiness& one) {
    return Json{{"seen", one.seen},
                {"gaps", one.gaps},
                {"gaps_s", one.gaps_s},
                {"jumps", one.jumps},
                {"worst_jump_mm", one.worst_jump_mm}};
  };
  return {{"seconds", log.seconds},
          {"packets", log.packets},
          {"cameras", log.cameras},
          {"kicks", log.kicks},
          {"robots", {{"before", steadiness(log.robots_before)}, {"after", steadiness(log.robots_after)}}},
          {"ball", {{"before", steadiness(log.ball_before)}, {"after", steadiness(log.ball_after)}}}};
}

std::string tracked_log_text(const TrackedLog& log) {
  std::vector<std::vector<std::string>> rows;
  const auto add = [&](const char* what, const Steadiness& one) {
    rows.push_back({what, std::to_string(one.seen), std::to_string(one.gaps),
                    fmt::format("{:.1f}", one.gaps_s), std::to_string(one.jumps),
                    fmt::format("{:.0f}", one.worst_jump_mm)});
  };
  add("robots, as seen", log.robots_before);
  add("robots, tracked", log.robots_after);
  add("ball, as seen", log.ball_before);
  add("ball, tracked", log.ball_after);
  return fmt::format("{} packets of {} cameras in {:.1f} s, {} kicks\n\n", log.packets, log.cameras,
                     log.seconds, log.kicks) +
         table_text({{"what"},
                     {"places", true},
                     {"gaps", true},
                     {"gaps s", true},
                     {"jumps", true},
                     {"worst mm", true}},
                    rows);
}

}  // namespace sslv
