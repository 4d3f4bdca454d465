// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

namespace sslv {

/// To be called first in main() of every program that runs stages in processes of their own: such a process
/// is the same program started again. There it loads the library, does its work, and returns the exit code;
/// nothing when this is no such process.
std::optional<int> stage_process_main(int argc, char** argv);

}  // namespace sslv
