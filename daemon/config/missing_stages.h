// SPDX-License-Identifier: Apache-2.0
#pragma once

// Stages named in the settings whose library is missing.

#include "config/config.h"

#include <string>

namespace sslv {

/// For example "without the stage 'tags', which is not installed; 'aim' depends on a stage that does not run,
/// and does not run either". Empty if all stages run.
std::string missing_text(const RunningStack& running);

/// Instructions for an admin, with the libraries that were left out and the reason for each.
std::string missing_fix(const RunningStack& running);

/// Throws SettingsError if `next` has a stage, in a stack or with parameters, that is missing or refuses its
/// parameters, unless `now` already has the same stage or parameters. So saved settings may contain stages
/// that cannot run, but settings from the network cannot add any.
void refuse_new_missing(const Config& now, const Config& next);

}  // namespace sslv
