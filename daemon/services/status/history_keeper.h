// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"
#include "services/status/event_history.h"

#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <mutex>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

namespace sslv {

/// The history of alerts and events, with the file that keeps it over restarts. A thread of its own writes
/// it, so that a disk that hangs delays nobody: what comes or ends within a few seconds, durations of what
/// goes on once a minute. May be used from any thread.
class HistoryKeeper {
 public:
  static constexpr const char* kFileName = "events.json";
  /// Between two writes of the file.
  static constexpr double kLeast_s = 3, kWhileOpen_s = 60, kAfterFailure_s = 30;

  /// Reads the file; one that cannot be used is a line of the log and an empty history.
  explicit HistoryKeeper(const std::filesystem::path& state_folder);
  /// What is there ends with the service, and is saved; unless the service did not get as far as look().
  ~HistoryKeeper();

  /// Once a second: what is wrong now, and what was done since. The first time the service has started.
  void look(const std::vector<Alert>& alerts, const std::vector<Event>& events);

  bool has_started() const;
  /// docs/openapi.json's Events.
  Json to_json() const;

 private:
  void load();
  void begin(EventHistory::Now now);
  void keep_saving(const std::stop_token& stop);
  bool is_due(double now_s) const;
  /// `ended`: nothing comes after it.
  void save(bool ended);

  const std::filesystem::path file_;
  mutable std::mutex mutex_;  // guards the next ones; never held while the disk is waited for
  EventHistory history_;
  bool has_started_ = false;
  bool is_first_ = true;     // no history was there
  bool ended_well_ = false;  // the run before this one
  std::string problem_;      // why it was not saved
  std::uint64_t saved_changes_ = 0;
  double saved_s_ = 0;  // when that was tried last, on the steady clock
  std::condition_variable_any changed_;
  std::jthread thread_;  // last: it uses all the others
};

}  // namespace sslv
