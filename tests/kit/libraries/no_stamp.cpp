// SPDX-License-Identifier: Apache-2.0
// A shared object of another kind.
extern "C" int answer() {
  return 42;
}
