// SPDX-License-Identifier: Apache-2.0
#include "recording/match_moment.h"

#include "base/error.h"
#include "base/plain_text.h"
#include "net/parse.h"
#include "recording/match_events.h"
#include "ssl_gc_referee_message.pb.h"
#include "ssl_vision_wrapper.pb.h"
#include "ssl_vision_wrapper_tracked.pb.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <string>
#include <utility>

namespace sslv {
namespace {

constexpr std::int64_t kNew_ns = 200'000'000, kNewReferee_ns = 2'000'000'000;
/// So far into a log its field must have been said; it is every few seconds.
constexpr std::int64_t kFieldWithin_ns = 30'000'000'000;
constexpr int kMostMessages = 100'000;
constexpr std::size_t kMaxNameBytes = 60;

double seconds_of(std::int64_t ns) {
  return static_cast<double>(ns) * 1e-9;
}

void refuse_when_stopped(const std::stop_token& stop) {
  if (stop.stop_requested()) throw StorageError("the service ends");
}

Json robot_json(const SSL_DetectionRobot& robot, const char* team) {
  return {{"team", team},
          {"id", robot.has_robot_id() ? Json(robot.robot_id()) : Json(nullptr)},
          {"x", robot.x()},
          {"y", robot.y()},
          {"orientation", robot.has_orientation() ? Json(robot.orientation()) : Json(nullptr)},
          {"height", robot.height()},
          {"confidence", robot.confidence()},
          {"pixel_x", robot.pixel_x()},
          {"pixel_y", robot.pixel_y()}};
}

Json detections_json_of(const SSL_DetectionFrame& frame) {
  Json robots = Json::array(), balls = Json::array();
  for (const SSL_DetectionRobot& robot : frame.robots_yellow()) robots.push_back(robot_json(robot, "yellow"));
  for (const SSL_DetectionRobot& robot : frame.robots_blue()) robots.push_back(robot_json(robot, "blue"));
  for (const SSL_DetectionBall& ball : frame.balls()) {
    balls.push_back({{"x", ball.x()},
                     {"y", ball.y()},
                     {"confidence", ball.confidence()},
                     {"area", ball.area()},
                     {"pixel_x", ball.pixel_x()},
                     {"pixel_y", ball.pixel_y()}});
  }
  return {{"robots", std::move(robots)}, {"balls", std::move(balls)}};
}

Json tracked_json(const TrackedFrame& frame) {
  constexpr double kMmPerM = 1000;
  Json robots = Json::array(), ball = nullptr;
  for (const TrackedRobot& robot : frame.robots()) {
    robots.push_back({{"team", robot.robot_id().team() == ::Team::BLUE ? "blue" : "yellow"},
                      {"id", robot.robot_id().id()},
                      {"x", robot.pos().x() * kMmPerM},
                      {"y", robot.pos().y() * kMmPerM},
                      {"orientation", robot.orientation()},
                      {"vx", robot.vel().x() * kMmPerM},
                      {"vy", robot.vel().y() * kMmPerM}});
  }
  if (frame.balls_size() > 0) {
    const TrackedBall& first = frame.balls(0);
    ball = {{"x", first.pos().x() * kMmPerM},
            {"y", first.pos().y() * kMmPerM},
            {"z", first.pos().z() * kMmPerM},
            {"vx", first.vel().x() * kMmPerM},
            {"vy", first.vel().y() * kMmPerM}};
  }
  return {{"robots", std::move(robots)}, {"ball", std::move(ball)}};
}

Json team_json(const Referee::TeamInfo& team) {
  return {{"name", shortened(escaped_text(team.name()), kMaxNameBytes)}, {"score", team.score()}};
}

Json referee_json(const Referee& referee) {
  return {{"stage", referee.has_stage() ? stage_text(referee.stage()) : ""},
          {"command", referee.has_command() ? command_text(referee.command()) : ""},
          {"yellow", team_json(referee.yellow())},
          {"blue", team_json(referee.blue())}};
}

bool is_vision(const LoggedMessage& message) {
  return message.type == LoggedMessage::kVision2014 || message.type == LoggedMessage::kVision2010;
}

}  // namespace

std::optional<Json> detections_json_of(std::span<const std::byte> packet) {
  SSL_WrapperPacket wrapper;
  if (!parse(wrapper, packet) || !wrapper.has_detection()) return std::nullopt;
  return detections_json_of(wrapper.detection());
}

MatchMoments::MatchMoments(const std::filesystem::path& log, std::shared_ptr<const MatchLogIndex> index)
    : index_(std::move(index)), reader_(log) {}

Json MatchMoments::field(const std::stop_token& stop) {
  if (field_) return *field_;
  Json field = nullptr;
  reader_.go_to_begin();
  LoggedMessage message;
  for (int i = 0; i < kMostMessages && reader_.next(message); ++i) {
    refuse_when_stopped(stop);
    if (message.time_ns > index_->first_ns + kFieldWithin_ns) break;
    SSL_WrapperPacket wrapper;
    if (!is_vision(message) || !parse(wrapper, message.bytes) || !wrapper.has_geometry()) continue;
    const auto& size = wrapper.geometry().field();
    field = {{"length", size.field_length()}, {"width", size.field_width()}};
    break;
  }
  return field_.emplace(std::move(field));
}

Json MatchMoments::at(double at_s, const std::stop_token& stop) {
  const double length_s = seconds_of(index_->last_ns - index_->first_ns);
  at_s = std::isfinite(at_s) ? std::clamp(at_s, 0.0, length_s) : 0;
  const std::int64_t now_ns = index_->first_ns + std::llround(at_s * 1e9);
  Json out{{"time_s", at_s},
           {"cameras", Json::array()},
           {"tracked", nullptr},
           {"referee", nullptr},
           {"field", field(stop)}};
  reader_.go_to(std::max(index_->first_ns, now_ns - kNewReferee_ns), *index_, stop);
  std::map<std::uint32_t, Json> cameras;
  LoggedMessage message;
  SSL_WrapperPacket vision;
  TrackerWrapperPacket tracker;
  Referee referee;
  std::string tracker_source;
  for (int i = 0; i < kMostMessages && reader_.next(message) && message.time_ns <= now_ns; ++i) {
    refuse_when_stopped(stop);
    const double time_s = seconds_of(message.time_ns - index_->first_ns);
    if (message.type == LoggedMessage::kReferee) {
      if (parse(referee, message.bytes)) out["referee"] = referee_json(referee);
      continue;
    }
    if (message.time_ns < now_ns - kNew_ns) continue;
    if (is_vision(message) && parse(vision, message.bytes) && vision.has_detection()) {
      Json& camera = cameras[vision.detection().camera_id()];
      camera = detections_json_of(vision.detection());
      camera["id"] = vision.detection().camera_id();
      camera["time_s"] = time_s;
    } else if (message.type == LoggedMessage::kTracker2020 && parse(tracker, message.bytes) &&
               tracker.has_tracked_frame()) {
      // Of several trackers the one that was heard first.
      if (out["tracked"].is_null()) tracker_source = tracker.uuid();
      if (tracker.uuid() == tracker_source) out["tracked"] = tracked_json(tracker.tracked_frame());
    }
  }
  for (auto& [id, camera] : cameras) out["cameras"].push_back(std::move(camera));
  return out;
}

}  // namespace sslv
