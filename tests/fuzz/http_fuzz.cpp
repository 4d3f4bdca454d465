// SPDX-License-Identifier: Apache-2.0
// libFuzzer: whatever bytes a connection sends, each request gets an HTTP answer or the connection is closed,
// and other connections are still served. ./run test-long
#include "fuzz/served.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace sslv;
  static const Served kServed;
  const std::string answer = kServed.answer({reinterpret_cast<const char*>(bytes), size});
  expect(answer.empty() || answer.starts_with("HTTP/1."), "an answer that is no HTTP");
  expect(answer.find("HTTP/1.1 500 ") != 0 || answer.find("bad_function_call") != std::string::npos,
         "a request broke something");
  static int count = 0;
  if (++count % 256 == 0) kServed.check();
  return 0;
}
