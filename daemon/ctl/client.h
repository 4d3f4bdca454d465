// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

namespace sslv {

/// The daemon cannot be reached, or refused a request. what() is one line of plain text.
struct ClientError : std::runtime_error {
  explicit ClientError(const std::string& text);
};

/// How to sign in to a daemon that requires a password.
struct SignIn {
  std::function<std::string()> password;  // called at most once; throws ClientError if there is none
  std::string cookie{};                   // session cookie from the daemon
};

/// Sends requests to a running daemon at its panel's address, such as "http://127.0.0.1:8090".
class Client {
 public:
  /// `sign_in` may be shared by several clients.
  Client(std::string address, std::shared_ptr<SignIn> sign_in)
      : address_(std::move(address)), sign_in_(std::move(sign_in)) {}

  /// Returns the body of GET `path`. Throws ClientError with the daemon's message if it refuses.
  std::string get(const std::string& path) const;
  /// The same, but passes the body to `take` in chunks: for a file that is too large for memory.
  void get_pieces(const std::string& path, const std::function<void(std::string_view)>& take) const;
  Json get_json(const std::string& path) const;
  /// These return the answers to the other methods and throw like get(). `if_revision`: the request is
  /// refused unless the settings are still at this revision; the error then lists the changes since and their
  /// authors.
  Json post(const std::string& path, const Json& body, std::optional<std::uint64_t> if_revision = {}) const;
  Json post_bytes(const std::string& path, const std::string& bytes) const;
  Json patch(const std::string& path, const Json& body, std::optional<std::uint64_t> if_revision = {}) const;
  Json put(const std::string& path, const Json& body) const;
  Json remove(const std::string& path) const;

 private:
  struct Request;
  std::string answer(const Request& request) const;

  std::string address_;
  std::shared_ptr<SignIn> sign_in_;
};

/// Percent-encodes a name for an address' path.
std::string path_part(const std::string& name);

/// Returns the reason in the daemon's answer to a refused request, in one line.
std::string refusal_text(const std::string& path, int http_status, const std::string& body);

}  // namespace sslv
