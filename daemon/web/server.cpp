// SPDX-License-Identifier: Apache-2.0
#include "web/server.h"

#include "base/background.h"
#include "base/clock.h"
#include "base/error.h"
#include "base/log.h"
#include "web/camera_feeds.h"
#include "web/connections.h"
#include "web/http.h"
#include "web/http_session.h"
#include "web/socket.h"
#include "web/websocket.h"

#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <future>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>
#include <utility>  // Boost 1.74's asio uses std::exchange without it

#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/strand.hpp>
#include <boost/asio/write.hpp>

namespace sslv {

namespace asio = boost::asio;
using asio::ip::tcp;
using boost::system::error_code;

namespace {

constexpr std::chrono::milliseconds kAcceptPause{100};
constexpr std::chrono::seconds kAuditPeriod{10};
constexpr double kUnsentPeriod_s = 60;

[[noreturn]] void refuse_endpoint(const std::string& address, int number, const error_code& error) {
  const std::string port = "/panel/port: " + std::to_string(number);
  if (error == asio::error::address_in_use) {
    throw BusyError(port + " is taken by another program; stop that one or choose another port");
  }
  if (error == asio::error::access_denied) {
    throw SettingsError(port +
                        " is not allowed without privileges; expected 1024 .. 65535, or 0 for any free one");
  }
  const std::string problem = "/panel/address: \"" + address + "\" cannot be listened on (" +
                              error.message() + "); expected an address of this computer, or 0.0.0.0 for all";
  // The network card may get its address in a moment.
  if (error == boost::system::errc::address_not_available) throw BusyError(problem);
  throw SettingsError(problem);
}

using ReusePort = asio::detail::socket_option::boolean<SOL_SOCKET, SO_REUSEPORT>;

/// `shares_port`: another socket of this program uses the same port; both share it until the other one
/// closes.
tcp::acceptor listen(asio::io_context& io, const std::string& text, int port, bool shares_port = false) {
  error_code error;
  const auto address = asio::ip::make_address(text, error);
  if (error) {
    throw SettingsError("/panel/address: \"" + text +
                        "\" is not allowed; expected an IP address such as 127.0.0.1, or 0.0.0.0 for all");
  }
  if (port < 0 || port > 65535) {
    throw SettingsError("/panel/port: " + std::to_string(port) + " is not allowed; expected 0 .. 65535");
  }
  const tcp::endpoint endpoint(address, static_cast<std::uint16_t>(port));
  tcp::acceptor acceptor(io);
  acceptor.open(endpoint.protocol(), error);
  // Lets a restart bind the port before the previous run's connections time out.
  if (!error) acceptor.set_option(tcp::acceptor::reuse_address(true), error);
  if (!error && shares_port) acceptor.set_option(ReusePort(true), error);
  if (!error) acceptor.bind(endpoint, error);
  if (!error) acceptor.listen(asio::socket_base::max_listen_connections, error);
  if (error) refuse_endpoint(text, port, error);
  if (shares_port) acceptor.set_option(ReusePort(false), error);
  return acceptor;
}

/// Runs a context until it is stopped, even if handlers throw.
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

/// Accepts connections at an address that can change.
class Listener {
 public:
  using Serve = std::function<void(tcp::socket)>;

  /// `serve` is called by the thread that runs `io`.
  Listener(asio::io_context& io, const std::string& address, int port, Serve serve)
      : io_(io),
        serve_(std::move(serve)),
        acceptor_(listen(io_, address, port)),
        port_(acceptor_.local_endpoint().port()),
        pause_(io_) {
    accept();
  }

  std::uint16_t port() const { return port_; }

  /// See WebServer::move_to().
  std::function<void()> move_to(const std::string& address, int port) {
    // The same port on 127.0.0.1 and on all addresses can be bound simultaneously only if both sockets allow
    // it.
    share_port(true);
    std::shared_ptr<tcp::acceptor> next;
    try {
      next = std::make_shared<tcp::acceptor>(listen(io_, address, port, true));
    } catch (...) {
      share_port(false);
      throw;
    }
    share_port(false);
    return [this, next] {
      std::promise<void> moved;
      asio::post(io_, [&] {
        pause_.cancel();
        serve_those_that_wait();
        acceptor_ = std::move(*next);
        port_ = acceptor_.local_endpoint().port();
        accept();
        moved.set_value();
      });
      moved.get_future().wait();
    };
  }

 private:
  void share_port(bool on) {
    std::promise<void> done;
    asio::post(io_, [&] {
      error_code ignored;
      acceptor_.set_option(ReusePort(on), ignored);
      done.set_value();
    });
    done.get_future().wait();
  }

  /// Serves clients that the kernel has already connected: closing the socket would reset them.
  void serve_those_that_wait() {
    error_code error;
    acceptor_.non_blocking(true, error);
    for (int i = 0; i < asio::socket_base::max_listen_connections && error != asio::error::would_block; ++i) {
      tcp::socket socket(io_);
      acceptor_.accept(socket, error);
      if (!error) serve_(std::move(socket));
    }
  }

  void accept() {
    acceptor_.async_accept([this](error_code error, tcp::socket socket) {
      if (error == asio::error::operation_aborted) return;  // it moved to another address
      if (!error) {
        serve_(std::move(socket));
        return accept();
      }
      // Most likely out of file descriptors; some will be freed.
      log::warning("web: a connection could not be accepted: {}", error.message());
      pause_.expires_after(kAcceptPause);
      pause_.async_wait([this](error_code stopped) {
        if (!stopped) accept();
      });
    });
  }

  asio::io_context& io_;
  const Serve serve_;
  tcp::acceptor acceptor_;  // used by the thread that runs `io`
  std::atomic<std::uint16_t> port_;
  asio::steady_timer pause_;
};

/// Executors of handlers: `io` for sockets, `workers` for requests, `quick` for requests that never wait.
struct Executors {
  asio::io_context io{1};
  asio::io_context workers, quick{1};
  asio::strand<asio::io_context::executor_type> one_by_one{workers.get_executor()};
  asio::executor_work_guard<asio::io_context::executor_type> keep_workers{workers.get_executor()};
  asio::executor_work_guard<asio::io_context::executor_type> keep_quick{quick.get_executor()};
};

struct ServerThreads {
  std::thread io;
  std::array<std::thread, 4> workers;
  std::thread quick;
};

/// Everything that runs. The destructor finishes the requests being handled and closes all connections.
class RunningServer {
 public:
  RunningServer(const WebParts& parts, const WebOptions& options, WebCounters& counters)
      : gate_(parts.gate),
        router_(parts.gate, parts.routes, options.panel_directory, stop_.get_token()),
        counters_(counters),
        connections_(options.max_connections, steady_s, counters.unsent),
        feeds_(parts.views, counters.jpegs_encoded),
        websockets_(executors_.io, executors_.quick, parts.views, parts.topics, feeds_, counters),
        listener_(executors_.io, options.address, options.port,
                  [this](tcp::socket socket) { serve(std::move(socket)); }),
        audit_timer_(executors_.io) {
    write_audit();
    threads_.io = std::thread([this] { run_background(executors_.io, "web"); });
    for (std::thread& thread : threads_.workers) {
      thread = std::thread([this] { run_background(executors_.workers, "web-worker"); });
    }
    threads_.quick = std::thread([this] { run_background(executors_.quick, "web-quick"); });
  }

  ~RunningServer() {
    ask_to_stop();
    for (std::thread& thread : threads_.workers) thread.join();
    threads_.quick.join();
    executors_.io.stop();
    threads_.io.join();
  }

  void ask_to_stop() {
    stop_.request_stop();
    executors_.workers.stop();
    executors_.quick.stop();
    asio::post(executors_.io, [this] { feeds_.ask_to_stop(); });
  }

  std::uint16_t port() const { return listener_.port(); }

  std::function<void()> move_to(const std::string& address, int port) {
    return listener_.move_to(address, port);
  }

 private:
  void serve(tcp::socket socket) {
    error_code ignored;
    const std::string address = remote_address(socket);
    std::string problem;
    auto seat = connections_.admit(address, gate_.is_trusted(address), problem);
    if (!seat) {
      // Does not block: it fits into the empty send buffer.
      asio::write(socket, asio::buffer(refusal_text(503, problem)), ignored);
      return;
    }
    socket.set_option(tcp::no_delay(true), ignored);
    Connections::Seat& held = *seat;
    serve_http(std::move(socket), ScopedCount(counters_.connections, std::move(seat)), held, http_);
  }

  /// Runs periodically, so that counts are logged even without new requests.
  void write_audit() {
    audit_timer_.expires_after(kAuditPeriod);
    audit_timer_.async_wait([this](error_code stopped) {
      if (stopped) return;
      router_.write_audit();
      tell_unsent();
      write_audit();
    });
  }

  /// Logs at most one line a minute.
  void tell_unsent() {
    const std::uint64_t all = counters_.unsent;
    const double now_s = steady_s();
    if (all == told_unsent_ || now_s - told_at_s_ < kUnsentPeriod_s) return;
    log::warning(
        "web: {} answers, images or requests were dropped: too much data is waiting for slow clients",
        all - told_unsent_);
    told_unsent_ = all;
    told_at_s_ = now_s;
  }

  Gate& gate_;
  std::stop_source stop_;  // for the requests being handled
  const Router router_;
  WebCounters& counters_;

  Connections connections_;
  std::atomic<int> large_bytes_ = 0, sent_files_ = 0;
  // Handlers that are pending in these contexts own the connections, so connections are destroyed with the
  // contexts: after the hub and before the members above.
  Executors executors_;
  CameraFeeds feeds_;
  WebSocketHub websockets_;
  const HttpContext http_{gate_,
                          router_,
                          websockets_,
                          feeds_,
                          executors_.workers,
                          executors_.quick,
                          executors_.one_by_one,
                          large_bytes_,
                          sent_files_};
  Listener listener_;
  asio::steady_timer audit_timer_;
  std::uint64_t told_unsent_ = counters_.unsent;
  double told_at_s_ = -kUnsentPeriod_s;
  ServerThreads threads_;
};

}  // namespace

struct WebServer::Impl {
  Impl(const WebParts& parts, const WebOptions& options, WebCounters& counters)
      : running(std::in_place, parts, options, counters) {}

  std::optional<RunningServer> running;
};

WebServer::WebServer(const WebParts& parts, const WebOptions& options, WebCounters& counters)
    : impl_(std::make_unique<Impl>(parts, options, counters)) {}

WebServer::~WebServer() = default;

void WebServer::stop() {
  impl_->running.reset();
}

void WebServer::ask_to_stop() {
  if (impl_->running) impl_->running->ask_to_stop();
}

std::uint16_t WebServer::port() const {
  return impl_->running->port();
}

std::function<void()> WebServer::move_to(const std::string& address, int port) {
  return impl_->running->move_to(address, port);
}

}  // namespace sslv
