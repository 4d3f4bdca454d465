// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"
#include "services/saved_with.h"
#include "settings/store.h"

#include <cstdint>

namespace sslv {

/// All settings of another computer, or of an earlier day.
struct KeptSettings {
  Json tree;               // which may say its version
  std::uint64_t revision;  // that they were at
  Json history;            // its steps, as SettingsEditor::history() gives them
};

/// The settings as other services see them. May be used from any thread.
class SettingsEditor {
 public:
  virtual ~SettingsEditor() = default;
  virtual SettingsStore::Version current() const = 0;
  /// Steps, newest first: see SettingsStep.
  virtual Json history() const = 0;
  /// Applies a JSON Patch; saved and in effect when it returns. Throws SettingsError when the result is not
  /// allowed, HttpError 409 when `edit` was made for a revision that is no longer the newest, StorageError
  /// when it cannot be saved; in each case nothing has changed.
  virtual SettingsStore::Version patch(const Json& patch, const SettingsEdit& edit,
                                       SavedWith* with = nullptr) = 0;

  /// What a JSON Patch would change. Throws SettingsError where patch() would.
  virtual Json check(const Json& patch) = 0;
  /// Takes these for all settings, with their history in the place of this one: one step on top of it, which
  /// can be taken back. Throws as patch() does.
  virtual SettingsStore::Version restore(const KeptSettings& kept, const SettingsEdit& edit,
                                         SavedWith* with) = 0;
};

}  // namespace sslv
