// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <stdexcept>

namespace sslv {

/// A setting that cannot be used. The text is one line for the admin: where (file, JSON pointer of the key),
/// the value, and what is allowed. At start it ends the program with exit code 78 (EX_CONFIG); at run time
/// the change is refused and the old settings stay in force.
struct SettingsError : std::runtime_error {
  using runtime_error::runtime_error;
};

/// What a setting asks for is not to be had now, but may be in a moment: a port that another program holds.
/// One line for the admin, as above. At start it ends the program with exit code 75 (EX_TEMPFAIL), and the
/// service manager tries again.
struct BusyError : SettingsError {
  using SettingsError::SettingsError;
};

/// A file that cannot be written or read; one line.
struct StorageError : std::runtime_error {
  using runtime_error::runtime_error;
};

}  // namespace sslv
