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

/// Returns the reason to refuse a request's header before any of it is used, or nothing. `bytes`: the header
/// as received.
///
/// Two libraries parse the header: Beast to find the end of the request, httplib to interpret it. Anything
/// they might read differently is refused: repeats of the headers that affect the answer, and headers
/// continued on a second line. The address and every Range must be short: httplib matches them with
/// std::regex, which recurses for every character.
std::optional<HeaderRefusal> check_header(const boost::beast::http::request_header<>& header,
                                          std::string_view bytes);

}  // namespace sslv
