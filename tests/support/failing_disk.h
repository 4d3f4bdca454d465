// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace sslv::test {

/// While it exists, fsync(2) of a folder fails with EIO, as on a failing disk. Affects the whole program.
class FailingDisk {
 public:
  FailingDisk();
  ~FailingDisk();
  FailingDisk(const FailingDisk&) = delete;
  FailingDisk& operator=(const FailingDisk&) = delete;
};

}  // namespace sslv::test
