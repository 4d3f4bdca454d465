// SPDX-License-Identifier: Apache-2.0
// libFuzzer: the server withstands any WebSocket frames and messages. The first byte selects whether the rest
// is raw frame bytes, or one message in a valid frame. ./run test-long
#include "fuzz/served.h"

namespace {

constexpr std::string_view kUpgrade =
    "GET /api/ws HTTP/1.1\r\nHost: localhost\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n"
    "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n";

/// A frame as in RFC 6455, masked with zeros.
std::string frame(unsigned char opcode, std::string_view payload) {
  std::string out{static_cast<char>(0x80 | opcode)};
  if (payload.size() < 126) {
    out += static_cast<char>(0x80 | payload.size());
  } else {
    out += static_cast<char>(0x80 | 126);
    out += static_cast<char>(payload.size() >> 8 & 0xff);
    out += static_cast<char>(payload.size() & 0xff);
  }
  return out + std::string(4, '\0') + std::string(payload);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace sslv;
  if (size == 0) return 0;
  static const Served kServed;
  const std::string_view rest(reinterpret_cast<const char*>(bytes + 1), size - 1);
  const std::string sent = bytes[0] % 2 == 0 ? std::string(rest) : frame(1, rest) + frame(8, "\x03\xe8");
  const std::string answer = kServed.answer(std::string(kUpgrade) + sent);
  expect(answer.empty() || answer.starts_with("HTTP/1.1 101 "), "no WebSocket");
  static int count = 0;
  if (++count % 256 == 0) kServed.check();
  return 0;
}
