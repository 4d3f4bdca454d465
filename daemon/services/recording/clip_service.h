// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/kept_files.h"
#include "base/snapshot.h"
#include "clips/clip.h"
#include "config/config.h"
#include "net/referee_listener.h"
#include "services/recording/clip_maker.h"
#include "services/recording/last_seconds.h"
#include "services/recording/recording_files.h"
#include "services/service.h"

#include <condition_variable>
#include <deque>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

namespace sslv {

/// Keeps the cameras' last seconds in memory and writes clips: on request, for alerts, goals and commands if
/// the settings say so, and after a crash, from the memory of the previous run. A thread of low priority
/// writes the clips and never blocks cameras.
class ClipService final : public Service {
 public:
  /// `left`: memory that the service manager kept from the previous run, if that run crashed. All other
  /// arguments must outlive this.
  ClipService(const Snapshot<Config>& config, RecordingFiles& files, Cameras& cameras,
              const RefereeListener& referee, std::vector<KeptFile> left);

  // Service
  void ask_to_stop() override { thread_.request_stop(); }
  std::vector<Route> routes() override;
  void report(HealthReport& report) const override;
  void write_metrics(MetricsText& out) const override;
  std::optional<SupportRecording> support_clip(const std::string& name) const override;
  void see_alerts(const std::vector<Alert>& alerts) override;
  std::vector<Event> take_events() override { return events_.take(); }

 private:
  void work(const std::stop_token& stop);
  void write_left(std::vector<KeptFile> files, const std::stop_token& stop);
  std::string write_crash_clip(const LastSeconds::Left& left, const std::stop_token& stop);
  std::vector<RecordingFile> crash_clips(const std::stop_token& stop) const;
  std::optional<ClipOrder> next_order(const std::stop_token& stop);
  void look_at_game();
  /// Queues a clip. Returns false if a clip is being written or queued already.
  bool put(ClipOrder order);
  void order_for_event(bool is_wanted, const std::string& kind, const std::string& text);
  void note_event(const std::string& kind, const std::string& text);
  void write(const ClipOrder& order, const std::stop_token& stop);
  std::string last_event(double seconds) const;
  std::vector<ClipEvent> happened_in(const ClipOrder& order) const;

  Json to_json() const;
  Response make_clip(const Request& request);
  Response change_clip(const Request& request);
  Response remove_clip(const Request& request);
  Response get_clip(const Request& request) const;
  RecordingFile find(const Request& request) const;

  const Snapshot<Config>& config_;
  RecordingFiles& files_;
  const RefereeListener& referee_;
  LastSeconds last_seconds_;
  EventQueue events_;
  ClipMaker maker_;
  mutable std::mutex mutex_;  // guards the members up to `ordered_`
  std::optional<ClipOrder> order_;
  bool is_writing_ = false;
  ClipProgress clip_;             // the newest clip
  double problem_s_ = 0;          // when the newest clip failed, on the steady clock
  std::string crash_;             // message about a crash and its clip; empty: no crash
  double crash_s_ = 0;            // when crash_ was set, on the steady clock
  std::deque<ClipEvent> recent_;  // recent events, for clips
  ClipEvent trouble_{};           // the newest alert that is not only information
  std::set<std::string> alerts_;  // keys of the active alerts
  std::map<std::string, double>
      clipped_;  // alert id -> when a clip was last made for it, on the steady clock
  std::condition_variable_any ordered_;
  // Used by the thread only:
  std::optional<MatchState> match_;
  std::vector<KeptFile> left_;
  std::jthread thread_;  // last: the thread uses the members above
};

}  // namespace sslv
