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

/// Alerts and events of the last day: when, how long, what. It looks at the alerts once a second, as they are
/// then; the caller says what time it is. No locks, no files.
class EventHistory {
 public:
  static constexpr double kKept_s = 24 * 3600;
  static constexpr std::size_t kMaxEntries = 500, kMaxTextBytes = 300;
  /// An alert that is gone for less is still the same; what is gone for longer has ended.
  static constexpr double kGone_s = 5;
  /// One that comes back so soon after its end goes on, and is counted, as do the same events.
  static constexpr double kSame_s = 60;

  /// Unix time, for people; durations come from the steady clock, so that setting the other changes none.
  struct Now {
    double unix_s, steady_s;
  };

  /// What is there now. Also notices that the clock was set.
  void look(const std::vector<Alert>& alerts, Now now);
  void add(const Event& event, Now now);
  /// Those that are there end now.
  void end_all(Now now);

  /// Entries as docs/openapi.json has them, newest first.
  Json entries_json() const;

  /// To be saved; and what load() takes. Whatever is no entry is left out. An alert that was there when it
  /// was saved has ended: nobody knows when, so at the time of saving.
  Json to_saved() const;
  void load(const Json& saved, Now now);

  /// Goes on with each entry that comes or ends; what only goes on, or says another figure, does not count.
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
    double seconds = 0;             // that it was there, before `came_s`
    int count = 1;                  // times that it came
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
  std::optional<double> ahead_s_;  // of the steady clock is the other
};

}  // namespace sslv
