// SPDX-License-Identifier: Apache-2.0
#include "services/status/history_keeper.h"

#include "base/background.h"
#include "base/clock.h"
#include "base/log.h"
#include "config/version.h"
#include "settings/state_folder.h"

#include <exception>
#include <system_error>
#include <utility>

#include <fmt/format.h>

namespace sslv {
namespace {

/// Larger than any history: a larger file is not a history.
constexpr std::uintmax_t kMaxFileBytes = 4 * 1024 * 1024;
constexpr int kFileVersion = 1;

EventHistory::Now history_now() {
  return {unix_time_s(), steady_s()};
}

}  // namespace

HistoryKeeper::HistoryKeeper(const std::filesystem::path& state_folder) : file_(state_folder / kFileName) {
  load();
  thread_ = std::jthread([this](const std::stop_token& stop) {
    become_background_thread("history");
    keep_saving(stop);
  });
}

HistoryKeeper::~HistoryKeeper() {
  thread_.request_stop();
  thread_.join();
  if (!has_started_) return;
  history_.end_all(history_now());
  history_.add({"service_stopped", "The service stopped"}, history_now());
  save(true);
}

void HistoryKeeper::load() {
  remove_leftover(file_);
  std::error_code missing;
  const auto size = std::filesystem::file_size(file_, missing);
  if (!missing || missing != std::errc::no_such_file_or_directory) {
    try {
      if (!missing && size > kMaxFileBytes) throw SettingsError(fmt::format("{}: too large", file_.string()));
      const Json saved = read_json_file(file_);
      if (!saved.is_object() || !saved.contains("entries") || !saved.at("entries").is_array() ||
          !saved.contains("version") || saved.at("version") != kFileVersion)
        throw SettingsError(fmt::format("{}: no history of this version", file_.string()));
      history_.load(saved.at("entries"), history_now());
      is_first_ = false;
      ended_well_ = saved.contains("ended") && saved.at("ended") == true;
    } catch (const std::exception& error) {
      log::warning("the history of alerts starts empty: {}", error.what());
    }
  }
}

void HistoryKeeper::begin(EventHistory::Now now) {
  const bool is_crash = !is_first_ && !ended_well_;
  std::string title = fmt::format("The service started, version {}", kVersion);
  if (is_crash) title += "; the previous run ended without a stop";
  history_.add({is_crash ? "service_restarted" : "service_started", std::move(title)}, now);
  has_started_ = true;
}

bool HistoryKeeper::has_started() const {
  const std::lock_guard lock(mutex_);
  return has_started_;
}

void HistoryKeeper::look(const std::vector<Alert>& alerts, const std::vector<Event>& events) {
  const EventHistory::Now now = history_now();
  {
    const std::lock_guard lock(mutex_);
    if (!has_started_) begin(now);
    history_.look(alerts, now);
    for (const Event& event : events) history_.add(event, now);
  }
  changed_.notify_one();
}

Json HistoryKeeper::to_json() const {
  const std::lock_guard lock(mutex_);
  return {{"kept_s", EventHistory::kKept_s},
          {"max_entries", EventHistory::kMaxEntries},
          {"save_problem", problem_},
          {"entries", history_.entries_json()}};
}

bool HistoryKeeper::is_due(double now_s) const {
  const double since_s = now_s - saved_s_;
  if (!problem_.empty() && since_s < kAfterFailure_s) return false;
  if (history_.changes() != saved_changes_) return since_s >= kLeast_s;
  return history_.any_open() && since_s >= kWhileOpen_s;
}

void HistoryKeeper::keep_saving(const std::stop_token& stop) {
  for (;;) {
    {
      std::unique_lock lock(mutex_);
      // look() wakes this thread once a second, even if there is nothing new.
      changed_.wait(lock, stop, [this] { return has_started_ && is_due(steady_s()); });
    }
    if (stop.stop_requested()) return;
    save(false);
  }
}

void HistoryKeeper::save(bool ended) {
  std::uint64_t changes = 0;
  Json saved{{"version", kFileVersion}};
  {
    const std::lock_guard lock(mutex_);
    changes = history_.changes();
    saved["ended"] = ended;
    saved["entries"] = history_.to_saved();
  }
  std::string problem;
  try {
    write_file_durably(file_, json_text(saved) + "\n");
  } catch (const std::exception& error) {
    problem = error.what();
  }
  const std::lock_guard lock(mutex_);
  if (problem.empty() != problem_.empty()) {
    problem.empty() ? log::info("the history of alerts is saved again")
                    : log::warning("the history of alerts is not saved: {}", problem);
  }
  if (problem.empty()) saved_changes_ = changes;
  problem_ = std::move(problem);
  saved_s_ = steady_s();
}

}  // namespace sslv
