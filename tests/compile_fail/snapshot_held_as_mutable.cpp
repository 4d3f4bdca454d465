// SPDX-License-Identifier: Apache-2.0
// expect-error: 'shared_ptr<const int>' to
#include "base/snapshot.h"

std::shared_ptr<int> hold(const sslv::Snapshot<int>& value) {
  return value.load();
}
