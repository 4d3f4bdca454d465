// SPDX-License-Identifier: Apache-2.0
#pragma once

// Sandbox for stage libraries that nobody has reviewed: each stage runs in its own process, where it can harm
// neither the service nor other stages. docs/stage-process.md gives the cost.

#include "kit/sandbox/supervisor.h"
#include "kit/stages.h"

#include <chrono>
#include <string>

namespace sslv {

/// The rows of a library whose code never runs in this process: one child process describes the stages, other
/// child processes validate parameters, and each Step runs its stage in its own process under `supervisor`,
/// which must outlive every call of create(). Every stage has one additional parameter, "deadline_ms". May
/// block. Throws StageLibraryError if the library has no stages or if a stage cannot run in its own process.
///
/// As with other rows, OwnPartUse::place must be set for own parts; the places belong to this library.
StageRows sandboxed_rows(const std::string& library, sandbox::Supervisor& supervisor,
                         std::chrono::milliseconds within = std::chrono::seconds(5));

}  // namespace sslv
