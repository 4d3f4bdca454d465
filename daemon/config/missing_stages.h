// SPDX-License-Identifier: Apache-2.0
#pragma once

// Stages that settings name and that are not there, because their library is not.

#include "config/config.h"

#include <string>

namespace sslv {

/// "without the stage 'tags', which is not there; 'aim' needs what is missing and does not run either".
/// Empty: all are running.
std::string missing_text(const RunningStack& running);

/// What an admin can do about it; names the libraries that were left out, and why.
std::string missing_fix(const RunningStack& running);

/// Throws SettingsError for a stage of `next`, in a stack or with parameters, that is not there, unless `now`
/// has it already: what is saved stays, what comes from the network must run.
void refuse_new_missing(const Config& now, const Config& next);

}  // namespace sslv
