// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace sslv {

/// Files that belong to a change of settings: both are saved, or neither.
class SavedWith {
 public:
  virtual ~SavedWith() = default;
  /// Saves the files. Called before the settings are saved, so that no data that they replace is lost if the
  /// service is killed in between. If it throws StorageError, nothing has changed.
  virtual void save() = 0;
  /// Called if the settings could not be saved after all.
  virtual void take_back() noexcept = 0;
};

}  // namespace sslv
