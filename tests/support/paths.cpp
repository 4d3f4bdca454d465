// SPDX-License-Identifier: Apache-2.0
#include "support/paths.h"

namespace sslv {

std::string source_path(std::string_view below) {
  return SSLV_SOURCE_DIR + std::string(below);
}
std::string daemon_program() {
  return SSLV_DAEMON;
}
std::string ctl_program() {
  return SSLV_CTL;
}
std::string lab_program() {
  return SSLV_LAB;
}
std::string fake_camera_program() {
  return SSLV_FAKE_CAMERA;
}
std::string hung_disk_library() {
  return SSLV_HUNG_DISK;
}

}  // namespace sslv
