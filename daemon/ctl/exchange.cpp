// SPDX-License-Identifier: Apache-2.0
#include "ctl/exchange.h"

#include <algorithm>
#include <limits>
#include <string_view>
#include <utility>
#include <vector>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core/error.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/http/buffer_body.hpp>
#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/read.hpp>
#include <boost/beast/http/string_body.hpp>
#include <boost/beast/http/write.hpp>
#include <fmt/format.h>

namespace sslv {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
using boost::system::error_code;

namespace {

struct ServerAddress {
  std::string host, port;  // the host without brackets
  std::string name;        // for the Host header
};

ServerAddress parse_address(const std::string& address) {
  const auto refuse = [&] {
    throw ExchangeError(fmt::format("\"{}\" is not an address; expected http://HOST:PORT{}", address,
                                    address.starts_with("https:") ? " (this program has no TLS)" : ""));
  };
  std::string_view rest = address;
  constexpr std::string_view kScheme = "http://";
  if (rest.starts_with(kScheme)) rest.remove_prefix(kScheme.size());
  if (rest.ends_with('/')) rest.remove_suffix(1);
  ServerAddress parsed{"", "80", std::string(rest)};
  const bool is_bracketed = rest.starts_with('[');
  const std::size_t end = rest.find(is_bracketed ? ']' : ':');
  if (is_bracketed) {
    if (end == std::string_view::npos) refuse();
    parsed.host = rest.substr(1, end - 1);
    rest.remove_prefix(end + 1);
  } else {
    parsed.host = rest.substr(0, end);
    rest.remove_prefix(std::min(parsed.host.size(), rest.size()));
  }
  if (!rest.empty()) {
    parsed.port = rest.substr(1);
    const bool is_number =
        !parsed.port.empty() && parsed.port.find_first_not_of("0123456789") == std::string::npos;
    if (rest.front() != ':' || !is_number) refuse();
  }
  if (parsed.host.empty() || parsed.host.find_first_of("/?#@ \r\n") != std::string::npos) refuse();
  return parsed;
}

class Exchange {
 public:
  Exchange(const std::string& address, const ExchangeLimits& limits)
      : address_(address),
        limits_(limits),
        server_(parse_address(address)),
        deadline_(Clock::now() + limits.whole) {}

  /// `take`: see http_exchange(); null: the body is always in the reply.
  HttpReply answer_to(const HttpCall& call, const std::function<void(std::string_view)>& take) {
    error_code error;
    const auto endpoints = asio::ip::tcp::resolver(io_).resolve(server_.host, server_.port, error);
    if (error) refuse_silence(error);
    wait(limits_.connect, [&](auto done) {
      stream_.async_connect(endpoints, [done](error_code e, const auto&) { done(e); });
    });
    http::request<http::string_body> request;
    request.method_string(call.method);
    request.target(call.path);
    request.version(11);
    request.set(http::field::host, server_.name);
    request.set(http::field::connection, "close");
    for (const auto& [name, value] : call.headers) request.set(name, value);
    request.body() = call.body;
    request.prepare_payload();
    wait(limits_.header, [&](auto done) {
      http::async_write(stream_, request, [done](error_code e, std::size_t) { done(e); });
    });

    http::response_parser<http::string_body> parser;
    parser.header_limit(static_cast<std::uint32_t>(limits_.header_bytes));
    parser.body_limit(take ? std::numeric_limits<std::uint64_t>::max() : limits_.body_bytes);
    beast::flat_buffer buffer;
    wait(limits_.header, [&](auto done) {
      http::async_read_header(stream_, buffer, parser, [done](error_code e, std::size_t) { done(e); });
    });
    const auto cookie = parser.get()[http::field::set_cookie];
    HttpReply reply{static_cast<int>(parser.get().result_int()), {}, {cookie.data(), cookie.size()}};
    if (take && reply.status >= 200 && reply.status <= 299) {
      http::response_parser<http::buffer_body> pieces(std::move(parser));
      read_pieces(buffer, pieces, take);
      return reply;
    }
    if (parser.content_length().value_or(0) > limits_.body_bytes) refuse(http::error::body_limit);
    parser.body_limit(limits_.body_bytes);
    wait(limits_.whole, [&](auto done) {
      http::async_read(stream_, buffer, parser, [done](error_code e, std::size_t) { done(e); });
    });
    reply.body = std::move(parser.get().body());
    return reply;
  }

 private:
  using Clock = std::chrono::steady_clock;

  void read_pieces(beast::flat_buffer& buffer, http::response_parser<http::buffer_body>& pieces,
                   const std::function<void(std::string_view)>& take) {
    std::vector<char> piece(std::size_t{256} * 1024);
    buffer.reserve(piece.size());  // Beast reads as much at once as fits into it
    while (!pieces.is_done()) {
      auto& body = pieces.get().body();
      body.data = piece.data();
      body.size = piece.size();
      deadline_ = Clock::now() + limits_.header;  // no limit for the whole file
      wait(limits_.header, [&](auto done) {
        http::async_read(stream_, buffer, pieces, [done](error_code e, std::size_t) {
          done(e == http::error::need_buffer ? error_code() : e);
        });
      });
      take({piece.data(), piece.size() - body.size});
    }
  }

  /// Runs a step to its end. Throws ExchangeError.
  template <class Step>
  void wait(std::chrono::milliseconds patience, const Step& step) {
    error_code error;
    stream_.expires_at(std::min(Clock::now() + patience, deadline_));
    step([&error](error_code caught) { error = caught; });
    io_.restart();
    io_.run();
    if (error) refuse(error);
  }

  [[noreturn]] void refuse(const error_code& error) const {
    if (error == http::error::body_limit) {
      throw ExchangeError(
          fmt::format("{} sends more than {} MiB, which no daemon does", address_, limits_.body_bytes >> 20));
    }
    if (error == http::error::header_limit || error == http::error::buffer_overflow)
      throw ExchangeError(fmt::format("{} sends a header that is too long for a daemon's", address_));
    refuse_silence(error);
  }

  [[noreturn]] void refuse_silence(const error_code& error) const {
    throw ExchangeError(fmt::format("no daemon answers at {} ({}); is it running, and is --daemon right?",
                                    address_, error.message()));
  }

  const std::string address_;
  const ExchangeLimits limits_;
  const ServerAddress server_;
  Clock::time_point deadline_;
  asio::io_context io_{1};
  beast::tcp_stream stream_{io_};
};

}  // namespace

HttpReply http_exchange(const std::string& address, const HttpCall& call, const ExchangeLimits& limits) {
  return Exchange(address, limits).answer_to(call, {});
}

HttpReply http_exchange(const std::string& address, const HttpCall& call,
                        const std::function<void(std::string_view)>& take, const ExchangeLimits& limits) {
  return Exchange(address, limits).answer_to(call, take);
}

}  // namespace sslv
