// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/kept_files.h"
#include "base/snapshot.h"
#include "clips/clip.h"
#include "clips/clip_writer.h"
#include "config/config.h"
#include "net/referee_listener.h"
#include "services/recording/clip_camera.h"
#include "services/recording/last_seconds.h"
#include "services/recording/left_rings.h"
#include "services/recording/recording_files.h"
#include "services/service.h"

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

namespace sslv {

/// Keeps the cameras' last seconds in memory, and writes clips of them: when somebody asks, at alerts, goals
/// and commands if the settings say so, and after a crash of what the run before left. A thread of low
/// priority writes them; cameras wait for nothing.
class ClipService final : public Service {
 public:
  /// `left`: what the service manager kept of the run before, if that crashed. The others must outlive this.
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
  /// A clip that is to be written.
  struct Order {
    std::string name;       // part of the file's name
    std::string why;        // for people
    std::string who{};      // the client's address; empty: nobody
    double begin_s, end_s;  // on the steady clock
  };
  /// How the newest clip stands.
  struct Clip {
    std::string file{};
    std::string why{};
    std::uint64_t bytes = 0, frames = 0, missing = 0;
    std::string problem{};  // why it could not be written
    double problem_s = 0;   // when that was, on the steady clock
  };
  /// One camera of the clip that is written.
  struct Source {
    LastSeconds::Ring from;
    ClipCamera camera;
    std::uint64_t dropped_before = 0;
    std::optional<std::uint64_t> dropped_at_end{};  // when the clip's time was over
  };

  void work(const std::stop_token& stop);
  void write_left(std::vector<KeptFile> files, const std::stop_token& stop);
  std::string write_crash_clip(LeftRings& left, const std::stop_token& stop);
  std::vector<RecordingFile> crash_clips() const;
  bool had_crash_clip() const;
  void keep_few_crash_clips();
  std::optional<Order> next_order(const std::stop_token& stop);
  void look_at_game();
  /// False: one is being written or waits already.
  bool put(Order order);
  void order_for_event(bool is_wanted, const std::string& kind, const std::string& text);
  void note_event(const std::string& kind, const std::string& text);
  void write(Order order, const std::stop_token& stop);
  void write_frames(const Order& order, ClipWriter& writer, std::vector<Source>& sources,
                    const std::stop_token& stop);
  static void note_end(const Order& order, std::vector<Source>& sources);
  bool write_next(ClipWriter& writer, std::vector<Source>& sources);
  void finish(const Order& order, ClipWriter& writer, std::vector<Source>& sources);

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
  mutable std::mutex mutex_;  // guards those up to `ordered_`
  std::optional<Order> order_;
  bool is_writing_ = false;
  Clip clip_;
  std::string crash_;             // that the service crashed, and which clip shows it; empty: it did not
  double crash_s_ = 0;            // when that was known, on the steady clock
  std::deque<ClipEvent> recent_;  // what happened lately, for clips
  std::set<std::string> alerts_;  // that are there
  std::map<std::string, double>
      clipped_;  // kind of alert -> when a clip was made for it, on the steady clock
  std::condition_variable_any ordered_;
  // The thread's own.
  std::optional<MatchState> match_;
  std::vector<KeptFile> left_;
  std::jthread thread_;  // last: it uses the others
};

}  // namespace sslv
