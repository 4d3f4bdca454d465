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

/// The daemon cannot be reached, or refused; one line, and plain text whatever the daemon said.
struct ClientError : std::runtime_error {
  explicit ClientError(const std::string& text);
};

/// How a daemon that wants a password gets it.
struct SignIn {
  std::function<std::string()> password;  // asked for once, when it is needed; throws ClientError without one
  std::string cookie{};                   // that the daemon gave for it
};

/// Asks a running daemon by its panel's address, such as "http://127.0.0.1:8090".
class Client {
 public:
  /// `sign_in` may be shared by several.
  Client(std::string address, std::shared_ptr<SignIn> sign_in)
      : address_(std::move(address)), sign_in_(std::move(sign_in)) {}

  /// Body of GET `path`. Throws ClientError with the daemon's own words when it refuses.
  std::string get(const std::string& path) const;
  /// Likewise, but the body goes to `take` piece by piece: for a file that is too large for memory.
  void get_pieces(const std::string& path, const std::function<void(std::string_view)>& take) const;
  Json get_json(const std::string& path) const;
  /// Answers of the other methods; they throw likewise. `if_revision`: refused unless the settings are still
  /// at this revision; then the error says who changed what since.
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

/// A name as a part of an address' path.
std::string path_part(const std::string& name);

/// What the daemon's answer to a refused request says, in one line.
std::string refusal_text(const std::string& path, int http_status, const std::string& body);

}  // namespace sslv
