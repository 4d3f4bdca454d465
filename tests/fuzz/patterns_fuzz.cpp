// SPDX-License-Identifier: Apache-2.0
// libFuzzer: any file yields a pattern table or one SettingsError that names the file. ./run test-long
#include "base/error.h"
#include "fuzz/expect.h"
#include "vision/patterns.h"

#include <string>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace sslv;
  static const LabelSet kLabels({{10, "purple"}}, "");
  try {
    parse_patterns({reinterpret_cast<const char*>(bytes), size}, "file", kLabels);
  } catch (const SettingsError& error) {
    expect(std::string(error.what()).rfind("file", 0) == 0, "an error does not name the file");
  }
  return 0;
}
