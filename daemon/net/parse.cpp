// SPDX-License-Identifier: Apache-2.0
#include "net/parse.h"

#include <google/protobuf/message_lite.h>
#include <google/protobuf/stubs/logging.h>

namespace sslv {

bool parse(google::protobuf::MessageLite& message, std::span<const std::byte> datagram) {
  static google::protobuf::LogHandler* const kBefore = google::protobuf::SetLogHandler(nullptr);
  static_cast<void>(kBefore);
  return message.ParseFromArray(datagram.data(), static_cast<int>(datagram.size()));
}

}  // namespace sslv
