// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"
#include "settings/store.h"

namespace sslv {

/// A file that belongs to a change of settings: both are saved, or none.
class SavedWith {
 public:
  virtual ~SavedWith() = default;
  /// Before the settings are saved: whatever happens in between, what is replaced is on disk. Throws
  /// StorageError.
  virtual void save() = 0;
  /// The settings could not be saved after all.
  virtual void take_back() noexcept = 0;
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
};

}  // namespace sslv
