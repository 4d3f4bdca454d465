// SPDX-License-Identifier: Apache-2.0
#include "recording/match_moment.h"

#include "base/background.h"
#include "base/error.h"
#include "base/plain_text.h"
#include "net/parse.h"
#include "recording/match_events.h"
#include "ssl_gc_referee_message.pb.h"
#include "ssl_vision_wrapper.pb.h"
#include "ssl_vision_wrapper_tracked.pb.h"

#include <algorithm>
#include <cmath>
#include <condition_variable>
#include <exception>
#include <map>
#include <mutex>
#include <ranges>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace sslv {
namespace {

constexpr std::int64_t kNew_ns = 200'000'000, kNewReferee_ns = 2'000'000'000;
/// The field is searched this far into a log; geometry is sent every few seconds.
constexpr std::int64_t kFieldWithin_ns = 30'000'000'000;
constexpr int kMaxMessages = 100'000;
/// Limits, since a log is untrusted: no field has more cameras, or more robots or balls.
constexpr std::size_t kMaxCameras = 64;
constexpr int kMaxThings = 256;
/// Seek points within gzip members: their largest number, and the fewest unpacked bytes between them.
constexpr std::uint64_t kMaxPlaces = 1024, kLeastBetweenPlaces = std::uint64_t{4} << 20U;

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

/// Calls use(one) for the first kMaxThings of a list.
template <class List, class Use>
void each_of_some(const List& list, const Use& use) {
  std::for_each(list.begin(), list.begin() + std::min(list.size(), kMaxThings), use);
}

Json detections_json_of(const SSL_DetectionFrame& frame) {
  Json robots = Json::array(), balls = Json::array();
  each_of_some(frame.robots_yellow(),
               [&](const auto& robot) { robots.push_back(robot_json(robot, "yellow")); });
  each_of_some(frame.robots_blue(), [&](const auto& robot) { robots.push_back(robot_json(robot, "blue")); });
  each_of_some(frame.balls(), [&](const SSL_DetectionBall& ball) {
    balls.push_back({{"x", ball.x()},
                     {"y", ball.y()},
                     {"confidence", ball.confidence()},
                     {"area", ball.area()},
                     {"pixel_x", ball.pixel_x()},
                     {"pixel_y", ball.pixel_y()}});
  });
  return {{"robots", std::move(robots)}, {"balls", std::move(balls)}};
}

Json tracked_json(const TrackedFrame& frame) {
  constexpr double kMmPerM = 1000;
  Json robots = Json::array(), ball = nullptr;
  each_of_some(frame.robots(), [&](const TrackedRobot& robot) {
    robots.push_back({{"team", robot.robot_id().team() == ::Team::BLUE ? "blue" : "yellow"},
                      {"id", robot.robot_id().id()},
                      {"x", robot.pos().x() * kMmPerM},
                      {"y", robot.pos().y() * kMmPerM},
                      {"orientation", robot.orientation()},
                      {"vx", robot.vel().x() * kMmPerM},
                      {"vy", robot.vel().y() * kMmPerM}});
  });
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
  return {{"name", shortened(escaped_text(team.name()), kMaxTeamNameBytes)}, {"score", team.score()}};
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

/// Largest distance between neighbouring points of an index, in unpacked bytes. The log's beginning and end
/// count as points.
std::uint64_t largest_gap_bytes(const MatchLogIndex& index) {
  std::uint64_t largest = 0, before = 0;
  for (const MatchLogPoint& point : index.points) {
    largest = std::max(largest, point.place.offset - before);
    before = point.place.offset;
  }
  return std::max(largest, index.unpacked_bytes - std::min(before, index.unpacked_bytes));
}

}  // namespace

std::optional<Json> detections_json_of(std::span<const std::byte> packet) {
  SSL_WrapperPacket wrapper;
  if (!parse(wrapper, packet) || !wrapper.has_detection()) return std::nullopt;
  return detections_json_of(wrapper.detection());
}

/// Places within the members of a packed log, found by a thread that reads the whole log once.
class MatchMoments::Places {
 public:
  Places(const std::filesystem::path& log, std::uint64_t every_bytes)
      : thread_([this, log, every_bytes](const std::stop_token& stop) {
          become_background_thread("log places", 15);
          try {
            find(log, every_bytes, stop);
          } catch (const std::exception&) {  // at() reports the same error, or has fewer places to start at
          }
          const std::lock_guard lock(mutex_);
          is_done_ = true;
          done_.notify_all();
        }) {}

  struct Place {
    MemberPlace at;
    std::uint64_t next_offset = 0;   // unpacked bytes before the first message after the place
    std::int64_t all_before_ns = 0;  // latest time of the messages before that message
  };
  /// Returns the last place with only earlier messages before it, or Place{} if no place is suitable.
  /// std::nullopt: the thread has not reached that time yet.
  std::optional<Place> before(std::int64_t time_ns) const {
    const std::lock_guard lock(mutex_);
    if (!is_done_ && time_ns >= read_ns_) return std::nullopt;
    const auto behind = std::ranges::partition_point(
        places_, [&](const Place& place) { return place.all_before_ns < time_ns; });
    return behind == places_.begin() ? Place{} : *(behind - 1);
  }
  void wait() const {
    std::unique_lock lock(mutex_);
    done_.wait(lock, [this] { return is_done_; });
  }

 private:
  void find(const std::filesystem::path& log, std::uint64_t every_bytes, const std::stop_token& stop) {
    MatchLogReader reader(log);
    reader.note_places(every_bytes);
    std::int64_t latest_ns = 0;
    for (LoggedMessage message; !stop.stop_requested() && reader.next(message);) {
      // Checked here too, since the index may have a wrong length of the log.
      if (reader.message_offset() > kMaxUnpackedBytes || places_.size() > kMaxPlaces) return;
      latest_ns = std::max(latest_ns, message.time_ns);
      for (MemberPlace& found : reader.take_places()) {
        const std::lock_guard lock(mutex_);
        places_.push_back({std::move(found), reader.next_offset(), latest_ns});
        read_ns_ = latest_ns;
      }
    }
  }

  mutable std::mutex mutex_;  // guards the members below
  mutable std::condition_variable done_;
  std::vector<Place> places_;
  std::int64_t read_ns_ = 0;  // time that the thread has reached
  bool is_done_ = false;
  std::jthread thread_;  // last: it uses the members above
};

MatchMoments::MatchMoments(const std::filesystem::path& log, std::shared_ptr<const MatchLogIndex> index,
                           std::uint64_t max_bytes)
    : index_(std::move(index)), max_bytes_(max_bytes), reader_(log) {
  if (largest_gap_bytes(*index_) <= max_bytes_ / 2) return;
  // Places are at most max_bytes_ / 2 apart, so that every message between them can be reached.
  const std::uint64_t every_bytes =
      std::min(std::max(index_->unpacked_bytes / kMaxPlaces, std::min(kLeastBetweenPlaces, max_bytes_ / 4)),
               max_bytes_ / 2);
  places_ = std::make_unique<Places>(log, every_bytes);
}

MatchMoments::~MatchMoments() = default;

void MatchMoments::wait() {
  if (places_) places_->wait();
}

/// False: the thread that finds places has not reached that time yet.
bool MatchMoments::go_to(std::int64_t time_ns, const std::stop_token& stop) {
  const auto behind = std::ranges::partition_point(
      index_->points, [&](const MatchLogPoint& point) { return point.all_before_ns < time_ns; });
  const std::uint64_t offset = behind == index_->points.begin() ? 0 : (behind - 1)->place.offset;
  const auto place = places_ ? places_->before(time_ns) : Places::Place{};
  if (!place) return false;
  if (place->next_offset > offset) {
    reader_.go_to(place->at, place->next_offset);
  } else if (offset > 0) {
    reader_.go_to((behind - 1)->place);
  } else {
    reader_.go_to_begin();
  }
  if (reader_.skip_to(time_ns, max_bytes_, stop)) return true;
  refuse_when_stopped(stop);
  throw StorageError("this time is too far from any place where reading the log can start");
}

Json MatchMoments::field(const std::stop_token& stop) {
  if (field_) return *field_;
  Json field = nullptr;
  reader_.go_to_begin();
  LoggedMessage message;
  for (int i = 0; i < kMaxMessages && reader_.next(message); ++i) {
    refuse_when_stopped(stop);
    if (message.time_ns > index_->first_ns + kFieldWithin_ns || reader_.next_offset() > max_bytes_) break;
    SSL_WrapperPacket wrapper;
    if (!is_vision(message) || message.bytes.size() > kMaxDatagramInLog || !parse(wrapper, message.bytes) ||
        !wrapper.has_geometry())
      continue;
    const auto& size = wrapper.geometry().field();
    field = {{"length", size.field_length()}, {"width", size.field_width()}};
    break;
  }
  return field_.emplace(std::move(field));
}

std::optional<Json> MatchMoments::at(double at_s, const std::stop_token& stop) {
  const double length_s = seconds_of(index_->last_ns - index_->first_ns);
  at_s = std::isfinite(at_s) ? std::clamp(at_s, 0.0, length_s) : 0;
  const std::int64_t now_ns = index_->first_ns + std::llround(at_s * 1e9);
  Json out{{"time_s", at_s},
           {"cameras", Json::array()},
           {"tracked", nullptr},
           {"referee", nullptr},
           {"field", field(stop)}};
  if (!go_to(std::max(index_->first_ns, now_ns - kNewReferee_ns), stop)) return std::nullopt;
  const std::uint64_t begin = reader_.next_offset();
  std::map<std::uint32_t, Json> cameras;
  LoggedMessage message;
  SSL_WrapperPacket vision;
  TrackerWrapperPacket tracker;
  Referee referee;
  std::string tracker_source;
  for (int i = 0; i < kMaxMessages && reader_.next(message) && message.time_ns <= now_ns; ++i) {
    refuse_when_stopped(stop);
    if (reader_.next_offset() - begin > max_bytes_) break;
    if (message.bytes.size() > kMaxDatagramInLog) continue;
    const double time_s = seconds_of(message.time_ns - index_->first_ns);
    if (message.type == LoggedMessage::kReferee) {
      if (parse(referee, message.bytes)) out["referee"] = referee_json(referee);
      continue;
    }
    if (message.time_ns < now_ns - kNew_ns) continue;
    if (is_vision(message) && parse(vision, message.bytes) && vision.has_detection()) {
      if (cameras.size() >= kMaxCameras && !cameras.contains(vision.detection().camera_id())) continue;
      Json& camera = cameras[vision.detection().camera_id()];
      camera = detections_json_of(vision.detection());
      camera["id"] = vision.detection().camera_id();
      camera["time_s"] = time_s;
    } else if (message.type == LoggedMessage::kTracker2020 && parse(tracker, message.bytes) &&
               tracker.has_tracked_frame()) {
      // Of several trackers, shows the one from which the events are; while it is silent, another one.
      const bool is_first = tracker_sum_of(tracker.uuid()) == index_->tracker_sum;
      if (!is_first && !out["tracked"].is_null() && tracker.uuid() != tracker_source) continue;
      tracker_source = tracker.uuid();
      out["tracked"] = tracked_json(tracker.tracked_frame());
    }
  }
  for (auto& [id, camera] : cameras) out["cameras"].push_back(std::move(camera));
  return out;
}

}  // namespace sslv
