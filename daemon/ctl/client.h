// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"

#include <stdexcept>
#include <string>

namespace sslv {

/// The daemon cannot be reached, or refused; one line.
struct ClientError : std::runtime_error {
  using runtime_error::runtime_error;
};

/// Asks a running daemon by its panel's address, such as "http://127.0.0.1:8090".
class Client {
 public:
  explicit Client(std::string address) : address_(std::move(address)) {}

  /// Body of GET `path`. Throws ClientError with the daemon's own words when it refuses.
  std::string get(const std::string& path) const;
  Json get_json(const std::string& path) const { return Json::parse(get(path)); }
  /// Answer of POST or PATCH `path`. Throws likewise.
  Json post(const std::string& path, const Json& body) const;
  Json patch(const std::string& path, const Json& body) const;

 private:
  std::string address_;
};

/// The status as a table for a terminal.
std::string status_text(const Json& status);

}  // namespace sslv
