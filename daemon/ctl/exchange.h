// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace sslv {

/// One HTTP request.
struct HttpCall {
  std::string method, path;
  std::vector<std::pair<std::string, std::string>> headers{};
  std::string body{};
};

struct HttpReply {
  int status = 0;
  std::string body;
  std::string set_cookie;  // the first Set-Cookie header
};

/// Limits for a server's answer, whatever it sends.
struct ExchangeLimits {
  std::size_t header_bytes = std::size_t{16} * 1024;
  std::uint64_t body_bytes = std::uint64_t{64} * 1024 * 1024;  // a support bundle is the largest
  std::chrono::milliseconds connect{10'000};                   // a lost packet is repeated after 1, 3 and 7 s
  std::chrono::milliseconds header{30'000};  // from the request to the end of the answer's header
  std::chrono::milliseconds whole{120'000};  // from the request to the end of the answer
};

/// There is no answer, or the answer cannot be used. what() is one line.
struct ExchangeError : std::runtime_error {
  using runtime_error::runtime_error;
};

/// Sends a request over its own connection and reads the answer. Does not decompress it, and follows no
/// redirects. `address`: http://HOST or http://HOST:PORT. Throws ExchangeError.
HttpReply http_exchange(const std::string& address, const HttpCall& call, const ExchangeLimits& limits = {});

/// The same, but passes the body of a 2xx answer, of any size and duration, to `take` in chunks, with at most
/// `limits.header` between two chunks. Exceptions from `take` are passed on.
HttpReply http_exchange(const std::string& address, const HttpCall& call,
                        const std::function<void(std::string_view)>& take, const ExchangeLimits& limits = {});

}  // namespace sslv
