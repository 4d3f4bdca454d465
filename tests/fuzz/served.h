// SPDX-License-Identifier: Apache-2.0
#pragma once

// The real web server with a fake daemon, for programs that send it bytes.

#include "fuzz/expect.h"
#include "support/patience.h"
#include "unit/web/fake_host.h"
#include "web/server.h"

#include <string>
#include <string_view>

#include <arpa/inet.h>
#include <sys/socket.h>
#include <unistd.h>

namespace sslv {

class Served {
 public:
  Served() { daemon_.publish(1); }

  /// The server's whole answer to these bytes, until it closes the connection.
  std::string answer(std::string_view bytes) const {
    const int socket = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(server_.port());
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    expect(socket >= 0 && ::connect(socket, reinterpret_cast<const sockaddr*>(&to), sizeof to) == 0,
           "no connection");
    const timeval patience{test::kPatience.count(), 0};
    ::setsockopt(socket, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    for (std::string_view rest = bytes; !rest.empty();) {
      const ssize_t sent = ::send(socket, rest.data(), rest.size(), MSG_NOSIGNAL);
      if (sent <= 0) break;  // the server has stopped reading
      rest.remove_prefix(static_cast<std::size_t>(sent));
    }
    ::shutdown(socket, SHUT_WR);
    std::string out;
    char part[4096];
    for (;;) {
      const ssize_t got = ::recv(socket, part, sizeof part, 0);
      if (got < 0) expect(errno == ECONNRESET, "it does not answer");
      if (got <= 0) break;
      out.append(part, static_cast<std::size_t>(got));
    }
    ::close(socket);
    return out;
  }

  /// Checks that it still serves others.
  void check() const {
    const std::string well =
        answer("GET /api/schema HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n");
    expect(well.starts_with("HTTP/1.1 200 "), "others are not served any more");
  }

 private:
  FakeHost daemon_;
  WebCounters counters_;
  WebServer server_{daemon_.parts(), WebOptions{"127.0.0.1", 0, "/var/empty"}, counters_};
};

}  // namespace sslv
