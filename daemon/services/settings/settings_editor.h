// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"
#include "services/saved_with.h"
#include "settings/store.h"

#include <cstdint>

namespace sslv {

/// All settings of another computer, or of an earlier time.
struct KeptSettings {
  Json tree;               // may contain a version
  std::uint64_t revision;  // revision of the tree
  Json history;            // steps of the tree, as returned by SettingsEditor::history()
};

/// Interface of the settings for other services. Thread-safe.
class SettingsEditor {
 public:
  virtual ~SettingsEditor() = default;
  virtual SettingsStore::Version current() const = 0;
  /// Steps, newest first: see SettingsStep.
  virtual Json history() const = 0;
  /// Applies a JSON Patch; saved and in effect on return. Throws SettingsError if the result is not allowed,
  /// HttpError 409 if `edit` was made for a revision that is no longer the newest, StorageError if it cannot
  /// be saved; in each case nothing has changed.
  virtual SettingsStore::Version patch(const Json& patch, const SettingsEdit& edit,
                                       SavedWith* with = nullptr) = 0;

  /// Returns the changes that a JSON Patch would make. Throws SettingsError like patch().
  virtual Json check(const Json& patch) = 0;
  /// Replaces all settings and their history by `kept`, and adds one step, which can be undone. Throws like
  /// patch().
  virtual SettingsStore::Version restore(const KeptSettings& kept, const SettingsEdit& edit,
                                         SavedWith* with) = 0;
};

}  // namespace sslv
