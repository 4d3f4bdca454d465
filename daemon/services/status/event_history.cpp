// SPDX-License-Identifier: Apache-2.0
#include "services/status/event_history.h"

#include "base/error.h"
#include "base/plain_text.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <utility>

#include <fmt/format.h>

namespace sslv {
namespace {

/// A clock that is being adjusted changes by less than this from one second to the next.
constexpr double kShift_s = 0.1;
/// Changes of the clock by at least this much are shown to users.
constexpr double kClockWasSet_s = 2;

std::string kept_text(const std::string& text) {
  return shortened(escaped_text(text), EventHistory::kMaxTextBytes);
}

std::string in_words(double seconds) {
  const auto all = std::llround(std::abs(seconds));
  if (all < 60) return fmt::format("{} s", all);
  if (all < 3600) return fmt::format("{} min {} s", all / 60, all % 60);
  return fmt::format("{} h {} min", all / 3600, all % 3600 / 60);
}

Severity severity_of(const Json& name) {
  return name == "bad" ? Severity::kBad : name == "warn" ? Severity::kWarn : Severity::kInfo;
}

}  // namespace

bool EventHistory::is_about(const Entry& entry, const Alert& alert, const std::string& about) {
  return entry.is_alert && entry.id == alert.id && entry.camera == alert.camera && entry.about == about;
}

void EventHistory::look(const std::vector<Alert>& alerts, Now now) {
  notice_clock(now);
  for (const Alert& alert : alerts) {
    const std::string about = kept_text(alert.about);
    const auto found = std::find_if(entries_.rbegin(), entries_.rend(), [&](const Entry& entry) {
      return is_about(entry, alert, about) && entry.is_of_this_run &&
             (entry.is_open || now.steady_s - entry.seen_s < kSame_s);
    });
    if (found != entries_.rend()) {
      see(*found, alert, now);
    } else {
      begin({.is_alert = true,
             .id = alert.id,
             .title = kept_text(alert.title),
             .about = about,
             .severity = alert.severity,
             .camera = alert.camera,
             .is_open = true},
            now);
    }
  }
  for (Entry& entry : entries_) {
    if (!entry.is_open || now.steady_s - entry.seen_s < kGone_s) continue;
    entry.is_open = false;
    ++changes_;
  }
  prune(now);
}

void EventHistory::see(Entry& entry, const Alert& alert, Now now) {
  if (!entry.is_open) {
    entry.seconds = entry.duration_s();
    entry.came_s = now.steady_s;
    entry.is_open = true;
    ++entry.count;
    ++changes_;
  }
  entry.seen_s = now.steady_s;
  entry.end_s = now.unix_s;
  // Keeps the worst severity, with the newest title at that severity.
  if (alert.severity > entry.severity) return;
  if (alert.severity < entry.severity) ++changes_;
  entry.severity = alert.severity;
  entry.title = kept_text(alert.title);
}

void EventHistory::add(const Event& event, Now now) {
  notice_clock(now);
  const std::string title = kept_text(event.title), who = kept_text(event.who);
  bool is_newest = true;
  const auto found = std::find_if(entries_.rbegin(), entries_.rend(), [&](const Entry& entry) {
    if (entry.is_alert) return false;
    // Of entries of earlier runs, only the newest is continued, so that a service that crashes repeatedly
    // gets one entry.
    if (!std::exchange(is_newest, false) && !entry.is_of_this_run) return false;
    const double ago_s =
        entry.is_of_this_run ? now.steady_s - entry.seen_s : std::abs(now.unix_s - entry.end_s);
    return ago_s < kSame_s && entry.id == event.id && entry.title == title && entry.who == who &&
           entry.camera == event.camera;
  });
  if (found != entries_.rend()) {
    found->is_of_this_run = true;
    found->end_s = now.unix_s;
    found->seen_s = found->came_s = now.steady_s;
    ++found->count;
    ++changes_;
  } else {
    begin({.id = event.id, .title = title, .who = who, .camera = event.camera}, now);
  }
  prune(now);
}

void EventHistory::begin(Entry entry, Now now) {
  entry.seq = ++newest_seq_;
  entry.begin_s = entry.end_s = now.unix_s;
  entry.came_s = entry.seen_s = now.steady_s;
  entries_.push_back(std::move(entry));
  ++changes_;
}

void EventHistory::notice_clock(Now now) {
  const double ahead_s = now.unix_s - now.steady_s;
  const double set_by_s = ahead_s - std::exchange(ahead_s_, ahead_s).value_or(ahead_s);
  if (std::abs(set_by_s) < kShift_s) return;
  for (Entry& entry : entries_) {
    if (!entry.is_of_this_run) continue;  // its times were right, or cannot be known
    entry.begin_s += set_by_s;
    entry.end_s += set_by_s;
  }
  ++changes_;
  if (std::abs(set_by_s) < kClockWasSet_s) return;
  add({"clock_set", fmt::format("The computer's clock was set {} by {}", set_by_s > 0 ? "forward" : "back",
                                in_words(set_by_s))},
      now);
}

void EventHistory::prune(Now now) {
  const auto is_old = [&](const Entry& entry) {
    return !entry.is_open &&
           (entry.is_of_this_run ? now.steady_s - entry.seen_s : now.unix_s - entry.end_s) > kKept_s;
  };
  const std::size_t before = entries_.size();
  std::erase_if(entries_, is_old);
  while (entries_.size() > kMaxEntries) {
    // Drops the oldest ended entry; if all entries are open, the oldest entry.
    const auto ended =
        std::find_if(entries_.begin(), entries_.end(), [](const Entry& entry) { return !entry.is_open; });
    entries_.erase(ended == entries_.end() ? entries_.begin() : ended);
  }
  if (entries_.size() != before) ++changes_;
}

void EventHistory::end_all(Now now) {
  notice_clock(now);
  for (Entry& entry : entries_) {
    if (!entry.is_open) continue;
    entry.is_open = false;
    entry.ended_by = "the service ended";
    ++changes_;
  }
}

bool EventHistory::any_open() const {
  return std::any_of(entries_.begin(), entries_.end(), [](const Entry& entry) { return entry.is_open; });
}

Json EventHistory::to_json(const Entry& entry) {
  return {{"seq", entry.seq},
          {"kind", entry.is_alert ? "alert" : "event"},
          {"id", entry.id},
          {"severity", name_of(entry.severity)},
          {"title", entry.title},
          {"camera", entry.camera ? Json(*entry.camera) : Json(nullptr)},
          {"who", entry.who},
          {"begin", entry.begin_s},
          {"end", entry.is_open ? Json(nullptr) : Json(entry.end_s)},
          {"seconds", entry.duration_s()},
          {"count", entry.count},
          {"ended_by", entry.ended_by}};
}

Json EventHistory::entries_json() const {
  Json out = Json::array();
  for (auto entry = entries_.rbegin(); entry != entries_.rend(); ++entry) out.push_back(to_json(*entry));
  return out;
}

Json EventHistory::to_saved() const {
  Json out = Json::array();
  for (const Entry& entry : entries_) {
    Json one = to_json(entry);
    one["seen"] = entry.end_s;
    one["about"] = entry.about;
    out.push_back(std::move(one));
  }
  return out;
}

void EventHistory::load(const Json& saved, Now now) {
  if (!saved.is_array()) return;
  for (const Json& one : saved) {
    try {
      Entry entry{.is_alert = one.at("kind") == "alert",
                  .id = one.at("id").get<std::string>(),
                  .title = kept_text(one.at("title").get<std::string>()),
                  .who = kept_text(one.at("who").get<std::string>()),
                  .about = one.at("about").get<std::string>(),
                  .ended_by = one.at("ended_by").get<std::string>(),
                  .severity = severity_of(one.at("severity")),
                  .begin_s = one.at("begin").get<double>(),
                  .end_s = one.at("seen").get<double>(),
                  .seconds = one.at("seconds").get<double>(),
                  .count = one.at("count").get<int>(),
                  .is_of_this_run = false};
      if (one.at("camera").is_number_integer()) entry.camera = one.at("camera").get<int>();
      if (one.at("end").is_null()) entry.ended_by = "the service ended";
      entry.seq = ++newest_seq_;
      entries_.push_back(std::move(entry));
    } catch (const std::exception&) {  // not an entry
    }
  }
  prune(now);
}

}  // namespace sslv
