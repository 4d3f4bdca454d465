// SPDX-License-Identifier: Apache-2.0
#include "web/http_session.h"

#include "web/http.h"
#include "web/picture_stream.h"
#include "web/request_check.h"
#include "web/socket.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include <boost/asio/buffer.hpp>
#include <boost/asio/completion_condition.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/read.hpp>
#include <boost/asio/read_until.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/parser.hpp>
#include <boost/beast/websocket/rfc6455.hpp>
#include <unistd.h>

namespace sslv {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;

namespace {

constexpr std::uint32_t kMaxHeaderBytes = 16 * 1024;
constexpr std::chrono::seconds kRequestTimeout{20};       // from a request's first byte to its last
constexpr std::chrono::seconds kLargeRequestTimeout{90};  // the same for a file that an admin sends
constexpr int kMaxLargeBytes = 8 * 1024 * 1024;  // sum over all large requests; one alone always fits
constexpr int kMaxSentFiles = 16;                // sent simultaneously; each keeps a file open
constexpr std::chrono::seconds kAnswerTimeout{60};
constexpr std::chrono::seconds kDrainTimeout{2};
constexpr std::size_t kPieceBytes = 128 * 1024;  // chunk size for files and other answers
/// With a larger kernel buffer, a slow client would seem to receive nothing for seconds.
constexpr int kMaxUnsentInKernel = 64 * 1024;

std::string_view view(beast::string_view text) {
  return {text.data(), text.size()};
}

class HttpSession : public std::enable_shared_from_this<HttpSession> {
 public:
  HttpSession(asio::ip::tcp::socket socket, ScopedCount connection, Connections::Seat& seat,
              const HttpContext& context)
      : context_(context), connection_(std::move(connection)), seat_(seat), stream_(std::move(socket)) {
    remote_address_ = remote_address(stream_.socket());
    limit_unsent_bytes(stream_.socket(), kMaxUnsentInKernel);
  }

  void start() {
    seat_.closes_by([weak = weak_from_this()] {
      if (const auto self = weak.lock()) self->stream_.close();
    });
    wait();
  }

 private:
  /// Waits for the next request to begin.
  void wait() {
    seat_.waits();
    if (!received_.empty()) return read_header();  // received together with the previous request
    stream_.expires_after(kKeepAliveTimeout);
    asio::async_read(stream_, asio::dynamic_buffer(received_, kMaxHeaderBytes), asio::transfer_at_least(1),
                     [self = shared_from_this()](beast::error_code error, std::size_t) {
                       if (!error) self->read_header();  // else disconnected, or idle for too long
                     });
  }

  void read_header() {
    // Most likely TLS, which never contains the end of a header.
    if (std::isalpha(static_cast<unsigned char>(received_.front())) == 0)
      return refuse(400, "not a valid HTTP request");
    stream_.expires_after(kRequestTimeout);
    asio::async_read_until(stream_, asio::dynamic_buffer(received_, kMaxHeaderBytes), "\r\n\r\n",
                           [self = shared_from_this()](beast::error_code error, std::size_t size) {
                             if (error == asio::error::not_found) {
                               self->refuse(431, "the header is larger than 16 KiB");
                             } else if (!error) {
                               self->read_body(size);
                             }
                           });
  }

  /// Beast parses the header only to find the end of the request and WebSocket upgrades; httplib does the
  /// rest.
  void read_body(std::size_t header_size) {
    http::request_parser<http::empty_body> parser;
    parser.header_limit(kMaxHeaderBytes);
    const auto [method, target] = first_line();
    const std::size_t max_body = context_.router.max_body_of(method, target);
    parser.body_limit(max_body);
    beast::error_code error;
    parser.put(asio::buffer(received_.data(), header_size), error);
    if (error == http::error::body_limit) {
      return refuse(413, "the body is larger than " + std::to_string(max_body >> 20U) + " MiB");
    }
    if (error) return refuse(400, "not a valid HTTP request: " + error.message());
    const auto& header = parser.get();
    if (const auto refusal = check_header(header, std::string_view(received_).substr(0, header_size)))
      return refuse(refusal->status, refusal->text);
    if (beast::websocket::is_upgrade(header) &&
        (target == WebSocketHub::kPath || target == WebSocketHub::kSecondPath))
      return upgrade(header);

    const auto body_size = static_cast<std::size_t>(parser.content_length().value_or(0));
    if (body_size > kMaxStrangersBodyBytes) {
      if (const auto refusal = refuse_body(header)) return refuse(refusal->status, refusal->text);
    }
    if (body_size > kMaxBodyBytes) {
      const int bytes = static_cast<int>(body_size);  // fits: no route allows more
      if (context_.large_bytes > 0 && context_.large_bytes > kMaxLargeBytes - bytes)
        return refuse(503, "other large files are being sent; try again in a moment");
      large_.emplace(context_.large_bytes, nullptr, bytes);
      stream_.expires_after(kLargeRequestTimeout);
    } else if (std::string problem; !seat_.holds(body_size, problem)) {
      return refuse(503, problem);
    }
    const std::size_t size = header_size + body_size;
    if (received_.size() >= size) return handle(size);
    received_.reserve(size);
    const auto while_sent = [this, rest = size - received_.size()](beast::error_code read_error,
                                                                   std::size_t count) -> std::size_t {
      if (read_error) return 0;
      seat_.makes_progress();
      return std::min(rest - count, kPieceBytes);  // each read first zero-fills this many
    };
    asio::async_read(stream_, asio::dynamic_buffer(received_), while_sent,
                     [self = shared_from_this(), size](beast::error_code read_error, std::size_t) {
                       if (!read_error) self->handle(size);
                     });
  }

  /// Returns the reason to refuse a body before memory is allocated for it. The router makes the same checks
  /// for all requests.
  std::optional<HeaderRefusal> refuse_body(const http::request_header<>& header) const {
    const std::string_view host = view(header[http::field::host]);
    if (!is_own_name(host, context_.gate.names())) return HeaderRefusal{403, not_own_name(host)};
    if (!is_same_origin(view(header[http::field::origin]), host))
      return HeaderRefusal{403, std::string(kOtherSite)};
    if (context_.gate.may(view(header[http::field::cookie])) != May::kChange)
      return HeaderRefusal{401, "sign in with the admin's password first"};
    return std::nullopt;
  }

  void upgrade(const WebSocketHub::UpgradeRequest& header) {
    const std::string_view host = view(header[http::field::host]);
    if (!is_own_name(host, context_.gate.names())) return refuse(403, not_own_name(host));
    if (!is_same_origin(view(header[http::field::origin]), host)) return refuse(403, std::string(kOtherSite));
    MayLook may = may_look(context_.gate, std::string(view(header[http::field::cookie])));
    if (!may()) return refuse(401, "sign in first");
    std::string problem;
    if (!stays(problem)) return refuse(503, problem);
    stream_.expires_never();
    context_.websockets.accept(stream_.release_socket(), std::move(connection_), seat_, header,
                               std::move(may));
  }

  /// Method and address of the first request in received_.
  std::pair<std::string_view, std::string_view> first_line() const {
    const std::string_view line = std::string_view(received_).substr(0, received_.find('\r'));
    const std::string_view method = line.substr(0, line.find(' '));
    const std::string_view rest = line.substr(std::min(line.size(), method.size() + 1));
    return {method, rest.substr(0, rest.find(' '))};
  }

  bool stays(std::string& problem) { return seat_.stays(context_.gate.is_trusted(remote_address_), problem); }

  /// Passes the complete request at the start of received_ to a worker.
  void handle(std::size_t size) {
    std::string following = received_.substr(size);
    received_.resize(size);
    seat_.works();
    const auto [method, target] = first_line();
    const Speed speed =
        size > kLargeRequestBytes ? Speed::kTakesMemory : context_.router.speed_of(method, target);
    auto work = [self = shared_from_this(), request = std::exchange(received_, std::move(following))] {
      if (self->context_.workers.stopped()) return;  // a strand still runs its queue after the stop
      HttpAnswer answer = self->context_.router.answer(request, self->remote_address_);
      asio::post(self->stream_.get_executor(),
                 [self, answer = std::move(answer)]() mutable { self->answer(std::move(answer)); });
    };
    if (speed == Speed::kTakesMemory) {
      asio::post(context_.one_by_one, std::move(work));
    } else {
      asio::post(speed == Speed::kAtOnce ? context_.quick : context_.workers, std::move(work));
    }
  }

  void refuse(unsigned status, const std::string& text) { answer({refusal_text(status, text), false}); }

  /// Completion condition of asio::async_write(), whose handler keeps this object alive. A client that takes
  /// some bytes gets more time for the rest.
  auto while_taken() {
    return [this](beast::error_code error, std::size_t) -> std::size_t {
      if (error) return 0;
      seat_.makes_progress();
      stream_.expires_after(kAnswerTimeout);
      return kPieceBytes;
    };
  }

  void answer(HttpAnswer answer) {
    answer_ = std::move(answer);
    large_.reset();
    std::string problem;
    if (answer_.stream && !stays(problem)) answer_ = {refusal_text(503, problem), false};
    if (answer_.file && context_.sent_files >= kMaxSentFiles)
      answer_ = {refusal_text(503, "other files are being downloaded; try again in a moment"), false};
    const auto unsent_bytes = [this] {
      return answer_.bytes.size() + (answer_.file ? answer_.file->before.size() + kPieceBytes : 0);
    };
    if (!seat_.holds(unsent_bytes(), problem)) answer_ = {refusal_text(503, problem), false};
    if (answer_.file) sent_file_.emplace(context_.sent_files);
    if (!answer_.stream) seat_.sends();
    // The file's prefix is sent with the headers.
    const std::string_view before = answer_.file ? std::string_view(answer_.file->before) : "";
    const std::array<asio::const_buffer, 2> head{asio::buffer(answer_.bytes), asio::buffer(before)};
    asio::async_write(stream_, head, while_taken(),
                      [self = shared_from_this()](beast::error_code error, std::size_t) {
                        if (error) return;
                        self->answer_.bytes = {};
                        if (self->answer_.file) self->answer_.file->before = {};
                        self->seat_.holds(self->answer_.file ? kPieceBytes : 0, self->ignored_);
                        if (self->answer_.stream) return self->stream();
                        if (self->answer_.file) return self->send_file(0);
                        self->answer_.keep_alive ? self->wait() : self->finish();
                      });
  }

  void stream() {
    stream_.expires_never();
    stream_pictures(stream_.release_socket(), std::move(connection_), seat_, context_.feeds, *answer_.stream,
                    std::move(answer_.may_look));
  }

  /// Sends a file in chunks: a worker reads each chunk but never waits for the client. A client that receives
  /// fewer bytes than the head announced knows that its file is incomplete.
  void send_file(std::uint64_t offset) {
    if (offset >= answer_.file->bytes) return send_after_file();
    asio::post(context_.workers, [self = shared_from_this(), offset] {
      const std::uint64_t size = std::min<std::uint64_t>(kPieceBytes, self->answer_.file->bytes - offset);
      self->piece_.resize(size);
      const ssize_t count =
          ::pread(*self->answer_.file->descriptor, self->piece_.data(), size, static_cast<off_t>(offset));
      asio::post(self->stream_.get_executor(), [self, offset, count] {
        if (count <= 0) return self->stream_.close();
        self->send_piece(offset, static_cast<std::size_t>(count));
      });
    });
  }

  void send_after_file() {
    asio::async_write(stream_, asio::buffer(answer_.file->after), while_taken(),
                      [self = shared_from_this()](beast::error_code error, std::size_t) {
                        self->answer_.file.reset();
                        self->sent_file_.reset();
                        if (!error) self->finish();
                      });
  }

  void send_piece(std::uint64_t offset, std::size_t size) {
    asio::async_write(stream_, asio::buffer(piece_, size), while_taken(),
                      [self = shared_from_this(), offset, size](beast::error_code error, std::size_t) {
                        if (!error) self->send_file(offset + size);
                      });
  }

  /// Closing a connection that still receives bytes would reset it, and the client might lose the answer.
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
  ScopedCount connection_;  // holds the seat
  Connections::Seat& seat_;
  beast::tcp_stream stream_;
  std::string remote_address_;
  std::string received_;              // this request, and bytes that followed it
  std::optional<ScopedCount> large_;  // set while this request is large
  HttpAnswer answer_;
  std::string piece_;                     // chunk of the file being sent
  std::optional<ScopedCount> sent_file_;  // set while a file is being sent
  std::array<char, 4096> rest_;
  std::string ignored_;
};

}  // namespace

void serve_http(asio::ip::tcp::socket socket, ScopedCount connection, Connections::Seat& seat,
                const HttpContext& context) {
  std::make_shared<HttpSession>(std::move(socket), std::move(connection), seat, context)->start();
}

}  // namespace sslv
