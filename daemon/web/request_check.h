// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>  // Boost 1.74's asio uses std::exchange without it

#include <boost/beast/http/fields.hpp>
#include <boost/beast/http/message.hpp>

namespace sslv {

struct HeaderRefusal {
  unsigned status;
  std::string text;
};

/// Why the header of a request is refused before anything of it is used, or nothing. `bytes`: as it came.
///
/// Two libraries read it, Beast for where a request ends and httplib for what it is: what they may take for
/// different things is refused. A header that decides something is given once, none goes on in a second line,
/// and what httplib matches with std::regex, which recurses for every character, is short: the address, and
/// every Range.
std::optional<HeaderRefusal> check_header(const boost::beast::http::request_header<>& header,
                                          std::string_view bytes);

}  // namespace sslv
