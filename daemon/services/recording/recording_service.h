// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/snapshot.h"
#include "config/config.h"
#include "net/referee_listener.h"
#include "services/recording/match_log_recorder.h"
#include "services/recording/match_rule.h"
#include "services/recording/recording_files.h"
#include "services/service.h"

#include <condition_variable>
#include <filesystem>
#include <functional>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

namespace sslv {

/// Records matches as logs in the league's format, started by the game controller or by hand, and keeps
/// recordings within their quota.
class RecordingService final : public Service {
 public:
  using IsOwn = std::function<bool(const boost::asio::ip::udp::endpoint& sender)>;

  /// All must outlive this. `is_own`: whether this service sends from that address; called from receiver
  /// threads.
  RecordingService(const Snapshot<Config>& config, RecordingFiles& files, const RefereeListener& referee,
                   IsOwn is_own, TracksForLog& tracks);

  // Service
  void ask_to_stop() override {
    keeper_.request_stop();
    thread_.request_stop();
  }
  std::vector<Route> routes() override;
  void report(HealthReport& report) const override;
  void write_metrics(MetricsText& out) const override;
  std::vector<Event> take_events() override { return events_.take(); }

 private:
  enum class StartedBy { kNobody, kGameController, kHand };
  struct Recording {
    StartedBy started_by = StartedBy::kNobody;  // nobody: nothing is recorded
    bool is_paused = false;
    int match = 0;  // MatchRule::number() when it began
    std::filesystem::path file{};
    std::string name() const { return file.filename().string(); }
    double begin_s = 0;
    std::string problem{};  // why the last log could not begin, or ended early
    double problem_s = 0;   // Unix time of `problem`
  };

  bool is_ours(std::int32_t type, const boost::asio::ip::udp::endpoint& sender) const;
  void look(const std::stop_token& stop);
  void follow_game_controller();
  void check_disk();
  // With control_mutex_ held:
  void begin(StartedBy by, const std::string& name);
  void end(const std::string& problem = {});
  /// Excludes the current match from recording, for this reason.
  void leave_match_out(const std::string& why);

  Recording recording() const;
  std::string left_out() const;
  void set_recording(const Recording& recording);
  Json to_json() const;
  Response put_match_log(const Request& request);
  Response change_log(const Request& request);
  Response remove_log(const Request& request);
  Response get_log(const Request& request) const;
  Response get_events(const Request& request) const;
  RecordingFile find(const Request& request) const;

  const Snapshot<Config>& config_;
  const RefereeListener& referee_;
  RecordingFiles& files_;
  const IsOwn is_own_;
  MatchLogRecorder recorder_;
  EventQueue events_;
  std::mutex control_mutex_;  // serializes starting and ending recordings, which may wait for the disk
  MatchRule rule_;
  mutable std::mutex mutex_;  // guards the members below
  Recording recording_;
  std::string no_room_problem_;   // why no log could begin; empty: a log can begin
  std::string quota_problem_;     // why recordings exceed their quota; empty: they do not
  std::string left_out_;          // why the current match is excluded; empty: it is not
  std::jthread keeper_, thread_;  // last: both threads use the members above
};

}  // namespace sslv
