// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace sslv {

/// Files that belong to a change of settings: both are saved, or none.
class SavedWith {
 public:
  virtual ~SavedWith() = default;
  /// Before the settings are saved: whatever happens in between, what is replaced is on disk. Where it throws
  /// StorageError, all is as it was.
  virtual void save() = 0;
  /// The settings could not be saved after all.
  virtual void take_back() noexcept = 0;
};

}  // namespace sslv
