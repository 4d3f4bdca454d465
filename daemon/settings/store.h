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

/// A settings tree with its defaults filled in, and the Config read from it, so that the tree is read once.
struct CheckedSettings {
  Json tree;
  std::shared_ptr<const Config> config{};
};

/// An edit is based on a revision that is no longer the newest.
struct StaleRevision : std::runtime_error {
  StaleRevision(const std::string& text, std::uint64_t newest, Json steps)
      : runtime_error(text), revision(newest), changed_since(std::move(steps)) {}
  std::uint64_t revision;
  Json changed_since;  // the steps after the edit's revision, newest first
};

/// Origin and kind of a settings change.
struct SettingsEdit {
  std::string who;
  std::optional<std::uint64_t> if_revision{};  // refused unless this is the newest revision
  std::string what{};                          // operation that contains the change, such as "calibration"
  bool joins = false;  // one of many small edits that form one step of the history (SettingsHistory::join)
};

/// Owns the settings tree. The admin's file is never written. The panel's changes are stored in the state
/// folder as a JSON Patch (RFC 6902) on that file's tree, so that later edits of the file and of the panel
/// are both kept. The tree that the patch was made on is stored too, so that the patch can be migrated to a
/// newer settings version and is not applied to a file with other cameras.
class SettingsStore {
 public:
  struct Version {
    std::uint64_t revision;
    Json settings;                           // complete: defaults filled in
    std::shared_ptr<const Config> config{};  // read from `settings`
    /// Only in the answer to a change: a line for each setting that a device refused.
    std::vector<std::string> refused{};
  };
  /// Validates a tree and fills in its defaults; throws SettingsError.
  using Check = std::function<CheckedSettings(const Json&)>;
  /// Acquires the resources that new settings need, without any other effect. The returned Apply applies the
  /// settings and does not throw. Throws SettingsError.
  using GetReady = std::function<Apply(const CheckedSettings&)>;

  /// Throws SettingsError, beginning with the file's name, if the admin's file is not usable. Unusable saved
  /// changes are set aside (renamed *.rejected). The previous saved changes are then used or, if those are
  /// unusable too, no changes; problem() reports it.
  SettingsStore(std::filesystem::path admin_file, StateFolder& folder, Check check,
                Migrations migrations = {});

  Version current() const;
  /// Does not wait for a change that is being saved.
  std::uint64_t revision() const { return revision_; }

  /// Makes a change by a JSON Patch: validates, prepares, saves it with its step of the history, then applies
  /// it. An edit without `what` that changes nothing makes no step. Throws StaleRevision if `if_revision` is
  /// given and is not the newest, SettingsError if the result is not allowed, StorageError if it cannot be
  /// saved; in each case nothing has changed.
  Version patch(const Json& patch, const SettingsEdit& edit, const GetReady& get_ready);

  /// Returns the changes that patch() would make. `plan` throws SettingsError if the result would be refused.
  Json check(const Json& patch, const std::function<void(const CheckedSettings&)>& plan) const;

  /// Reverts one step of the history and keeps all later steps. Throws SettingsError if there is no such
  /// step, StaleRevision if the step's values were changed again. Also throws like patch().
  Version undo(std::uint64_t revision, const SettingsEdit& edit, const GetReady& get_ready);

  /// Replaces all settings by this tree and the history by `history` (newest first), then adds one step.
  /// `revision`: the revision of the restored settings. Throws like patch(), and SettingsError for an invalid
  /// history.
  Version restore(const Json& tree, std::uint64_t revision, const Json& history, const SettingsEdit& edit,
                  const GetReady& get_ready);

  /// Reloads the admin's file and applies the panel's changes to it again. Adds a step to the history unless
  /// the result is already in effect. Throws SettingsError, beginning with the file's name, if the file is
  /// not usable or the panel's changes no longer fit it, StorageError if the result cannot be saved; in each
  /// case only reload_problem() has changed.
  Version reload(const GetReady& get_ready);

  /// Steps, newest first: see SettingsStep.
  Json history() const;

  /// Problems with the saved changes at start; empty if there were none.
  const std::string& problem() const { return problem_; }
  /// Why the last reload() failed; empty if it succeeded or reload() was never called. Does not wait for a
  /// reload in progress.
  std::string reload_problem() const { return *reload_problem_.load(); }

 private:
  /// Validates a changed tree; a tree with a version (an imported whole file) is migrated first.
  CheckedSettings checked(Json tree) const;
  CheckedSettings read_admin_file(Json* as_written = nullptr) const;
  std::optional<Version> load_changes(const std::filesystem::path& file, const Json& admin_as_written);
  Version reload_now(const GetReady& get_ready);
  /// Throws StaleRevision.
  void check_revision(const SettingsEdit& edit) const;
  /// Whether the cameras that a step changed still have the same index: adding or removing a camera shifts
  /// the indices.
  bool are_same_cameras(const SettingsStep& step) const;
  Version change(Json tree, const SettingsEdit& edit, const GetReady& get_ready);
  /// The same, but adds its step to `history` and numbers it `revision` + 1.
  Version change(Json tree, SettingsHistory history, std::uint64_t revision, const SettingsEdit& edit,
                 const GetReady& get_ready);
  void take(Version version, SettingsHistory history) noexcept;
  /// Saves the settings as changes to the admin's tree.
  void save(const Version& version, const Json& admin_settings, const SettingsHistory& history);
  std::filesystem::path changes_file() const { return folder_.path() / "settings.json"; }
  std::filesystem::path previous_file() const { return folder_.path() / "settings.previous.json"; }

  const std::filesystem::path admin_file_;
  StateFolder& folder_;
  const Check check_;
  const Migrations migrations_;
  std::string problem_;
  Snapshot<std::string> reload_problem_{""};

  std::atomic<std::uint64_t> revision_{0};  // version_.revision, readable without the mutex
  std::mutex edits_;                        // held during a whole edit, so that only one runs at a time
  Json admin_settings_;                     // complete; only edits read and write it
  mutable std::mutex mutex_;  // guards the members below, which only edits write; never held for long
  Version version_;
  SettingsHistory history_;
};

}  // namespace sslv
