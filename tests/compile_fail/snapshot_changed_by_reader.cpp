// SPDX-License-Identifier: Apache-2.0
// expect-error: read-only object|returns a const value
#include "base/snapshot.h"

struct Settings {
  int level = 0;
};

void change(const sslv::Snapshot<Settings>& settings) {
  settings.load()->level = 1;
}
