// SPDX-License-Identifier: Apache-2.0
#include "web/http_session.h"

#include <array>
#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include <boost/asio/post.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/read.hpp>
#include <boost/beast/http/string_body.hpp>
#include <boost/beast/http/write.hpp>
#include <boost/beast/websocket/rfc6455.hpp>

namespace sslv {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;

namespace {

constexpr std::uint32_t kMaxHeaderBytes = 16 * 1024;
constexpr std::uint64_t kMaxBodyBytes = 1024 * 1024;
constexpr std::chrono::seconds kIdleTimeout{75};     // between two requests
constexpr std::chrono::seconds kRequestTimeout{20};  // from a request's first byte to its last
constexpr std::chrono::seconds kAnswerTimeout{60};
constexpr std::chrono::seconds kDrainTimeout{2};

using HttpRequest = http::request<http::string_body>;
using HttpResponse = http::response<http::string_body>;

std::string text_of(beast::string_view text) {
  return {text.data(), text.size()};
}

std::string lower_case(std::string text) {
  for (char& c : text) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return text;
}

/// False when the target cannot be read.
bool convert(HttpRequest& from, Request& to) {
  to.method = text_of(from.method_string());
  for (const auto& field : from) {
    to.headers.emplace(lower_case(text_of(field.name_string())), text_of(field.value()));
  }
  to.body = std::move(from.body());
  const beast::string_view target = from.target();
  return parse_target({target.data(), target.size()}, to);
}

HttpResponse convert(Response from, unsigned version) {
  HttpResponse to(static_cast<http::status>(from.status), version, std::move(from.body));
  to.set(http::field::content_type, from.content_type);
  for (const auto& [name, value] : from.headers) to.set(name, value);
  // The panel loads nothing from elsewhere, and nobody else may frame it or run script in it.
  to.set("Content-Security-Policy",
         "default-src 'self'; img-src 'self' blob: data:; connect-src 'self' ws: wss:; object-src 'none'; "
         "frame-ancestors 'none'; base-uri 'none'");
  to.set("X-Content-Type-Options", "nosniff");
  to.set("Referrer-Policy", "no-referrer");
  to.content_length(to.body().size());
  return to;
}

class HttpSession : public std::enable_shared_from_this<HttpSession> {
 public:
  HttpSession(asio::ip::tcp::socket socket, ScopedCount connection, const HttpContext& context)
      : context_(context), connection_(std::move(connection)), stream_(std::move(socket)) {
    beast::error_code ignored;
    remote_address_ = stream_.socket().remote_endpoint(ignored).address().to_string();
  }

  /// Waits for the next request to begin.
  void wait() {
    if (buffer_.size() > 0) return read();  // it came together with the last one
    stream_.expires_after(kIdleTimeout);
    stream_.async_read_some(buffer_.prepare(4096),
                            [self = shared_from_this()](beast::error_code error, std::size_t bytes) {
                              if (error) return;  // gone, or silent for too long
                              self->buffer_.commit(bytes);
                              self->read();
                            });
  }

 private:
  void read() {
    parser_.emplace();
    parser_->header_limit(kMaxHeaderBytes);
    parser_->body_limit(kMaxBodyBytes);
    is_head_ = false;
    stream_.expires_after(kRequestTimeout);
    http::async_read(stream_, buffer_, *parser_,
                     [self = shared_from_this()](beast::error_code error, std::size_t) {
                       error ? self->refuse(error) : self->handle();
                     });
  }

  /// Closes the connection; first says why when what came is to blame and not the network.
  void refuse(beast::error_code error) {
    if (error == http::error::header_limit) {
      answer(error_response(431, "the header is larger than 16 KiB"), false);
    } else if (error == http::error::body_limit) {
      answer(error_response(413, "the body is larger than 1 MiB"), false);
    } else if (error == http::error::end_of_stream || error == http::error::partial_message) {
      return;  // the client has gone
    } else if (error.category() == http::make_error_code(http::error::bad_method).category()) {
      answer(error_response(400, "not a valid HTTP request: " + error.message()), false);
    }
  }

  void handle() {
    HttpRequest& http_request = parser_->get();
    version_ = http_request.version();
    is_head_ = http_request.method() == http::verb::head;
    const bool keep_alive = http_request.keep_alive();
    const bool is_upgrade = beast::websocket::is_upgrade(http_request);

    Request request;
    request.remote_address = remote_address_;
    if (!convert(http_request, request)) {
      return answer(error_response(400, "this address is not one of this server"), keep_alive);
    }
    if (is_upgrade && text_of(http_request.target()) == WebSocketHub::kPath) {
      if (!is_same_origin(request)) {
        return answer(error_response(403, "this request comes from a page of another site"), false);
      }
      stream_.expires_never();
      return context_.websockets.accept(stream_.release_socket(), std::move(connection_), http_request);
    }
    asio::post(context_.workers, [self = shared_from_this(), keep_alive,
                                  request = std::move(request)]() mutable {
      Response response = self->context_.router.answer(std::move(request));
      asio::post(self->stream_.get_executor(), [self, keep_alive, response = std::move(response)]() mutable {
        self->answer(std::move(response), keep_alive);
      });
    });
  }

  void answer(Response response, bool keep_alive) {
    response_ = convert(std::move(response), version_);
    response_.keep_alive(keep_alive);
    if (is_head_) response_.body().clear();  // its length stays in the header
    stream_.expires_after(kAnswerTimeout);
    http::async_write(stream_, response_, [self = shared_from_this()](beast::error_code error, std::size_t) {
      if (error) return;
      self->response_.keep_alive() ? self->wait() : self->finish();
    });
  }

  /// Closing while bytes are still coming would reset the connection, and the client might lose the answer.
  void finish() {
    beast::error_code ignored;
    stream_.socket().shutdown(asio::ip::tcp::socket::shutdown_send, ignored);
    stream_.expires_after(kDrainTimeout);
    drain();
  }

  void drain() {
    stream_.async_read_some(asio::buffer(rest_),
                            [self = shared_from_this()](beast::error_code error, std::size_t) {
                              if (!error) self->drain();
                            });
  }

  const HttpContext& context_;
  ScopedCount connection_;
  beast::tcp_stream stream_;
  std::string remote_address_;
  beast::flat_buffer buffer_;
  std::optional<http::request_parser<http::string_body>> parser_;
  HttpResponse response_;
  unsigned version_ = 11;
  bool is_head_ = false;
  std::array<char, 4096> rest_;
};

}  // namespace

void serve_http(asio::ip::tcp::socket socket, ScopedCount connection, const HttpContext& context) {
  std::make_shared<HttpSession>(std::move(socket), std::move(connection), context)->wait();
}

}  // namespace sslv
