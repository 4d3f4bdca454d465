// SPDX-License-Identifier: Apache-2.0
#pragma once

// Open files that the service manager keeps while the service is down (systemd's file descriptor store). The
// contents of such an in-memory file (memfd_create) survive a crash. Without a service manager nothing is
// kept.

#include "base/open_file.h"

#include <string>
#include <string_view>
#include <vector>

namespace sslv {

struct KeptFile {
  std::string name;
  OpenFile file;
};

/// Hands the file to the service manager. `name`: at most 255 letters, digits, '-' and '_'. From any thread.
void keep_file(const std::string& name, int fd);
/// Releases all files of that name. From any thread.
void forget_file(const std::string& name);

/// The files of an earlier run whose names begin with `name_begins`; the service manager keeps them until
/// forget_file() is called. Changes the environment, so it must be called only once, before any thread
/// starts.
std::vector<KeptFile> take_kept_files(std::string_view name_begins);

}  // namespace sslv
