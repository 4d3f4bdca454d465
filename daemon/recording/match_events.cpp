// SPDX-License-Identifier: Apache-2.0
#include "recording/match_events.h"

#include "base/error.h"
#include "base/plain_text.h"
#include "net/parse.h"
#include "ssl_gc_referee_message.pb.h"
#include "ssl_vision_wrapper_tracked.pb.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <fmt/format.h>

namespace sslv {
namespace {

struct KindName {
  MatchEvent::Kind kind;
  const char* name;
};
constexpr KindName kKinds[] = {{MatchEvent::Kind::kCommand, "command"},
                               {MatchEvent::Kind::kStage, "stage"},
                               {MatchEvent::Kind::kGoal, "goal"},
                               {MatchEvent::Kind::kKick, "kick"}};

constexpr std::int64_t kForgottenAfter_ns = 5'000'000'000;
constexpr double kSameKick_s = 0.05;  // trackers may estimate the start of the same kick again

// Indexed by the numbers of the game controller's Command and Stage.
constexpr const char* kCommands[] = {"Halt",
                                     "Stop",
                                     "Normal start",
                                     "Force start",
                                     "Kick-off, yellow",
                                     "Kick-off, blue",
                                     "Penalty kick, yellow",
                                     "Penalty kick, blue",
                                     "Free kick, yellow",
                                     "Free kick, blue",
                                     "Indirect free kick, yellow",
                                     "Indirect free kick, blue",
                                     "Timeout, yellow",
                                     "Timeout, blue",
                                     "Goal, yellow",
                                     "Goal, blue",
                                     "Ball placement, yellow",
                                     "Ball placement, blue"};
constexpr const char* kStages[] = {"Before the first half",
                                   "First half",
                                   "Half time",
                                   "Before the second half",
                                   "Second half",
                                   "Break before extra time",
                                   "Before the first extra half",
                                   "First extra half",
                                   "Half time of extra time",
                                   "Before the second extra half",
                                   "Second extra half",
                                   "Break before the shoot-out",
                                   "Shoot-out",
                                   "Match over"};

template <std::size_t n>
std::string word(const char* const (&words)[n], const char* what, int number) {
  if (number >= 0 && number < static_cast<int>(n)) return words[number];
  return fmt::format("{} {}", what, number);
}

}  // namespace

std::string command_text(int command) {
  return word(kCommands, "Command", command);
}

std::string stage_text(int stage) {
  return word(kStages, "Stage", stage);
}

const char* name_of(MatchEvent::Kind kind) {
  return std::ranges::find(kKinds, kind, &KindName::kind)->name;
}

MatchEvent::Kind event_kind(std::string_view name) {
  const auto* found = std::ranges::find_if(kKinds, [&](const KindName& one) { return one.name == name; });
  if (found == std::end(kKinds))
    throw std::invalid_argument(fmt::format("no kind of event is named {}", name));
  return found->kind;
}

bool MatchEventFinder::Followed::follows(const std::string& from, std::int64_t now_ns) {
  if (heard_ns && from != source && now_ns - *heard_ns < kForgottenAfter_ns) return false;
  source = from;
  heard_ns = now_ns;
  return true;
}

void MatchEventFinder::add(const LoggedMessage& message, std::vector<MatchEvent>& out) {
  if (out.size() >= kMaxEvents || message.bytes.size() > kMaxDatagramInLog) return;
  if (message.type == LoggedMessage::kReferee) add_referee(message, out);
  if (message.type == LoggedMessage::kTracker2020) add_tracked(message, out);
}

void MatchEventFinder::add_referee(const LoggedMessage& message, std::vector<MatchEvent>& out) {
  Referee referee;
  if (!parse(referee, message.bytes)) return;
  if (!referee_.follows(referee.source_identifier(), message.time_ns)) return;
  const auto tell = [&](MatchEvent::Kind kind, std::string text) {
    out.push_back({message.time_ns, kind, std::move(text)});
  };
  if (referee.has_stage() && stage_ != referee.stage()) {
    stage_ = referee.stage();
    tell(MatchEvent::Kind::kStage, stage_text(*stage_));
  }
  if (referee.has_command() && command_ != referee.command()) {
    command_ = referee.command();
    tell(MatchEvent::Kind::kCommand, command_text(*command_));
  }
  if (!referee.has_yellow() || !referee.has_blue()) return;
  const std::array<std::uint32_t, 2> score{referee.yellow().score(), referee.blue().score()};
  for (const std::size_t team : {0U, 1U}) {
    if (!score_ || score[team] <= (*score_)[team]) continue;
    // Any program can send to the group, so the name may contain any bytes.
    const std::string name =
        shortened(plain_part(team == 0 ? referee.yellow().name() : referee.blue().name()), kMaxTeamNameBytes);
    tell(MatchEvent::Kind::kGoal,
         fmt::format("Goal for {}: {} : {}", name.empty() ? (team == 0 ? "yellow" : "blue") : name, score[0],
                     score[1]));
  }
  score_ = score;
}

void MatchEventFinder::add_tracked(const LoggedMessage& message, std::vector<MatchEvent>& out) {
  TrackerWrapperPacket packet;
  if (!parse(packet, message.bytes) || !tracker_.follows(packet.uuid(), message.time_ns)) return;
  if (!packet.tracked_frame().has_kicked_ball()) return;
  const KickedBall& kick = packet.tracked_frame().kicked_ball();
  const double speed_m_s = std::hypot(kick.vel().x(), kick.vel().y(), kick.vel().z());
  const double late_s = packet.tracked_frame().timestamp() - kick.start_timestamp();
  if (!std::isfinite(speed_m_s) || !std::isfinite(late_s)) return;
  if (std::abs(kick.start_timestamp() - kick_s_) < kSameKick_s) return;
  kick_s_ = kick.start_timestamp();
  // Trackers report a kick late, with times by their own clock, so subtract this delay (late_s) from the
  // message's log time.
  const double before_s = std::clamp(late_s, 0.0, 2.0);
  std::string who;
  if (kick.has_robot_id())
    who =
        fmt::format(" by {} {}", kick.robot_id().team() == YELLOW ? "yellow" : "blue", kick.robot_id().id());
  const std::int64_t time_ns = message.time_ns - static_cast<std::int64_t>(before_s * 1e9);
  out.push_back({std::max<std::int64_t>(0, time_ns), MatchEvent::Kind::kKick,
                 fmt::format("Kick{}, {:.1f} m/s", who, speed_m_s)});
}

}  // namespace sslv
