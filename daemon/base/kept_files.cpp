// SPDX-License-Identifier: Apache-2.0
#include "base/kept_files.h"

#include <cstdlib>

#include <systemd/sd-daemon.h>

namespace sslv {

void keep_file(const std::string& name, int fd) {
  // A memfd never becomes ready: systemd must not poll it.
  const std::string message = "FDSTORE=1\nFDPOLL=0\nFDNAME=" + name;
  sd_pid_notify_with_fds(0, 0, message.c_str(), &fd, 1);
}

void forget_file(const std::string& name) {
  sd_notify(0, ("FDSTOREREMOVE=1\nFDNAME=" + name).c_str());
}

std::vector<KeptFile> take_kept_files(std::string_view name_begins) {
  std::vector<KeptFile> out;
  char** names = nullptr;
  const int count = sd_listen_fds_with_names(1, &names);
  for (int i = 0; i < count; ++i) {
    if (std::string_view(names[i]).starts_with(name_begins))
      out.push_back({names[i], OpenFile(SD_LISTEN_FDS_START + i)});
    std::free(names[i]);
  }
  std::free(names);
  return out;
}

}  // namespace sslv
