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

/// The history of alerts and events, with the file that preserves it across restarts. A separate thread
/// writes the file, so that a disk that hangs delays no other thread: within a few seconds after entries
/// begin or end, and once a minute while entries are open, to save their durations. Thread-safe.
class HistoryKeeper {
 public:
  static constexpr const char* kFileName = "events.json";
  /// Minimum times between two writes of the file.
  static constexpr double kLeast_s = 3, kWhileOpen_s = 60, kAfterFailure_s = 30;

  /// Reads the file; if it is not usable, logs that and starts with an empty history.
  explicit HistoryKeeper(const std::filesystem::path& state_folder);
  /// Ends all open alerts and saves, unless look() was never called.
  ~HistoryKeeper();

  /// Call it once a second with the current alerts and the events since the last call. The first call records
  /// the start of the service.
  void look(const std::vector<Alert>& alerts, const std::vector<Event>& events);

  bool has_started() const;
  /// Events of docs/openapi.json.
  Json to_json() const;

 private:
  void load();
  void begin(EventHistory::Now now);
  void keep_saving(const std::stop_token& stop);
  bool is_due(double now_s) const;
  /// `ended`: this is the last save of this run.
  void save(bool ended);

  const std::filesystem::path file_;
  mutable std::mutex mutex_;  // guards the members below; never held while waiting for the disk
  EventHistory history_;
  bool has_started_ = false;
  bool is_first_ = true;     // there was no history
  bool ended_well_ = false;  // the previous run ended normally
  std::string problem_;      // why the last save failed; empty: it did not
  std::uint64_t saved_changes_ = 0;
  double saved_s_ = 0;  // time of the last attempt, on the steady clock
  std::condition_variable_any changed_;
  std::jthread thread_;  // last: the thread uses all members above
};

}  // namespace sslv
