// SPDX-License-Identifier: Apache-2.0
#pragma once

// Stages of libraries that nobody has looked through: each runs in a process of its own, where it can harm
// neither the service nor its other stages. docs/stage-process.md says what that costs.

#include "kit/apart/supervisor.h"
#include "kit/stages.h"

#include <chrono>
#include <string>

namespace sslv {

/// The rows of a library, whose code never runs in this process: a process of its own describes them, and so
/// does one check their parameters. Their Steps run each in another one, which `supervisor` looks after; it
/// must outlive every call of create(). Every stage has one parameter more, "deadline_ms". For threads that
/// may wait; throws StageLibraryError when there are none or one of them cannot run this way.
///
/// The places of own parts are told as with other rows, through OwnPartUse::place; they are of this library.
StageRows rows_apart(const std::string& library, apart::Supervisor& supervisor,
                     std::chrono::milliseconds within = std::chrono::seconds(5));

}  // namespace sslv
