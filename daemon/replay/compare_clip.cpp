// SPDX-License-Identifier: Apache-2.0
#include "replay/compare_clip.h"

#include "net/parse.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string_view>

namespace sslv {
namespace {

constexpr double kSameThingMm = 100;

/// A robot or a ball of a packet.
struct FoundThing {
  std::optional<Team> team{};  // none: a ball
  int id = -1;
  double x_mm = 0, y_mm = 0, orientation_rad = 0, pixel_x = 0, pixel_y = 0;
  bool is_matched = false;
};

void add_robots(const google::protobuf::RepeatedPtrField<SSL_DetectionRobot>& robots, Team team,
                std::vector<FoundThing>& out) {
  for (const SSL_DetectionRobot& robot : robots) {
    out.push_back({team, robot.has_robot_id() ? static_cast<int>(robot.robot_id()) : -1, robot.x(), robot.y(),
                   robot.orientation(), robot.pixel_x(), robot.pixel_y()});
  }
}

std::vector<FoundThing> robots_in(const SSL_WrapperPacket& packet) {
  std::vector<FoundThing> out;
  add_robots(packet.detection().robots_yellow(), Team::kYellow, out);
  add_robots(packet.detection().robots_blue(), Team::kBlue, out);
  return out;
}

std::vector<FoundThing> balls_in(const SSL_WrapperPacket& packet) {
  std::vector<FoundThing> out;
  for (const SSL_DetectionBall& ball : packet.detection().balls())
    out.push_back({std::nullopt, -1, ball.x(), ball.y(), 0, ball.pixel_x(), ball.pixel_y()});
  return out;
}

/// Compares the robots, or the balls, of one frame.
class ThingMatcher {
 public:
  ThingMatcher(std::vector<FoundThing> before, std::vector<FoundThing> after, const CompareLimits& limits,
               DifferenceCounts& counts, std::vector<ClipDifference>& out)
      : before_(std::move(before)), after_(std::move(after)), limits_(limits), counts_(counts), out_(out) {}

  void compare() {
    counts_.before += before_.size();
    counts_.after += after_.size();
    match([](const FoundThing& a, const FoundThing& b) { return a.team == b.team && a.id == b.id; });
    match([](const FoundThing& a, const FoundThing& b) { return a.team == b.team; });
    for (const FoundThing& thing : before_) {
      if (thing.is_matched) continue;
      ++counts_.lost;
      out_.push_back({ClipDifference::Kind::kLost, thing.team, thing.id, -1, thing.x_mm, thing.y_mm, 0, 0,
                      thing.pixel_x, thing.pixel_y});
    }
    for (const FoundThing& thing : after_) {
      if (thing.is_matched) continue;
      ++counts_.found;
      out_.push_back({ClipDifference::Kind::kFound, thing.team, -1, thing.id, thing.x_mm, thing.y_mm, 0, 0,
                      thing.pixel_x, thing.pixel_y});
    }
  }

 private:
  struct Pair {
    FoundThing *before, *after;
    double distance_mm;
  };

  /// Associates the nearest pairs first, each thing at most once.
  template <class MayBeSame>
  void match(MayBeSame may_be_same) {
    std::vector<Pair> pairs;
    for (FoundThing& a : before_) {
      for (FoundThing& b : after_) {
        const double distance_mm = std::hypot(a.x_mm - b.x_mm, a.y_mm - b.y_mm);
        if (!a.is_matched && !b.is_matched && may_be_same(a, b) && distance_mm <= kSameThingMm)
          pairs.push_back({&a, &b, distance_mm});
      }
    }
    std::stable_sort(pairs.begin(), pairs.end(),
                     [](const Pair& a, const Pair& b) { return a.distance_mm < b.distance_mm; });
    for (const Pair& pair : pairs) {
      if (pair.before->is_matched || pair.after->is_matched) continue;
      pair.before->is_matched = pair.after->is_matched = true;
      take(pair);
    }
  }

  void take(const Pair& pair) {
    const FoundThing &a = *pair.before, &b = *pair.after;
    const double turned_deg =
        std::abs(std::remainder(b.orientation_rad - a.orientation_rad, 2 * std::numbers::pi)) * 180 /
        std::numbers::pi;
    counts_.max_moved_mm = std::max(counts_.max_moved_mm, pair.distance_mm);
    counts_.max_turned_deg = std::max(counts_.max_turned_deg, turned_deg);
    const bool has_moved = pair.distance_mm > limits_.moved_mm || turned_deg > limits_.turned_deg;
    if (a.id == b.id && !has_moved) return;
    const auto kind = a.id != b.id ? ClipDifference::Kind::kIdChanged : ClipDifference::Kind::kMoved;
    ++(a.id != b.id ? counts_.id_changed : counts_.moved);
    out_.push_back(
        {kind, b.team, a.id, b.id, b.x_mm, b.y_mm, pair.distance_mm, turned_deg, b.pixel_x, b.pixel_y});
  }

  std::vector<FoundThing> before_, after_;
  const CompareLimits& limits_;
  DifferenceCounts& counts_;
  std::vector<ClipDifference>& out_;
};

void read_packet(std::span<const std::byte> bytes, SSL_WrapperPacket& packet) {
  if (bytes.empty() || !parse(packet, bytes)) packet.Clear();
}

Json counts_json(const DifferenceCounts& counts) {
  return {{"before", counts.before},
          {"after", counts.after},
          {"found", counts.found},
          {"lost", counts.lost},
          {"moved", counts.moved},
          {"id_changed", counts.id_changed},
          {"max_moved_mm", counts.max_moved_mm},
          {"max_turned_deg", counts.max_turned_deg}};
}

std::string_view kind_name(ClipDifference::Kind kind) {
  switch (kind) {
    case ClipDifference::Kind::kFound: return "found";
    case ClipDifference::Kind::kLost: return "lost";
    case ClipDifference::Kind::kMoved: return "moved";
    case ClipDifference::Kind::kIdChanged: return "id_changed";
  }
  return "";
}

}  // namespace

void ClipComparison::add(std::span<const std::byte> before, std::span<const std::byte> after) {
  ++frames_;
  const bool same_bytes = std::ranges::equal(before, after);
  if (!same_bytes) ++frames_with_other_bytes_;
  read_packet(before, before_);
  read_packet(after, after_);
  const SSL_DetectionFrame& named = after_.has_detection() ? after_.detection() : before_.detection();
  FrameDifferences frame{named.frame_number(), named.t_capture(), {}};
  ThingMatcher(robots_in(before_), robots_in(after_), limits_, robots_, frame.differences).compare();
  ThingMatcher(balls_in(before_), balls_in(after_), limits_, balls_, frame.differences).compare();
  if (!frame.differences.empty()) ++frames_that_differ_;
  if ((!frame.differences.empty() || !same_bytes) && kept_.size() < kMaxKept)
    kept_.push_back(std::move(frame));
}

Json comparison_json(const ClipComparison& comparison) {
  Json differences = Json::array();
  for (const FrameDifferences& frame : comparison.different_frames()) {
    Json what = Json::array();
    for (const ClipDifference& one : frame.differences) {
      Json json{{"kind", kind_name(one.kind)}};
      if (one.team) {
        json["team"] = name_of(*one.team);
        json["id"] = one.id_after >= 0 ? one.id_after : one.id_before;
        if (one.kind == ClipDifference::Kind::kIdChanged) json["id_before"] = one.id_before;
      }
      json.update({{"x", one.x_mm}, {"y", one.y_mm}});
      if (one.kind == ClipDifference::Kind::kMoved || one.kind == ClipDifference::Kind::kIdChanged)
        json.update({{"moved_mm", one.moved_mm}, {"turned_deg", one.turned_deg}});
      what.push_back(std::move(json));
    }
    differences.push_back(
        {{"frame", frame.number}, {"t_capture", frame.t_capture_s}, {"what", std::move(what)}});
  }
  return {{"frames", comparison.frames()},
          {"frames_with_other_bytes", comparison.frames_with_other_bytes()},
          {"frames_that_differ", comparison.frames_that_differ()},
          {"robots", counts_json(comparison.robots())},
          {"balls", counts_json(comparison.balls())},
          {"differences", std::move(differences)}};
}

}  // namespace sslv
