// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/error.h"
#include "base/json.h"
#include "base/snapshot.h"
#include "settings/history.h"
#include "settings/migrations.h"
#include "settings/plan.h"
#include "settings/state_folder.h"

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace sslv {

struct Config;

/// A tree with its defaults filled in, and what was read from it, once.
struct CheckedSettings {
  Json tree;
  std::shared_ptr<const Config> config{};
};

/// An edit that was made on a revision which is no longer the newest.
struct StaleRevision : std::runtime_error {
  StaleRevision(const std::string& text, std::uint64_t newest, Json steps)
      : runtime_error(text), revision(newest), changed_since(std::move(steps)) {}
  std::uint64_t revision;
  Json changed_since;  // the steps after the edit's revision, newest first
};

/// Who changes settings, and how.
struct SettingsEdit {
  std::string who;
  std::optional<std::uint64_t> if_revision{};  // refused unless this is the newest
  std::string what{};                          // that the change is part of: "calibration", say
  bool joins = false;  // one of many small ones that are one step of the history: see SettingsHistory::join
};

/// The one owner of the settings tree. The admin's file is never written; what the panel changes is kept
/// beside it, in the state folder, as a JSON Patch (RFC 6902) on that file's tree, so that a later edit of
/// either is kept; with the tree it was made on, so that it can be brought to a newer version of the settings
/// and is not put onto a file whose cameras are others.
class SettingsStore {
 public:
  struct Version {
    std::uint64_t revision;
    Json settings;                           // complete: defaults filled in
    std::shared_ptr<const Config> config{};  // read from them
    /// Of the answer to a change: what devices did not take of it, a line for each.
    std::vector<std::string> refused{};
  };
  /// Checks a tree and fills in its defaults; throws SettingsError.
  using Check = std::function<CheckedSettings(const Json&)>;
  /// Gets ready what new settings need, without any effect; what it returns carries them out, and does not
  /// throw. Throws SettingsError.
  using GetReady = std::function<Apply(const CheckedSettings&)>;

  /// Throws SettingsError, beginning with the file's name, when the admin's file is not usable. Saved changes
  /// that cannot be used are set aside (renamed *.rejected) and the last good ones, then none, are taken:
  /// `problem()` says so.
  SettingsStore(std::filesystem::path admin_file, StateFolder& folder, Check check,
                Migrations migrations = {});

  Version current() const;
  /// Without waiting for a change that is being saved.
  std::uint64_t revision() const { return revision_; }

  /// Makes a change by a JSON Patch: checked, got ready, saved with its place in the history, then applied.
  /// Throws StaleRevision when `if_revision` is given and is not the newest, SettingsError when the result is
  /// not allowed, StorageError when it cannot be saved; in each case nothing has changed.
  Version patch(const Json& patch, const SettingsEdit& edit, const GetReady& get_ready);

  /// What patch() would change. `plan` throws SettingsError when the result would be refused.
  Json check(const Json& patch, const std::function<void(const CheckedSettings&)>& plan) const;

  /// Takes one step of the history back, whatever came after it, and leaves what came after as it is. Throws
  /// SettingsError when there is no such step, StaleRevision when what it changed was changed again, and what
  /// patch() throws.
  Version undo(std::uint64_t revision, const SettingsEdit& edit, const GetReady& get_ready);

  /// Takes this tree for all settings, with a history (newest first) in the place of this one; `revision`:
  /// that they were at. Is one step on top of that history. Throws what patch() throws, and SettingsError for
  /// what is no history.
  Version restore(const Json& tree, std::uint64_t revision, const Json& history, const SettingsEdit& edit,
                  const GetReady& get_ready);

  /// Reads the admin's file again; what the panel changed stays on top. A step of the history, unless the
  /// result is in effect already. Throws SettingsError, beginning with the file's name, when it cannot
  /// be used or those changes do not fit it any more, StorageError when it cannot be saved; in each case
  /// nothing has changed but `reload_problem()`.
  Version reload(const GetReady& get_ready);

  /// Steps, newest first: see SettingsStep.
  Json history() const;

  /// What went wrong with the saved changes at start; empty when nothing did.
  const std::string& problem() const { return problem_; }
  /// Why the last reload() changed nothing; empty when it was good, or there was none. Does not wait for one
  /// under way.
  std::string reload_problem() const { return *reload_problem_.load(); }

 private:
  /// A changed tree; one that says its version (a whole file that was imported) is brought up to date.
  CheckedSettings checked(Json tree) const;
  CheckedSettings read_admin_file(Json* as_written = nullptr) const;
  std::optional<Version> load_changes(const std::filesystem::path& file, const Json& admin_as_written);
  Version reload_now(const GetReady& get_ready);
  /// Throws StaleRevision.
  void check_revision(const SettingsEdit& edit) const;
  /// What a step changed of cameras it changed of these that stand there now: the list is another one once
  /// one of them is added or removed.
  bool are_same_cameras(const SettingsStep& step) const;
  Version change(Json tree, const SettingsEdit& edit, const GetReady& get_ready);
  /// On top of this history, as a revision after `revision`.
  Version change(Json tree, SettingsHistory history, std::uint64_t revision, const SettingsEdit& edit,
                 const GetReady& get_ready);
  void take(Version version, SettingsHistory history) noexcept;
  /// As changes of this admin's tree.
  void save(const Version& version, const Json& admin_settings, const SettingsHistory& history);
  std::filesystem::path changes_file() const { return folder_.path() / "settings.json"; }
  std::filesystem::path previous_file() const { return folder_.path() / "settings.previous.json"; }

  const std::filesystem::path admin_file_;
  StateFolder& folder_;
  const Check check_;
  const Migrations migrations_;
  std::string problem_;
  Snapshot<std::string> reload_problem_{""};

  std::atomic<std::uint64_t> revision_{0};  // version_'s
  std::mutex edits_;                        // held during a whole edit: one at a time
  Json admin_settings_;                     // complete; only edits read and write it
  mutable std::mutex mutex_;  // guards what follows, which only edits write; never held for long
  Version version_;
  SettingsHistory history_;
};

}  // namespace sslv
