// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace sslv {

/// A visitor's permissions; each level includes the previous ones.
enum class May { kNothing, kLook, kChange };

/// Access control: the server asks it for every request. Thread-safe. Functions must not block unless stated:
/// the thread that serves all sockets calls them, too.
class Gate {
 public:
  virtual ~Gate() = default;
  /// Reloads access rights that other programs changed, so that a new password takes effect at once. Called
  /// before requests that may wait. May block.
  virtual void refresh() {}
  /// `cookies`: the Cookie header, "" if there is none.
  virtual May may(std::string_view cookies) = 0;
  /// Why nobody may change anything at present; empty: changes are allowed.
  virtual std::string lock_reason() = 0;
  /// Names by which browsers reach this computer, besides its own name and addresses.
  virtual std::vector<std::string> names() const = 0;
  /// Whether this address may use the reserved connections (connections.h).
  virtual bool is_trusted(const std::string& address) = 0;
};

/// Whether a connected viewer may keep watching; polled.
using MayLook = std::function<bool()>;
inline MayLook may_look(Gate& gate, std::string cookies) {
  return [&gate, cookies = std::move(cookies)] { return gate.may(cookies) != May::kNothing; };
}

}  // namespace sslv
