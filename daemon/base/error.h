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

}  // namespace sslv
