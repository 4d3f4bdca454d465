// SPDX-License-Identifier: Apache-2.0
#pragma once

// Open files that the service manager keeps while the service is down: systemd's file descriptor store. What
// lies in memory that such a file is (memfd_create) outlives a crash. Without a service manager nothing is
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

/// `name`: at most 255 letters, digits, '-' and '_'. From any thread.
void keep_file(const std::string& name, int fd);
/// All of that name. From any thread.
void forget_file(const std::string& name);

/// Those with such a name that an earlier run of the service left; the service manager keeps them until they
/// are forgotten. Changes the environment: to be called once, before there are threads.
std::vector<KeptFile> take_kept_files(std::string_view name_begins);

}  // namespace sslv
