// SPDX-License-Identifier: Apache-2.0
// A shared library without stages.
extern "C" int answer() {
  return 42;
}
