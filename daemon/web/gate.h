// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace sslv {

/// What a visitor may do; each may do what stands before it, too.
enum class May { kNothing, kLook, kChange };

/// Who may do what, as the server asks for every request. May be asked from any thread, and must not block
/// but where it says so: also the thread that serves all sockets asks.
class Gate {
 public:
  virtual ~Gate() = default;
  /// Reads what other programs changed about who may do what; called before a request that may wait, so that
  /// a password that was changed counts at once. May block.
  virtual void refresh() {}
  /// By the Cookie header, "" when there is none.
  virtual May may(std::string_view cookies) = 0;
  /// Why nobody may change anything now; empty: changes are allowed.
  virtual std::string lock_reason() = 0;
  /// Names by which browsers reach this computer, besides its own name and addresses.
  virtual std::vector<std::string> names() const = 0;
  /// Whether strangers must leave room for connections from this address.
  virtual bool is_trusted(const std::string& address) = 0;
};

/// Whether a viewer that stays connected may go on looking: asked now and then.
using MayLook = std::function<bool()>;
inline MayLook may_look(Gate& gate, std::string cookies) {
  return [&gate, cookies = std::move(cookies)] { return gate.may(cookies) != May::kNothing; };
}

}  // namespace sslv
