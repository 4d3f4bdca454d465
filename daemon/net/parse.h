// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>

namespace google::protobuf {
class MessageLite;
}

namespace sslv {

/// Reads a message; false when it is none. Says nothing: protobuf itself writes a line for every datagram
/// that it cannot read, and a stranger's datagrams are not to fill the journal.
bool parse(google::protobuf::MessageLite& message, std::span<const std::byte> datagram);

}  // namespace sslv
