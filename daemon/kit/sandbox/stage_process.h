// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

namespace sslv {

/// Call this first in main() of every program that runs stages in their own processes: such a process is the
/// same program started again. In such a process, this function loads the library, does its work and returns
/// the exit code. In any other process, it returns nothing.
std::optional<int> stage_process_main(int argc, char** argv);

}  // namespace sslv
