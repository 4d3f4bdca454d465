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

/// What a server may take of us, whatever it sends.
struct ExchangeLimits {
  std::size_t header_bytes = std::size_t{16} * 1024;
  std::uint64_t body_bytes = std::uint64_t{64} * 1024 * 1024;  // a support bundle is the largest
  std::chrono::milliseconds connect{2'000};
  std::chrono::milliseconds header{30'000};  // from the request to the end of the answer's header
  std::chrono::milliseconds whole{120'000};  // and to its end
};

/// No answer came, or none that can be used; one line.
struct ExchangeError : std::runtime_error {
  using runtime_error::runtime_error;
};

/// Sends a request over a connection of its own and reads the answer, which is not unpacked, and no other
/// address is gone to. `address`: http://HOST or http://HOST:PORT. Throws ExchangeError.
HttpReply http_exchange(const std::string& address, const HttpCall& call, const ExchangeLimits& limits = {});

/// Likewise, but if the answer's status is 2xx its body goes to `take` piece by piece, as large as it is and
/// for as long as pieces come, with at most `limits.header` between two of them. What `take` throws is passed
/// on.
HttpReply http_exchange(const std::string& address, const HttpCall& call,
                        const std::function<void(std::string_view)>& take, const ExchangeLimits& limits = {});

}  // namespace sslv
