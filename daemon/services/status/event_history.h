// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"
#include "services/event.h"
#include "services/health_report.h"

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <vector>

namespace sslv {

/// Alerts and events of the last day, with their times, durations and titles. look() receives the current
/// alerts once a second; the caller provides the time. Uses no locks and no files.
class EventHistory {
 public:
  static constexpr double kKept_s = 24 * 3600;
  static constexpr std::size_t kMaxEntries = 500, kMaxTextBytes = 300;
  /// An alert ends after it has been inactive for this long.
  static constexpr double kGone_s = 5;
  /// An alert that returns this soon after its end continues its entry, whose count is incremented. The same
  /// holds for equal events.
  static constexpr double kSame_s = 60;

  /// The current time on two clocks: Unix time for display, and steady time for durations, which setting the
  /// system clock must not change.
  struct Now {
    double unix_s, steady_s;
  };

  /// Updates the entries from the current alerts. Also detects that the clock was set.
  void look(const std::vector<Alert>& alerts, Now now);
  void add(const Event& event, Now now);
  /// Ends all open alerts.
  void end_all(Now now);

  /// Entries as docs/openapi.json has them, newest first.
  Json entries_json() const;

  /// to_saved() returns the input for load(). load() skips everything that is not an entry. An alert that was
  /// open when saved ended at an unknown time: its end becomes the time of saving.
  Json to_saved() const;
  void load(const Json& saved, Now now);

  /// Increases when an entry begins, ends or becomes more severe, but not when an entry continues or its
  /// title changes.
  std::uint64_t changes() const { return changes_; }
  bool any_open() const;

 private:
  struct Entry {
    std::uint64_t seq = 0;
    bool is_alert = false;
    std::string id{}, title{}, who{}, about{}, ended_by{};
    Severity severity = Severity::kInfo;
    std::optional<int> camera{};
    double begin_s = 0, end_s = 0;  // Unix time
    double seconds = 0;             // duration before `came_s`
    int count = 1;                  // number of occurrences
    bool is_open = false;
    // On the steady clock, in this run:
    bool is_of_this_run = true;
    double came_s = 0, seen_s = 0;
    double duration_s() const { return seconds + (seen_s - came_s); }
  };

  static bool is_about(const Entry& entry, const Alert& alert, const std::string& about);
  static Json to_json(const Entry& entry);
  void notice_clock(Now now);
  void see(Entry& entry, const Alert& alert, Now now);
  void begin(Entry entry, Now now);
  void prune(Now now);

  std::deque<Entry> entries_;  // oldest first
  std::uint64_t newest_seq_ = 0, changes_ = 0;
  std::optional<double> ahead_s_;  // offset from steady to Unix time
};

}  // namespace sslv
