// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

// Paths on this machine. Compiled into one file only: on every test's command line they would prevent clones
// from sharing the compiler cache.

namespace sslv {

/// A file of the repository; `below` begins with a slash.
std::string source_path(std::string_view below);

std::string daemon_program();
std::string ctl_program();
std::string lab_program();
std::string fake_camera_program();
/// See hung_disk.cpp.
std::string hung_disk_library();

}  // namespace sslv
