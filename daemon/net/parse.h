// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>

namespace google::protobuf {
class MessageLite;
}

namespace sslv {

/// Parses a message; false if the bytes are invalid. Silences protobuf's own log, so that datagrams of
/// unknown senders cannot fill the journal.
bool parse(google::protobuf::MessageLite& message, std::span<const std::byte> datagram);

}  // namespace sslv
