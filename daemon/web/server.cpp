// SPDX-License-Identifier: Apache-2.0
#include "web/server.h"

#include "base/background.h"
#include "base/error.h"
#include "base/log.h"
#include "web/camera_feeds.h"
#include "web/http.h"
#include "web/http_session.h"
#include "web/websocket.h"

#include <array>
#include <atomic>
#include <chrono>
#include <optional>
#include <string_view>
#include <thread>
#include <utility>  // Boost 1.74's asio uses std::exchange without it

#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/write.hpp>

namespace sslv {

namespace asio = boost::asio;
using asio::ip::tcp;
using boost::system::error_code;

namespace {

constexpr std::chrono::milliseconds kAcceptPause{100};

[[noreturn]] void refuse_endpoint(const WebOptions& options, const error_code& error) {
  const std::string port = "/panel/port: " + std::to_string(options.port);
  if (error == asio::error::address_in_use) {
    throw SettingsError(port + " is taken by another program; stop that one or choose another port");
  }
  if (error == asio::error::access_denied) {
    throw SettingsError(port +
                        " is not allowed without privileges; expected 1024 .. 65535, or 0 for any free one");
  }
  throw SettingsError("/panel/address: \"" + options.address + "\" cannot be listened on (" +
                      error.message() + "); expected an address of this computer, or 0.0.0.0 for all");
}

tcp::acceptor listen(asio::io_context& io, const WebOptions& options) {
  error_code error;
  const auto address = asio::ip::make_address(options.address, error);
  if (error) {
    throw SettingsError("/panel/address: \"" + options.address +
                        "\" is not allowed; expected an IP address such as 127.0.0.1, or 0.0.0.0 for all");
  }
  if (options.port < 0 || options.port > 65535) {
    throw SettingsError("/panel/port: " + std::to_string(options.port) +
                        " is not allowed; expected 0 .. 65535");
  }
  const tcp::endpoint endpoint(address, static_cast<std::uint16_t>(options.port));
  tcp::acceptor acceptor(io);
  acceptor.open(endpoint.protocol(), error);
  // A restart need not wait for the connections of the run before to time out.
  if (!error) acceptor.set_option(tcp::acceptor::reuse_address(true), error);
  if (!error) acceptor.bind(endpoint, error);
  if (!error) acceptor.listen(asio::socket_base::max_listen_connections, error);
  if (error) refuse_endpoint(options, error);
  return acceptor;
}

/// Serves a context until it is stopped, whatever its handlers throw.
void run_background(asio::io_context& context, const char* name) {
  become_background_thread(name);
  while (!context.stopped()) {
    try {
      context.run();
    } catch (const std::exception& error) {
      log::error("web: {}", error.what());
    }
  }
}

/// All that runs. Its destructor finishes the requests that are being handled and closes all connections.
class RunningServer {
 public:
  RunningServer(const WebHost& host, std::span<const Route> routes, const WebOptions& options,
                WebCounters& counters)
      : max_connections_(options.max_connections),
        router_(host, routes, options.panel_directory),
        counters_(counters),
        feeds_(host, counters.jpegs_encoded),
        websockets_(io_, workers_, host, feeds_, counters),
        acceptor_(listen(io_, options)),
        pause_(io_) {
    accept();
    io_thread_ = std::thread([this] { run_background(io_, "web"); });
    for (std::thread& thread : worker_threads_) {
      thread = std::thread([this] { run_background(workers_, "web-worker"); });
    }
  }

  ~RunningServer() {
    workers_.stop();
    for (std::thread& thread : worker_threads_) thread.join();
    io_.stop();
    io_thread_.join();
  }

  std::uint16_t port() const { return acceptor_.local_endpoint().port(); }

 private:
  void accept() {
    acceptor_.async_accept([this](error_code error, tcp::socket socket) {
      if (!error) {
        serve(std::move(socket));
        return accept();
      }
      // Out of file descriptors, most likely: some will be free again.
      log::warning("web: a connection could not be accepted: {}", error.message());
      pause_.expires_after(kAcceptPause);
      pause_.async_wait([this](error_code) { accept(); });
    });
  }

  void serve(tcp::socket socket) {
    error_code ignored;
    if (counters_.connections >= max_connections_) {
      // Fits into the empty send buffer.
      asio::write(socket, asio::buffer(refusal_text(503, "too many connections; try again later")), ignored);
      return;
    }
    socket.set_option(tcp::no_delay(true), ignored);
    serve_http(std::move(socket), ScopedCount(counters_.connections), http_);
  }

  const int max_connections_;
  const Router router_;
  WebCounters& counters_;

  // Connections live in the handlers that wait in these two, so they end with them: after the hub and before
  // what stands above.
  asio::io_context io_{1};
  asio::io_context workers_;
  asio::executor_work_guard<asio::io_context::executor_type> keep_workers_{workers_.get_executor()};
  CameraFeeds feeds_;
  WebSocketHub websockets_;
  const HttpContext http_{router_, websockets_, feeds_, workers_};
  tcp::acceptor acceptor_;
  asio::steady_timer pause_;
  std::thread io_thread_;
  std::array<std::thread, 4> worker_threads_;
};

}  // namespace

struct WebServer::Impl {
  Impl(WebHost web_host, std::span<const Route> routes, const WebOptions& options)
      : host(std::move(web_host)),
        running(std::in_place, host, routes, options, counters),
        port(running->port()) {}

  const WebHost host;
  WebCounters counters;
  std::optional<RunningServer> running;
  const std::uint16_t port;
};

WebServer::WebServer(WebHost host, std::span<const Route> routes, const WebOptions& options)
    : impl_(std::make_unique<Impl>(std::move(host), routes, options)) {}

WebServer::~WebServer() = default;

void WebServer::stop() {
  impl_->running.reset();
}

std::uint16_t WebServer::port() const {
  return impl_->port;
}

WebStats WebServer::stats() const {
  return {impl_->counters.connections, impl_->counters.viewers, impl_->counters.jpegs_encoded};
}

}  // namespace sslv
