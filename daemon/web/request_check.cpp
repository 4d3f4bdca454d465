// SPDX-License-Identifier: Apache-2.0
#include "web/request_check.h"

#include <algorithm>
#include <cstddef>

namespace sslv {

namespace http = boost::beast::http;

namespace {

constexpr std::size_t kMaxMatchedBytes = 1024;

/// Headers that must not be repeated: parsers may differ in which of two values they use.
constexpr http::field kGivenOnce[] = {
    http::field::authorization, http::field::content_encoding, http::field::content_length,
    http::field::content_type,  http::field::cookie,           http::field::expect,
    http::field::host,          http::field::if_match,         http::field::origin,
    http::field::range,         http::field::upgrade,
};

}  // namespace

std::optional<HeaderRefusal> check_header(const http::request_header<>& header, std::string_view bytes) {
  if (bytes.find("\r\n ") != std::string_view::npos || bytes.find("\r\n\t") != std::string_view::npos)
    return HeaderRefusal{400, "not a valid HTTP request: a header continues on a second line"};
  if (header.count(http::field::transfer_encoding) > 0)
    return HeaderRefusal{411, "Transfer-Encoding is not allowed; expected a Content-Length"};
  const auto ranges = header.equal_range(http::field::range);
  const bool has_long_range = std::any_of(
      ranges.first, ranges.second, [](const auto& range) { return range.value().size() > kMaxMatchedBytes; });
  if (has_long_range || header.target().size() > kMaxMatchedBytes)
    return HeaderRefusal{414, "the address or the Range is longer than 1 KiB"};
  for (const http::field name : kGivenOnce) {
    if (header.count(name) > 1)
      return HeaderRefusal{400, std::string(http::to_string(name)) + " is given more than once"};
  }
  return std::nullopt;
}

}  // namespace sslv
