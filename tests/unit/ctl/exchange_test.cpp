// SPDX-License-Identifier: Apache-2.0
// ssl-visionctl must cope with any server at the daemon's address.
#include "ctl/exchange.h"

#include "ctl/client.h"
#include "support/patience.h"

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

namespace sslv::exchange_test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

/// Answers every connection in the same way: reads the request up to the end of its header, then calls
/// `answer`.
class Server {
 public:
  /// Sends a part of the answer. Returns false once the client has disconnected.
  using Send = std::function<bool(std::string_view)>;

  explicit Server(std::function<void(const Send&)> answer)
      : answer_(std::move(answer)), listener_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    ::bind(listener_, reinterpret_cast<const sockaddr*>(&address), size);
    ::listen(listener_, 16);
    ::getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &size);
    port_ = ntohs(address.sin_port);
    thread_ = std::thread([this] { serve(); });
  }
  ~Server() {
    ::shutdown(listener_, SHUT_RDWR);
    thread_.join();
    ::close(listener_);
  }

  std::string address() const { return "http://127.0.0.1:" + std::to_string(port_); }
  const std::string& asked() const { return asked_; }  // valid once the request is answered

 private:
  void serve() {
    for (;;) {
      const int socket = ::accept(listener_, nullptr, nullptr);
      if (socket < 0) return;
      asked_.clear();
      char bytes[4096];
      while (asked_.find("\r\n\r\n") == std::string::npos) {
        const ssize_t got = ::recv(socket, bytes, sizeof bytes, 0);
        if (got <= 0) break;
        asked_.append(bytes, static_cast<std::size_t>(got));
      }
      answer_([&](std::string_view part) {
        while (!part.empty()) {
          const ssize_t sent = ::send(socket, part.data(), part.size(), MSG_NOSIGNAL);
          if (sent <= 0) return false;
          part.remove_prefix(static_cast<std::size_t>(sent));
        }
        char ignored;
        return ::recv(socket, &ignored, 1, MSG_PEEK | MSG_DONTWAIT) != 0;
      });
      ::close(socket);
    }
  }

  const std::function<void(const Send&)> answer_;
  const int listener_;
  std::uint16_t port_ = 0;
  std::string asked_;
  std::thread thread_;
};

std::string refusal(const std::function<void()>& act) {
  try {
    act();
  } catch (const std::exception& error) {
    return error.what();
  }
  return "not refused";
}

ExchangeLimits small() {
  ExchangeLimits limits;
  limits.body_bytes = 1 << 20;
  limits.connect = limits.header = limits.whole = test::kPatience;
  return limits;
}

Server answering(const std::string& bytes) {
  return Server([bytes](const Server::Send& send) { send(bytes); });
}

TEST(Exchange, BringsStatusBodyAndCookie) {
  const Server server = answering(
      "HTTP/1.1 201 Created\r\nSet-Cookie: a=b; HttpOnly\r\nContent-Encoding: gzip\r\nContent-Length: "
      "5\r\n\r\nhello");
  const HttpReply reply = http_exchange(server.address(), {"POST", "/x?y", {{"If-Match", "7"}}, "[1]"});
  EXPECT_EQ(reply.status, 201);
  EXPECT_EQ(reply.body, "hello") << "as it came: nothing is unpacked";
  EXPECT_EQ(reply.set_cookie, "a=b; HttpOnly");
}

TEST(Exchange, AsksAsAClientDoes) {
  std::string address;
  {
    Server server = answering("HTTP/1.1 200 OK\r\n\r\nto the end");
    EXPECT_EQ(http_exchange(server.address() + "/", {"GET", "/x"}).body, "to the end");
    EXPECT_THAT(server.asked(), AllOf(StartsWith("GET /x HTTP/1.1\r\n"), HasSubstr("Host: 127.0.0.1:"),
                                      HasSubstr("Connection: close\r\n")));
    address = server.address();
  }
  EXPECT_THAT(refusal([&] {
                http_exchange(address, {"GET", "/"});
              }),
              StartsWith("no daemon answers at " + address + " (Connection refused); is it running"));
}

TEST(Exchange, AddressesAreReadStrictly) {
  for (const char* address : {"", "http://", "http://a b", "http://a:", "http://a:x", "http://a:1:2",
                              "https://a", "http://[::1", "http://[::1]x", "http://u@a", "http://a/b"}) {
    EXPECT_THAT(refusal([&] {
                  http_exchange(address, {"GET", "/"});
                }),
                HasSubstr("is not an address"))
        << address;
  }
}

TEST(Exchange, AnAnswerWithoutEndIsNotReadToItsEnd) {
  const std::string megabyte(1 << 20, 'x');
  const auto endless = [&](std::string head, std::string part) {
    return Server([head = std::move(head), part = std::move(part)](const Server::Send& send) {
      for (bool more = send(head); more;) more = send(part);
    });
  };
  const auto refused_by = [](const Server& server) {
    return refusal([&] { http_exchange(server.address(), {"GET", "/"}, small()); });
  };
  EXPECT_THAT(refused_by(endless("HTTP/1.1 200 OK\r\n\r\n", megabyte)), HasSubstr("sends more than 1 MiB"));
  EXPECT_THAT(refused_by(endless("HTTP/1.1 200 OK\r\nTransfer-Encoding: chunked\r\n\r\n",
                                 "100000\r\n" + megabyte + "\r\n")),
              HasSubstr("sends more than 1 MiB"));
  EXPECT_THAT(refused_by(endless("HTTP/1.1 200 OK\r\nContent-Length: 99999999999\r\n\r\n", megabyte)),
              HasSubstr("sends more than 1 MiB"));
  EXPECT_THAT(refused_by(endless("HTTP/1.1 200 OK\r\n", "X: y\r\n")), HasSubstr("header that is too long"));
  EXPECT_THAT(refused_by(endless("HTTP/1.1 200 ", megabyte)), HasSubstr("too long"));
}

TEST(Exchange, ALargeFileComesInPieces) {
  const std::string part(100'000, 'x');
  std::string got;
  std::size_t pieces = 0;
  const auto take = [&](std::string_view piece) {
    got += piece;
    ++pieces;
  };
  const auto of = [&](const std::string& head) {
    return Server([&part, head](const Server::Send& send) {
      bool more = send(head);
      for (int i = 0; i < 30 && more; ++i) more = send(part);
    });
  };
  const Server server = of("HTTP/1.1 200 OK\r\nContent-Length: 3000000\r\n\r\n");
  const ExchangeLimits limits = small();
  const HttpReply reply = http_exchange(server.address(), {"GET", "/"}, take, limits);
  EXPECT_EQ(reply.body, "");
  EXPECT_EQ(got, std::string(3'000'000, 'x')) << "more than a body may be that is held in memory";
  EXPECT_GT(pieces, 1U);

  const Server cut = of("HTTP/1.1 200 OK\r\nContent-Length: 4000000\r\n\r\n");
  EXPECT_THAT(refusal([&] {
                http_exchange(cut.address(), {"GET", "/"}, take, limits);
              }),
              HasSubstr("partial message"));
  const Server full = of("HTTP/1.1 200 OK\r\nContent-Length: 3000000\r\n\r\n");
  EXPECT_EQ(refusal([&] {
              http_exchange(
                  full.address(), {"GET", "/"}, [](std::string_view) { throw std::runtime_error("full"); },
                  limits);
            }),
            "full");

  got.clear();
  const Server refuses = answering("HTTP/1.1 404 No\r\nContent-Length: 4\r\n\r\nnone");
  EXPECT_EQ(http_exchange(refuses.address(), {"GET", "/"}, take, limits).body, "none");
  EXPECT_EQ(got, "") << "a refusal is no piece of the file";
  const Server long_refusal = of("HTTP/1.1 404 No\r\nContent-Length: 3000000\r\n\r\n");
  EXPECT_THAT(refusal([&] {
                http_exchange(long_refusal.address(), {"GET", "/"}, take, limits);
              }),
              HasSubstr("sends more than 1 MiB"));
}

TEST(Exchange, AnEndlesslySlowAnswerTimesOut) {
  ExchangeLimits limits = small();
  limits.header = limits.whole = std::chrono::milliseconds(300);
  for (const char* head : {"", "HTTP/1.1 200 OK\r\n", "HTTP/1.1 200 OK\r\nContent-Length: 1000000\r\n\r\n"}) {
    const Server server([head](const Server::Send& send) {
      // Single bytes prevent the timeout for silence, so a limit for the whole answer must apply.
      for (bool more = send(head); more;) {
        more = send("x");
        ::poll(nullptr, 0, 10);
      }
    });
    EXPECT_THAT(refusal([&] {
                  http_exchange(server.address(), {"GET", "/"}, limits);
                }),
                HasSubstr("no daemon answers at"))
        << head;
  }
}

TEST(Client, ShowsWordsOfAServerAsText) {
  const std::string body = R"({"error": "no\u001b]0;x\u0007 \u009b \u202e\nssl-visionctl: all is well"})";
  const Server server =
      answering("HTTP/1.1 422 No\r\nContent-Length: " + std::to_string(body.size()) + "\r\n\r\n" + body);
  const Client client(server.address(), std::make_shared<SignIn>());
  EXPECT_EQ(refusal([&] { client.get("/"); }),
            R"(no\u001b]0;x\u0007 \u009b \u202e\u000assl-visionctl: all is well)");
}

TEST(Client, RefusesInvalidAndTooDeepJson) {
  for (const std::string& body : {std::string(500'000, '['), std::string("\x1b[2J"),
                                  std::string(500'000, '[') + std::string(500'000, ']')}) {
    const Server server =
        answering("HTTP/1.1 200 OK\r\nContent-Length: " + std::to_string(body.size()) + "\r\n\r\n" + body);
    const Client client(server.address(), std::make_shared<SignIn>());
    EXPECT_EQ(refusal([&] { client.get_json("/api/x"); }), "/api/x: the answer is not JSON of a daemon");
  }
}

TEST(Client, SendsOnlyUtf8) {
  // Otherwise a password typed in a terminal with another encoding would become another password.
  const Client client("http://127.0.0.1:1", std::make_shared<SignIn>());
  for (const auto& send :
       std::vector<std::function<void(const Json&)>>{[&](const Json& body) { client.post("/", body); },
                                                     [&](const Json& body) { client.put("/", body); },
                                                     [&](const Json& body) { client.patch("/", body); }}) {
    EXPECT_EQ(refusal([&] {
                send({{"password", "gr\xfcn"}});
              }),
              "only UTF-8 can be sent: check your terminal's encoding");
  }
}

}  // namespace
}  // namespace sslv::exchange_test
