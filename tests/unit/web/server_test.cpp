// SPDX-License-Identifier: Apache-2.0
#include "web/server.h"

#include "support/becomes.h"
#include "unit/web/fake_host.h"
#include "web/http.h"
#include "web/router.h"

#include <atomic>
#include <future>
#include <stdexcept>

#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <pthread.h>
#include <sys/socket.h>
#include <turbojpeg.h>
#include <unistd.h>

namespace sslv::server_test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

/// A plain TCP client. Reading throws on timeout, so that a failing test does not hang.
class Client {
 public:
  explicit Client(std::uint16_t port, int receive_buffer_bytes = 0) : fd_(::socket(AF_INET, SOCK_STREAM, 0)) {
    const timeval patience{test::kPatience.count(), 0};
    setsockopt(fd_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof(patience));
    if (receive_buffer_bytes > 0) {
      setsockopt(fd_, SOL_SOCKET, SO_RCVBUF, &receive_buffer_bytes, sizeof(receive_buffer_bytes));
    }
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(port);
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    if (::connect(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) != 0) {
      throw std::runtime_error("cannot connect");
    }
  }
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;
  ~Client() { ::close(fd_); }

  void send(std::string_view bytes) {
    while (!bytes.empty()) {
      const ssize_t sent = ::send(fd_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
      if (sent <= 0) return;  // the server may have closed already; its answer is read below
      bytes.remove_prefix(static_cast<std::size_t>(sent));
    }
  }

  std::string read(std::size_t size) {
    while (received_.size() < size) {
      if (!receive()) throw std::runtime_error("closed by the server");
    }
    std::string bytes = received_.substr(0, size);
    received_.erase(0, size);
    return bytes;
  }

  std::string read_header() {
    std::size_t end;
    while ((end = received_.find("\r\n\r\n")) == std::string::npos) {
      if (!receive()) throw std::runtime_error("closed by the server");
    }
    return read(end + 4);
  }

  /// All bytes until the server closes.
  std::string read_to_end() {
    while (receive()) {
    }
    return std::exchange(received_, {});
  }

 private:
  bool receive() {
    char bytes[65536];
    const ssize_t size = ::recv(fd_, bytes, sizeof(bytes), 0);
    if (size < 0 && (errno == EAGAIN || errno == EWOULDBLOCK)) throw std::runtime_error("nothing came");
    if (size <= 0) return false;
    received_.append(bytes, static_cast<std::size_t>(size));
    return true;
  }

  int fd_;
  std::string received_;
};

struct Answer {
  int status;
  std::string header, body;
};

Answer read_answer(Client& client, bool has_body = true) {
  Answer answer;
  answer.header = client.read_header();
  answer.status = std::stoi(answer.header.substr(std::string_view("HTTP/1.1 ").size()));
  const std::size_t length = answer.header.find("Content-Length: ");
  if (has_body && length != std::string::npos)
    answer.body = client.read(std::stoul(answer.header.substr(length + 16)));
  return answer;
}

std::string request_text(const std::string& method, const std::string& target,
                         const std::string& more_headers = {}, const std::string& body = {}) {
  return method + " " + target + " HTTP/1.1\r\nHost: test\r\n" + more_headers +
         (body.empty() ? "" : "Content-Length: " + std::to_string(body.size()) + "\r\n") + "\r\n" + body;
}

Answer ask(Client& client, const std::string& method, const std::string& target,
           const std::string& more_headers = {}, const std::string& body = {}) {
  client.send(request_text(method, target, more_headers, body));
  return read_answer(client, method != "HEAD");
}

std::string upgrade_text(const std::string& more_headers = {}) {
  // Key and answer are the example of RFC 6455, section 1.3.
  return request_text("GET", "/api/ws",
                      "Connection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n"
                      "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n" +
                          more_headers);
}

/// A WebSocket viewer: as much of RFC 6455 as the tests need.
class Viewer {
 public:
  explicit Viewer(std::uint16_t port, int receive_buffer_bytes = 0) : client_(port, receive_buffer_bytes) {
    client_.send(upgrade_text("Origin: http://test\r\n"));
    const std::string header = client_.read_header();
    EXPECT_THAT(header, AllOf(StartsWith("HTTP/1.1 101"), HasSubstr("s3pPLMBiTxaQ9kYGzzhZRbK+xOo=")));
  }

  void send(const std::string& text) { client_.send(frame(0x81, text)); }

  struct Message {
    bool is_binary;
    std::string bytes;
  };

  /// The next message; pings are answered.
  Message read() {
    for (;;) {
      const std::string start = client_.read(2);
      const int opcode = start[0] & 0x0f;
      EXPECT_EQ(start[0] & 0x80, 0x80) << "a message in several frames";
      std::size_t size = static_cast<unsigned char>(start[1]);
      if (size >= 126) {
        const std::string length = client_.read(size == 126 ? 2 : 8);
        size = 0;
        for (const char byte : length) size = size << 8 | static_cast<unsigned char>(byte);
      }
      std::string payload = client_.read(size);
      if (opcode == 1 || opcode == 2) return {opcode == 2, std::move(payload)};
      if (opcode == 8) throw std::runtime_error("closed by the server");
      if (opcode == 9) client_.send(frame(0x8a, payload));
    }
  }

  /// The next message, which must be a text.
  Json read_json() {
    const Message message = read();
    if (message.is_binary) throw std::runtime_error("a picture came and no text");
    return Json::parse(message.bytes);
  }

  struct Picture {
    Json header;
    std::string jpeg;
  };

  /// The next message, which must be an image.
  Picture read_picture() {
    const Message message = read();
    if (!message.is_binary) throw std::runtime_error("a text came and no picture: " + message.bytes);
    std::size_t length = 0;
    for (int i = 3; i >= 0; --i) length = length << 8 | static_cast<unsigned char>(message.bytes.at(i));
    return {Json::parse(message.bytes.substr(4, length)), message.bytes.substr(4 + length)};
  }

  void acknowledge(int frame_number) { send(to_text({{"ack", {{"camera", 0}, {"frame", frame_number}}}})); }

  /// Returns once the server has read everything sent so far.
  void synchronise() {
    send(R"({"nonsense": 1})");
    EXPECT_THAT(to_text(read_json()), HasSubstr("/nonsense: no such message"));
  }

 private:
  /// Masked with zeros, which does not change the text.
  static std::string frame(int first_byte, const std::string& payload) {
    std::string out(1, static_cast<char>(first_byte));
    if (payload.size() < 126) {
      out += static_cast<char>(0x80 | payload.size());
    } else {
      out += static_cast<char>(0x80 | 126);
      out += static_cast<char>(payload.size() >> 8);
      out += static_cast<char>(payload.size() & 0xff);
    }
    return out + std::string(4, '\0') + payload;
  }

  Client client_;
};

std::pair<int, int> size_of(const std::string& jpeg) {
  const std::unique_ptr<void, decltype(&tjDestroy)> reader(tjInitDecompress(), &tjDestroy);
  int width = 0, height = 0, subsampling = 0, colorspace = 0;
  tjDecompressHeader3(reader.get(), reinterpret_cast<const unsigned char*>(jpeg.data()), jpeg.size(), &width,
                      &height, &subsampling, &colorspace);
  return {width, height};
}

const auto kIsSecured =
    AllOf(HasSubstr("Content-Security-Policy: default-src 'self';"),
          HasSubstr("X-Content-Type-Options: nosniff\r\n"), HasSubstr("Referrer-Policy: no-referrer\r\n"));

class ServerTest : public testing::Test {
 protected:
  static WebOptions options(int port = 0) {
    WebOptions options;
    options.port = port;
    return options;
  }

  FakeHost daemon_;
  WebCounters counters_;
  WebServer server_{daemon_.parts(), options(), counters_};
};

TEST_F(ServerTest, AnswersWithSecurityHeaders) {
  Client client(server_.port());
  const Answer answer = ask(client, "GET", "/api/status");
  EXPECT_EQ(answer.status, 200);
  EXPECT_EQ(answer.body, to_text(daemon_.topic_data()));
  EXPECT_THAT(answer.header, HasSubstr("Content-Type: application/json\r\n"));
  EXPECT_THAT(answer.header, kIsSecured);
  EXPECT_EQ(answer.header.find("Access-Control"), std::string::npos);
}

TEST_F(ServerTest, OneConnectionServesManyRequests) {
  Client client(server_.port());
  EXPECT_EQ(ask(client, "GET", "/api/nothing").status, 404);
  EXPECT_EQ(ask(client, "GET", "/../secret").status, 404);
  EXPECT_EQ(ask(client, "GET", "/%2e%2e%2fsecret").status, 404);
  const Answer head = ask(client, "HEAD", "/api/schema");
  EXPECT_EQ(head.status, 200);
  EXPECT_THAT(head.header, HasSubstr("Content-Length: 17\r\n"));
  EXPECT_EQ(ask(client, "PATCH", "/api/settings", "", "[1]").status, 200);
  EXPECT_EQ(ask(client, "PATCH", "/api/settings", "If-Match: 6\r\n", "[1]").status, 409);
  EXPECT_EQ(ask(client, "PATCH", "/api/settings", "Origin: http://evil.example\r\n", "[1]").status, 403);
  EXPECT_EQ(ask(client, "GET", "/api/ws").status, 426);
  EXPECT_EQ(daemon_.last_author(), "127.0.0.1");
}

TEST_F(ServerTest, RequestsSentTogetherAreAnsweredInOrder) {
  Client client(server_.port());
  client.send(request_text("GET", "/api/schema") + request_text("PATCH", "/api/settings", "", "{") +
              request_text("GET", "/api/cameras"));
  EXPECT_EQ(read_answer(client).body, R"({"type":"object"})");
  EXPECT_EQ(read_answer(client).status, 400);
  EXPECT_EQ(read_answer(client).body, R"([{"id":0}])");
}

TEST_F(ServerTest, BodiesMayComeInParts) {
  Client client(server_.port()), other(server_.port());
  client.send("PATCH /api/settings HTTP/1.1\r\nContent-Le");
  EXPECT_EQ(ask(other, "GET", "/api/schema").status, 200);
  client.send("ngth: 3\r\n\r\n[");
  EXPECT_EQ(ask(other, "GET", "/api/schema").status, 200);
  client.send("7]" + request_text("GET", "/api/schema"));
  EXPECT_THAT(read_answer(client).body, HasSubstr("[7]"));
  EXPECT_EQ(read_answer(client).body, R"({"type":"object"})");
}

TEST_F(ServerTest, ManyLargeRequestsMayBeSentTogether) {
  const std::string patch = "[\"" + std::string(40'000, 'x') + "\"]";
  Client client(server_.port());
  std::string requests;
  for (int i = 0; i < 5; ++i)
    requests += request_text("PATCH", "/api/settings", "", patch) + request_text("GET", "/api/schema");
  client.send(requests);
  for (int i = 0; i < 5; ++i) {
    EXPECT_THAT(read_answer(client).body, HasSubstr(patch));
    EXPECT_EQ(read_answer(client).body, R"({"type":"object"})");
  }
}

TEST_F(ServerTest, LargeUploadsTogetherAreLimited) {
  const std::string body(3 << 20, ' '), request = request_text("POST", "/api/file", "", body);
  const std::string half = request.substr(0, request.size() / 2), rest = request.substr(half.size());
  Client first(server_.port()), second(server_.port());
  first.send(half);
  second.send(half);
  EXPECT_TRUE(test::becomes([&] {
    Client third(server_.port());
    third.send(request);
    return read_answer(third).status == 503;
  }));
  for (Client* client : {&first, &second}) {
    client->send(rest);
    EXPECT_EQ(read_answer(*client).status, 200);
  }
  Client alone(server_.port());
  EXPECT_EQ(ask(alone, "POST", "/api/file", "", std::string(8 << 20, ' ')).status, 200) << "as large as any";
}

TEST_F(ServerTest, ManyClientsAreServedAtOnce) {
  std::vector<std::unique_ptr<Client>> clients;
  for (int i = 0; i < 8; ++i) clients.push_back(std::make_unique<Client>(server_.port()));
  for (int round = 0; round < 20; ++round) {
    for (const auto& client : clients)
      client->send(request_text("GET", "/api/schema") + request_text("PATCH", "/api/settings", "", "[1]"));
  }
  for (int round = 0; round < 20; ++round) {
    for (const auto& client : clients) {
      EXPECT_EQ(read_answer(*client).body, R"({"type":"object"})");
      EXPECT_THAT(read_answer(*client).body, HasSubstr("[1]"));
    }
  }
}

TEST_F(ServerTest, LargeFilesAreSentWhole) {
  daemon_.set_file(std::vector<std::uint8_t>(2 * 1024 * 1024, 7));
  Client client(server_.port());
  for (int i = 0; i < 2; ++i) {
    EXPECT_EQ(ask(client, "GET", "/api/file/table").body, std::string(2 * 1024 * 1024, 7));
  }
}

TEST_F(ServerTest, ChunkedBodiesAreRefused) {
  Client client(server_.port());
  client.send(
      "PATCH /api/settings HTTP/1.1\r\nHost: test\r\nTransfer-Encoding: "
      "chunked\r\n\r\n1\r\n[\r\n2\r\n7]\r\n0\r\n\r\n");
  EXPECT_THAT(client.read_to_end(),
              AllOf(StartsWith("HTTP/1.1 411"), HasSubstr("expected a Content-Length"), kIsSecured));
  EXPECT_EQ(daemon_.last_author(), "");
}

TEST_F(ServerTest, ClosesWhenTheClientAsksForIt) {
  Client client(server_.port());
  client.send(request_text("GET", "/api/schema", "Connection: close\r\n"));
  EXPECT_THAT(client.read_to_end(), AllOf(StartsWith("HTTP/1.1 200"), HasSubstr("Connection: close\r\n"),
                                          HasSubstr(R"({"type":"object"})")));

  Client old(server_.port());
  old.send("GET /api/schema HTTP/1.0\r\n\r\n");
  EXPECT_THAT(old.read_to_end(), AllOf(StartsWith("HTTP/1.1 200"), HasSubstr(R"({"type":"object"})")));
}

TEST_F(ServerTest, TooLargeRequestsAreRefused) {
  Client body(server_.port());
  body.send(request_text("PATCH", "/api/settings", "", std::string(1024 * 1024 + 1, ' ')));
  EXPECT_THAT(body.read_to_end(), AllOf(StartsWith("HTTP/1.1 413"), HasSubstr("{\"error\":"), kIsSecured));

  Client address(server_.port());
  address.send(request_text("GET", "/api/file/" + std::string(8000, '1')));
  EXPECT_THAT(address.read_to_end(), AllOf(StartsWith("HTTP/1.1 414"), kIsSecured));

  Client range(server_.port());
  range.send(request_text("GET", "/", "Range: bytes=" + std::string(8000, '1') + "-\r\n"));
  EXPECT_THAT(range.read_to_end(), StartsWith("HTTP/1.1 414"));

  Client header(server_.port());
  header.send(request_text("GET", "/api/status", "X-Long: " + std::string(17 * 1024, 'x') + "\r\n"));
  EXPECT_THAT(header.read_to_end(), AllOf(StartsWith("HTTP/1.1 431"), HasSubstr("{\"error\":"), kIsSecured));

  Client endless(server_.port());
  endless.send("GET /" + std::string(20 * 1024, 'x'));
  EXPECT_THAT(endless.read_to_end(), StartsWith("HTTP/1.1 431"));
}

TEST_F(ServerTest, LargeBodiesNeedSigningIn) {
  daemon_.passwords().set(Role::kAdmin, "correct horse");
  Client large(server_.port());  // never sends the body
  large.send("POST /api/session HTTP/1.1\r\nHost: test\r\nContent-Length: 16385\r\n\r\n");
  EXPECT_THAT(large.read_to_end(), AllOf(StartsWith("HTTP/1.1 401"),
                                         HasSubstr("sign in with the admin's password first"), kIsSecured));
  Client small(server_.port());
  EXPECT_EQ(ask(small, "POST", "/api/session", "", "[" + std::string(16382, ' ') + "]").status, 500)
      << "it was read";
  const Answer signed_in = ask(small, "POST", "/api/session", "", R"({"password": "correct horse"})");
  ASSERT_EQ(signed_in.status, 200);
  const std::size_t at = signed_in.header.find("session=");
  const std::string cookie = signed_in.header.substr(at, signed_in.header.find(';', at) - at);
  EXPECT_EQ(ask(small, "PATCH", "/api/settings", "Cookie: " + cookie + "\r\n",
                "[1" + std::string(100'000, ' ') + "]")
                .status,
            200);
}

TEST_F(ServerTest, UnreadAnswersAreLimited) {
  constexpr std::size_t kBytes =
      6 * 1024 * 1024;  // more than the kernel buffers for a client that reads nothing
  constexpr int kClients = 40, kMaxWaiting = static_cast<int>(Connections::kMaxUnsentBytesOfTrusted / kBytes);
  daemon_.set_file(std::vector<std::uint8_t>(kBytes, 7));
  {
    std::vector<std::unique_ptr<Client>> slow;
    for (int i = 0; i < kClients; ++i) {
      slow.push_back(std::make_unique<Client>(server_.port(), 4096));
      slow.back()->send(request_text("GET", "/api/file/table"));
    }
    // All clients except those that now wait were refused, or closed to make room for another.
    EXPECT_TRUE(test::becomes([&] { return counters_.unsent >= kClients - kMaxWaiting; }))
        << counters_.unsent;
    Client monitoring(server_.port());
    EXPECT_EQ(ask(monitoring, "GET", "/healthz").status, 200);
  }
  EXPECT_TRUE(test::becomes([&] {
    Client client(server_.port());
    return ask(client, "GET", "/api/file/table").status == 200;
  }));
}

TEST_F(ServerTest, IncompleteBodiesAreLimited) {
  constexpr int kClients = 40,
                kMaxWaiting = static_cast<int>(Connections::kMaxUnsentBytesOfTrusted / kMaxBodyBytes);
  std::vector<std::unique_ptr<Client>> half;
  for (int i = 0; i < kClients; ++i) {
    half.push_back(std::make_unique<Client>(server_.port()));
    half.back()->send("PATCH /api/settings HTTP/1.1\r\nHost: test\r\nContent-Length: " +
                      std::to_string(kMaxBodyBytes) + "\r\n\r\n[1");
  }
  EXPECT_TRUE(test::becomes([&] { return counters_.unsent >= kClients - kMaxWaiting; })) << counters_.unsent;
  Client monitoring(server_.port());
  EXPECT_EQ(ask(monitoring, "GET", "/healthz").status, 200);
  half.clear();
  EXPECT_TRUE(test::becomes([&] { return counters_.connections == 1; }));
  const std::string body = "[1" + std::string(kMaxBodyBytes - 3, ' ') + "]";
  for (int i = 0; i < 2 * kMaxWaiting; ++i)
    ASSERT_EQ(ask(monitoring, "PATCH", "/api/settings", "", body).status, 200) << i;
}

TEST_F(ServerTest, ViewersThatReadNothingLeaveRoomForOthers) {
  const Json large(std::string(400'000, 'x'));
  std::vector<std::unique_ptr<Viewer>> slow;
  for (int i = 0; i < 100; ++i) {
    slow.push_back(std::make_unique<Viewer>(server_.port(), 4096));
    slow.back()->send(R"({"subscribe": ["detections"]})");
    slow.back()->synchronise();
  }
  int frame = 0;
  EXPECT_TRUE(test::becomes([&] {
    daemon_.publish(++frame, large);
    return counters_.unsent > 0;
  }));
  Viewer quick(server_.port());
  quick.send(R"({"subscribe": ["detections"], "preview": {"camera": 0, "fps": 1000}})");
  // Some frames are skipped until a slow viewer is closed.
  const std::jthread publisher([&](const std::stop_token& stop) {
    for (; !stop.stop_requested(); std::this_thread::sleep_for(std::chrono::milliseconds(1)))
      daemon_.publish(++frame, large);
  });
  for (bool has_detections = false, has_picture = false; !has_detections || !has_picture;) {
    const Viewer::Message message = quick.read();
    has_picture |= message.is_binary;
    has_detections |= !message.is_binary;
  }
}

TEST_F(ServerTest, GarbageClosesThatConnectionOnly) {
  Client other(server_.port());
  EXPECT_EQ(ask(other, "GET", "/api/status").status, 200);
  for (const std::string& garbage :
       {std::string("\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03", 11), std::string("\r\n\r\nhello\r\n\r\n"),
        std::string(5000, '\0'), std::string("GET / HTTP/9.9\r\n\r\n"),
        std::string("PATCH /api/settings HTTP/1.1\r\nContent-Length: -1\r\n\r\n"),
        std::string("PATCH /api/settings HTTP/1.1\r\nContent-Length: 1x\r\n\r\n[1]"),
        std::string("PATCH /api/settings HTTP/1.1\r\nContent-Length: 99999999999999999999\r\n\r\n"),
        std::string("PATCH /api/settings HTTP/1.1\r\nContent-Length : 3\r\n\r\n[1]"),
        std::string("PATCH /api/settings HTTP/1.1\r\nContent-Length: 1\r\nContent-Length: 2\r\n\r\n")}) {
    Client client(server_.port());
    client.send(garbage);
    EXPECT_THAT(client.read_to_end(), AllOf(StartsWith("HTTP/1.1 400"), kIsSecured));
  }
  EXPECT_EQ(ask(other, "GET", "/api/status").status, 200);
}

TEST_F(ServerTest, IdleAndHalfOpenConnectionsDelayNobody) {
  std::vector<std::unique_ptr<Client>> idle;
  for (int i = 0; i < 200; ++i) {
    idle.push_back(std::make_unique<Client>(server_.port()));
    ASSERT_EQ(ask(*idle.back(), "GET", "/api/schema").status, 200);
  }
  for (int i = 0; i < 50; ++i) {
    idle.push_back(std::make_unique<Client>(server_.port()));
    idle.back()->send(i % 2 == 0 ? "GET /api/sta"
                                 : "PATCH /api/settings HTTP/1.1\r\nContent-Length: 10\r\n\r\n[");
  }
  Client fresh(server_.port());
  EXPECT_EQ(ask(fresh, "GET", "/api/status").status, 200);
  EXPECT_EQ(ask(*idle.front(), "GET", "/api/status").status, 200);
  EXPECT_EQ(counters_.connections, 251);
}

TEST_F(ServerTest, RequestsThatHangKeepNobodyFromTheServicesHealth) {
  std::vector<std::unique_ptr<Client>> hanging;
  for (int i = 0; i < 8; ++i) {  // more than there are workers
    hanging.push_back(std::make_unique<Client>(server_.port()));
    hanging.back()->send(request_text("GET", "/api/hangs"));
  }
  Client monitoring(server_.port());
  EXPECT_EQ(ask(monitoring, "GET", "/healthz").status, 200);
  EXPECT_EQ(ask(monitoring, "HEAD", "/readyz?x=1").status, 503);
  daemon_.let_go();
}

TEST_F(ServerTest, LargeRequestsTakeOneWorkerAtMost) {
  std::vector<std::unique_ptr<Client>> hanging;
  for (int i = 0; i < 8; ++i) {  // more than there are workers
    hanging.push_back(std::make_unique<Client>(server_.port()));
    hanging.back()->send(request_text("GET", "/api/hangs", "", std::string(kLargeRequestBytes, ' ')));
  }
  Client other(server_.port());
  EXPECT_EQ(ask(other, "GET", "/api/schema").status, 200);
  daemon_.let_go();
  for (const auto& client : hanging) EXPECT_EQ(read_answer(*client).status, 200);
  EXPECT_EQ(daemon_.most_hanging(), 1);
}

TEST_F(ServerTest, TurnsAwayTooManyConnections) {
  WebOptions small = options();
  small.max_connections = 2;
  WebServer server(daemon_.parts(), small, counters_);
  Viewer first(server.port()), second(server.port());
  Client third(server.port());
  EXPECT_THAT(third.read_to_end(), AllOf(StartsWith("HTTP/1.1 503"), kIsSecured));
  first.synchronise();
  second.synchronise();
}

TEST_F(ServerTest, ThousandsOfHalfRequestsKeepNobodyOut) {
  WebOptions small = options();
  small.max_connections = 16;
  WebServer server(daemon_.parts(), small, counters_);
  std::vector<std::unique_ptr<Client>> half;
  for (int i = 0; i < 2000; ++i) {
    half.push_back(std::make_unique<Client>(server.port()));
    half.back()->send(i % 3 == 0   ? ""
                      : i % 3 == 1 ? "GET /api/sta"
                                   : "POST /api/x HTTP/1.1\r\nContent-Length: 9\r\n\r\n");
    if (half.size() > 100) half.erase(half.begin());
    if (i % 100 != 99) continue;
    Client monitor(server.port());
    ASSERT_EQ(ask(monitor, "GET", "/healthz").status, 200) << i;
  }
}

TEST_F(ServerTest, RepeatedHeadersAreRefused) {
  const std::string range = "Range: bytes=0-1\r\n",
                    long_range = "Range: bytes=" + std::string(8000, '1') + "-\r\n";
  for (const auto& [headers, status] : {std::pair(range + long_range, "414"),
                                        {long_range + range, "414"},
                                        {"Range: \r\n" + long_range, "414"},
                                        {range + range, "400"},
                                        {"Host: localhost\r\n", "400"},
                                        {"Cookie: a=b\r\nCOOKIE: c=d\r\n", "400"},
                                        {"Origin: http://test\r\nOrigin: http://test\r\n", "400"},
                                        {"If-Match: 7\r\nIf-Match: 6\r\n", "400"},
                                        {"Content-Length: 0\r\nContent-Length: 0\r\n", "400"},
                                        {"X: a\r\n Range: b\r\n", "400"},
                                        {"X: a\r\n\tRange: b\r\n", "400"},
                                        {"Transfer-Encoding: identity\r\n", "411"},
                                        {"Transfer-Encoding: \r\nTransfer-Encoding: chunked\r\n", "411"}}) {
    Client client(server_.port());
    client.send(request_text("GET", "/api/schema", headers));
    EXPECT_THAT(client.read_to_end(),
                AllOf(StartsWith(std::string("HTTP/1.1 ") + status), HasSubstr("{\"error\":"), kIsSecured))
        << headers.substr(0, 60);
  }
  Client client(server_.port());
  EXPECT_EQ(ask(client, "GET", "/api/schema", range).status, 200);
  EXPECT_EQ(ask(client, "GET", "/api/schema", "Accept: a\r\nAccept: b\r\n").status, 200);
}

TEST_F(ServerTest, AnAddressThatCannotBeListenedOnIsOneClearLine) {
  const auto refusal = [&](const WebOptions& wanted) -> std::string {
    try {
      const WebServer server(daemon_.parts(), wanted, counters_);
    } catch (const BusyError& error) {
      return std::string("for now: ") + error.what();
    } catch (const SettingsError& error) {
      return error.what();
    }
    return "not refused";
  };
  const std::string port = std::to_string(server_.port());
  EXPECT_THAT(refusal(options(server_.port())),
              StartsWith("for now: /panel/port: " + port + " is taken by another program"));
  EXPECT_THAT(refusal(options(65536)), StartsWith("/panel/port: 65536 is not allowed"));
  WebOptions elsewhere = options();
  elsewhere.address = "192.0.2.1";  // reserved for documentation: no computer has it
  EXPECT_THAT(refusal(elsewhere), StartsWith("for now: /panel/address: \"192.0.2.1\" cannot be listened on"));
  elsewhere.address = "localhost";
  EXPECT_THAT(refusal(elsewhere), StartsWith("/panel/address: \"localhost\" is not allowed"));
}

/// The server moves as after setting a password in the panel; clients that connect meanwhile are served.
TEST_F(ServerTest, ItMovesWithoutLosingWaitingClients) {
  struct SlowHost : FakeHost {
    bool is_trusted(const std::string& address) override {
      if (is_slow.exchange(false)) {
        came.set_value();
        goes_on.get_future().wait();
      }
      return FakeHost::is_trusted(address);
    }
    std::atomic<bool> is_slow = false;
    std::promise<void> came, goes_on;
  } host;
  WebServer server(host.parts(), options(), counters_);
  const std::function<void()> move = server.move_to("0.0.0.0", server.port());
  host.is_slow = true;
  const Client first(server.port());
  host.came.get_future().wait();
  const auto moved = std::async(std::launch::async, move);
  std::vector<std::unique_ptr<Client>> waiting;
  for (int i = 0; i < 8; ++i) {
    waiting.push_back(std::make_unique<Client>(server.port()));
    waiting.back()->send(request_text("GET", "/healthz"));
  }
  host.goes_on.set_value();
  moved.wait();
  for (const auto& client : waiting) EXPECT_EQ(read_answer(*client).status, 200);
}

TEST_F(ServerTest, StopsWithClientsConnected) {
  daemon_.publish(1);
  Client idle(server_.port()), half(server_.port());
  ASSERT_EQ(ask(idle, "GET", "/api/status").status, 200);
  half.send("GET /api");
  Viewer viewer(server_.port());
  viewer.send(R"({"preview": {"camera": 0}})");
  viewer.read_picture();
  server_.stop();
  EXPECT_EQ(idle.read_to_end(), "");
  EXPECT_EQ(half.read_to_end(), "");
  EXPECT_THROW(viewer.read(), std::runtime_error);
}

TEST_F(ServerTest, ViewersFromOtherSitesAreRefused) {
  Client client(server_.port());
  client.send(upgrade_text("Origin: http://evil.example\r\n"));
  EXPECT_THAT(client.read_to_end(), AllOf(StartsWith("HTTP/1.1 403"), kIsSecured));

  Client keyless(server_.port());
  keyless.send(request_text("GET", "/api/ws",
                            "Connection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n"));
  EXPECT_THAT(keyless.read_header(), AllOf(StartsWith("HTTP/1.1 400"), kIsSecured));
}

TEST_F(ServerTest, StatusIsSentToThoseWhoWantIt) {
  Viewer viewer(server_.port());
  viewer.send(R"({"subscribe": ["status"]})");
  for (int i = 0; i < 2; ++i) {
    EXPECT_EQ(viewer.read_json(), Json({{"topic", "status"}, {"data", daemon_.topic_data()}}));
  }
  Viewer second(server_.port());
  second.send(R"({"subscribe": ["status"]})");
  EXPECT_EQ(second.read_json()["topic"], "status");
  EXPECT_EQ(counters_.viewers, 2);
}

/// The daemon's views, with the camera ids that a test gives.
class ViewsOf : public ViewSource {
 public:
  using Ids = std::function<std::vector<std::uint32_t>()>;
  ViewsOf(FakeHost& daemon, Ids ids) : daemon_(daemon), ids_(std::move(ids)) {}
  std::vector<std::uint32_t> camera_ids() const override { return ids_(); }
  std::optional<View> wait_view(std::uint32_t camera_id, std::uint64_t newer_than,
                                std::chrono::milliseconds timeout) override {
    return daemon_.wait_view(camera_id, newer_than, timeout);
  }

 private:
  FakeHost& daemon_;
  const Ids ids_;
};

TEST_F(ServerTest, StatusContinuesWhenACameraIsRemovedMeanwhile) {
  std::atomic<int> looks = 0;
  // Camera 1 exists when the ids are requested, but no longer when its feed is requested.
  ViewsOf views(daemon_, [&] {
    return looks++ % 3 == 0 ? std::vector<std::uint32_t>{0, 1} : std::vector<std::uint32_t>{0};
  });
  WebServer server({daemon_, views, {&daemon_}, daemon_.routes()}, options(), counters_);
  Viewer viewer(server.port());
  viewer.send(R"({"subscribe": ["status", "detections"]})");
  for (int i = 0; i < 3; ++i) EXPECT_EQ(viewer.read_json()["topic"], "status");
  EXPECT_GE(looks, 6);
}

TEST_F(ServerTest, StatusContinuesAfterExceptions) {
  std::atomic<bool> broken = true;
  ViewsOf views(daemon_, [&] {
    if (broken) throw std::runtime_error("broken");
    return std::vector<std::uint32_t>{0};
  });
  WebServer server({daemon_, views, {&daemon_}, daemon_.routes()}, options(), counters_);
  daemon_.publish(5);
  Viewer viewer(server.port());
  viewer.send(R"({"subscribe": ["detections"]})");
  EXPECT_EQ(to_text(viewer.read_json()), R"({"error":"broken"})");
  viewer.send(R"({"subscribe": ["status"]})");
  for (int i = 0; i < 3; ++i) EXPECT_EQ(viewer.read_json()["topic"], "status");
  broken = false;
  while (viewer.read_json()["topic"] != "detections") {
  }
}

/// While it exists, no thread can start: there is no memory for its stack.
class NoMoreThreads {
 public:
  NoMoreThreads() {
    pthread_getattr_default_np(&before_);
    pthread_attr_t huge;
    pthread_attr_init(&huge);
    pthread_attr_setstacksize(&huge, std::size_t{1} << 50);
    pthread_setattr_default_np(&huge);
    pthread_attr_destroy(&huge);
  }
  ~NoMoreThreads() { pthread_setattr_default_np(&before_); }

 private:
  pthread_attr_t before_{};
};

TEST_F(ServerTest, StatusGoesOnWhenAThreadCannotStart) {
  daemon_.publish(5);
  Viewer viewer(server_.port()), other(server_.port());
  {
    const NoMoreThreads none;
    viewer.send(R"({"subscribe": ["status", "detections"]})");
    for (int i = 0; i < 3; ++i) EXPECT_EQ(viewer.read_json()["topic"], "status");
    other.send(R"({"preview": {"camera": 0}})");
    EXPECT_THAT(to_text(other.read_json()), StartsWith("{\"error\":"));
    other.send(R"({"unsubscribe": ["detections"]})");  // feeds that do not exist
    other.synchronise();
  }
  while (viewer.read_json()["topic"] != "detections") {
  }
}

TEST_F(ServerTest, MessagesThatAreNotUnderstoodAreAnsweredWithAnError) {
  Viewer viewer(server_.port());
  const auto answer_to = [&](const std::string& text) {
    viewer.send(text);
    return to_text(viewer.read_json().at("error"));
  };
  EXPECT_THAT(answer_to("hello"), HasSubstr("not JSON"));
  EXPECT_THAT(answer_to("[]"), HasSubstr("expected an object"));
  EXPECT_THAT(answer_to(R"({"subscribe": "status"})"), HasSubstr("expected a list of topics"));
  EXPECT_THAT(answer_to(R"({"subscribe": ["weather"]})"), HasSubstr("weather"));
  EXPECT_THAT(answer_to(R"({"preview": {"camera": 5}})"), HasSubstr("no camera 5"));
  EXPECT_THAT(answer_to(R"({"preview": {"camera": 0, "quality": 0}})"), HasSubstr("/preview/quality: 0"));
  EXPECT_THAT(answer_to(R"({"preview": {"camera": 0, "colour": 1}})"), HasSubstr("/preview/colour: no such"));
  EXPECT_THAT(answer_to(R"({"preview": {"camera": 0, "picture": "x"}})"), HasSubstr("/preview/picture: "));
  EXPECT_THAT(answer_to(R"({"ack": {"camera": 0, "frame": -1}})"), HasSubstr("/ack/frame: -1"));
  EXPECT_THAT(answer_to(R"({"stop_preview": "all"})"), HasSubstr("/stop_preview"));
  EXPECT_THAT(answer_to(std::string(10'000, '[')), HasSubstr("deeper"));
  viewer.synchronise();  // it is still served
}

TEST_F(ServerTest, APictureOnItsWayIsAcknowledgedEvenWhenItsCameraIsGone) {
  std::atomic<bool> is_there = true;
  ViewsOf views(daemon_,
                [&] { return is_there ? std::vector<std::uint32_t>{0} : std::vector<std::uint32_t>(); });
  WebServer server({daemon_, views, {&daemon_}, daemon_.routes()}, options(), counters_);
  Viewer viewer(server.port());
  viewer.send(R"({"preview": {"camera": 0}})");
  daemon_.publish(5);
  viewer.read_picture();
  is_there = false;
  viewer.acknowledge(5);
  viewer.send(R"({"stop_preview": 0})");
  viewer.synchronise();
  is_there = true;
  viewer.send(R"({"preview": {"camera": 0}})");
  EXPECT_EQ(viewer.read_picture().header.at("frame"), 5);
}

TEST_F(ServerTest, TooLargeMessagesEndTheirViewerOnly) {
  Viewer viewer(server_.port()), other(server_.port());
  viewer.send(std::string(20'000, ' '));
  EXPECT_THROW(viewer.read(), std::runtime_error);
  other.synchronise();
}

TEST_F(ServerTest, WithoutSubscribersNothingIsRead) {
  Viewer viewer(server_.port());
  for (int frame = 1; frame <= 100; ++frame) daemon_.publish(frame);
  viewer.synchronise();
  EXPECT_EQ(daemon_.looks(), 0);

  viewer.send(R"({"subscribe": ["detections"]})");
  EXPECT_EQ(viewer.read_json()["data"]["frame"], 100);
  EXPECT_EQ(counters_.jpegs_encoded, 0);
}

TEST_F(ServerTest, DetectionsAreThoseOfTheFrame) {
  Viewer viewer(server_.port());
  viewer.send(R"({"subscribe": ["detections"]})");
  daemon_.publish(5, {{{"id", 3}}});
  EXPECT_EQ(
      to_text(viewer.read_json()),
      R"({"topic":"detections","data":{"camera":0,"frame":5,"t_capture":5.5,"robots":[{"id":3}],"balls":[]}})");
  viewer.send(R"({"unsubscribe": ["detections"]})");
  viewer.synchronise();
  daemon_.publish(6);
  Viewer other(server_.port());
  other.send(R"({"subscribe": ["detections"]})");
  EXPECT_EQ(other.read_json()["data"]["frame"], 6);
  viewer.synchronise();
}

TEST_F(ServerTest, APictureComesWithItsDetections) {
  Viewer viewer(server_.port());
  viewer.send(R"({"preview": {"camera": 0, "width": 16, "quality": 50, "fps": 60}})");
  daemon_.publish(5, {{{"id", 3}}});
  const Viewer::Picture picture = viewer.read_picture();
  EXPECT_EQ(
      to_text(picture.header),
      R"({"camera":0,"frame":5,"t_capture":5.5,"picture":"camera","width":64,"height":48,"robots":[{"id":3}],"balls":[]})");
  EXPECT_THAT(picture.jpeg, StartsWith("\xff\xd8\xff"));
  EXPECT_THAT(picture.jpeg, testing::EndsWith("\xff\xd9"));
}

TEST_F(ServerTest, ALabelledPictureComesToThoseWhoAskForIt) {
  Viewer plain(server_.port()), labels(server_.port());
  daemon_.publish(1);
  plain.send(R"({"preview": {"camera": 0, "fps": 1000}})");
  EXPECT_EQ(plain.read_picture().header["picture"], "camera");
  EXPECT_EQ(daemon_.drawings(), 0);

  // Wider than the cells: images are not scaled up. The header keeps the size of the camera's image.
  labels.send(R"({"preview": {"camera": 0, "width": 50, "picture": "labels", "fps": 1000}})");
  const Viewer::Picture picture = labels.read_picture();
  EXPECT_EQ(picture.header["picture"], "labels");
  EXPECT_EQ(picture.header["width"], 64);
  EXPECT_EQ(picture.header["height"], 48);
  EXPECT_EQ(size_of(picture.jpeg), std::pair(32, 24));
  EXPECT_EQ(daemon_.drawings(), 1);

  labels.send(R"({"preview": {"camera": 0, "width": 50, "picture": "camera", "fps": 1000}})");
  labels.acknowledge(1);
  EXPECT_EQ(labels.read_picture().header["picture"], "camera");
  EXPECT_EQ(daemon_.drawings(), 1);
}

TEST_F(ServerTest, ALabelledImageIsMadeOnceForEqualRequests) {
  daemon_.publish(1);
  std::vector<std::unique_ptr<Viewer>> viewers;
  for (const int width : {32, 33, 40, 50, 64, 640}) {  // all equal, because images are not scaled up
    viewers.push_back(std::make_unique<Viewer>(server_.port()));
    viewers.back()->send(R"({"preview": {"camera": 0, "fps": 1000, "picture": "labels", "width": )" +
                         std::to_string(width) + "}}");
    viewers.back()->read_picture();
  }
  const int drawings = daemon_.drawings();
  const std::uint64_t encoded = counters_.jpegs_encoded;
  // All viewers are due for the next frame, since the server reads acknowledgements before later messages.
  for (const auto& viewer : viewers) {
    viewer->acknowledge(1);
    viewer->synchronise();
  }
  daemon_.publish(2);
  for (const auto& viewer : viewers) EXPECT_EQ(viewer->read_picture().header["frame"], 2);
  EXPECT_LE(daemon_.drawings(), drawings + 2);
  EXPECT_LE(counters_.jpegs_encoded, encoded + 2);
}

TEST_F(ServerTest, WithoutRunsTheCamerasPictureComesInstead) {
  Viewer viewer(server_.port());
  daemon_.make_no_runs();
  daemon_.publish(1);
  viewer.send(R"({"preview": {"camera": 0, "picture": "labels"}})");
  const Viewer::Picture picture = viewer.read_picture();
  EXPECT_EQ(picture.header["picture"], "camera");
  EXPECT_EQ(size_of(picture.jpeg), std::pair(64, 48));
}

TEST_F(ServerTest, RegionsComeToThoseWhoAskForThem) {
  Viewer plain(server_.port()), regions(server_.port());
  daemon_.publish(1);
  plain.send(R"({"preview": {"camera": 0, "fps": 1000}})");
  EXPECT_FALSE(plain.read_picture().header.contains("regions"));
  EXPECT_EQ(daemon_.region_lists(), 0);

  regions.send(R"({"preview": {"camera": 0, "fps": 1000, "regions": true}})");
  const Viewer::Picture picture = regions.read_picture();
  EXPECT_EQ(to_text(picture.header["regions"]), R"({"labels":["orange"],"boxes":[[0,1,2,3,4,5]],"total":1})");
  EXPECT_THAT(picture.jpeg, AllOf(StartsWith("\xff\xd8\xff"), testing::EndsWith("\xff\xd9")));

  // Both viewers are due for the next frame: they share its JPEG and not its header.
  const std::uint64_t encoded = counters_.jpegs_encoded;
  for (Viewer* viewer : {&plain, &regions}) {
    viewer->acknowledge(1);
    viewer->synchronise();
  }
  daemon_.publish(2);
  const Viewer::Picture with = regions.read_picture(), without = plain.read_picture();
  EXPECT_TRUE(with.header.contains("regions"));
  EXPECT_FALSE(without.header.contains("regions"));
  EXPECT_EQ(with.jpeg, without.jpeg);
  EXPECT_LE(counters_.jpegs_encoded, encoded + 2);

  daemon_.make_no_runs();
  regions.acknowledge(2);
  daemon_.publish(3);
  EXPECT_EQ(regions.read_picture().header["regions"], nullptr);
}

/// A client of stream.mjpg that has read the response's header.
class StreamClient : public Client {
 public:
  explicit StreamClient(std::uint16_t port, const std::string& query = "", int receive_buffer_bytes = 0)
      : Client(port, receive_buffer_bytes) {
    send(request_text("GET", "/api/cameras/0/stream.mjpg" + query));
    EXPECT_THAT(read_header(), StartsWith("HTTP/1.1 200"));
  }

  std::string read_jpeg() {
    const std::string head = read_header();
    EXPECT_THAT(head, StartsWith("--ssl-visiond-picture\r\nContent-Type: image/jpeg\r\n"));
    std::string jpeg = read(std::stoul(head.substr(head.find("Content-Length: ") + 16)));
    EXPECT_EQ(read(2), "\r\n");
    return jpeg;
  }
};

TEST_F(ServerTest, AStreamIsOnePictureAfterTheOther) {
  daemon_.publish(1);
  StreamClient client(server_.port(), "?width=32&fps=1000");
  EXPECT_EQ(size_of(client.read_jpeg()), std::pair(32, 24));
  for (int frame = 2; frame < 6; ++frame) {
    daemon_.publish(frame);
    EXPECT_THAT(client.read_jpeg(), AllOf(StartsWith("\xff\xd8\xff"), testing::EndsWith("\xff\xd9")));
  }
  EXPECT_EQ(counters_.jpegs_encoded, 5);
  EXPECT_EQ(counters_.connections, 1);
  EXPECT_EQ(counters_.viewers, 0);
}

TEST_F(ServerTest, AStreamEndsWithItsClient) {
  daemon_.publish(1);
  {
    StreamClient client(server_.port());
    client.read_jpeg();
  }
  ASSERT_TRUE(test::becomes([&] { return counters_.connections == 0; }));
  Viewer viewer(server_.port());
  viewer.send(R"({"subscribe": ["detections"]})");
  viewer.read_json();
  daemon_.publish(2);
  viewer.read_json();
  EXPECT_EQ(counters_.jpegs_encoded, 1);
}

TEST_F(ServerTest, AStreamEndsWithTheServer) {
  daemon_.publish(1);
  StreamClient client(server_.port());
  client.read_jpeg();
  server_.stop();
  EXPECT_EQ(client.read_to_end(), "");
}

TEST_F(ServerTest, ASlowStreamSkipsPicturesAndDelaysNobody) {
  daemon_.publish_noise(1);  // larger than the buffers between server and client
  StreamClient slow(server_.port(), "?width=16384&quality=100&fps=1000", 4096);
  Viewer quick(server_.port());
  quick.send(R"({"subscribe": ["detections"]})");
  EXPECT_EQ(quick.read_json()["data"]["frame"], 1);
  for (int frame = 2; frame <= 20; ++frame) {
    daemon_.publish_noise(frame);
    ASSERT_EQ(quick.read_json()["data"]["frame"], frame);
  }
  EXPECT_EQ(counters_.jpegs_encoded, 1);
  const std::string first = slow.read_jpeg();
  EXPECT_GT(first.size(), std::size_t{512} * 1024);
  slow.read_jpeg();
  EXPECT_EQ(counters_.jpegs_encoded, 2);  // all other frames were skipped
}

TEST_F(ServerTest, TheNextPictureComesOnlyAfterTheAcknowledgement) {
  Viewer viewer(server_.port());
  viewer.send(R"({"preview": {"camera": 0, "fps": 1000}})");
  daemon_.publish(1);
  EXPECT_EQ(viewer.read_picture().header["frame"], 1);

  // An image would be sent before the detections of the same frame; here only detections arrive.
  viewer.send(R"({"subscribe": ["detections"]})");
  EXPECT_EQ(viewer.read_json()["data"]["frame"], 1);
  daemon_.publish(2);
  EXPECT_EQ(viewer.read_json()["data"]["frame"], 2);
  viewer.acknowledge(77);  // of another image
  daemon_.publish(3);
  EXPECT_EQ(viewer.read_json()["data"]["frame"], 3);
  EXPECT_EQ(counters_.jpegs_encoded, 1);

  viewer.acknowledge(1);
  EXPECT_EQ(viewer.read_picture().header["frame"], 3);
  EXPECT_EQ(counters_.jpegs_encoded, 2);
}

TEST_F(ServerTest, ImagesAreSentAtMostAtTheRequestedRate) {
  Viewer viewer(server_.port());
  viewer.send(R"({"preview": {"camera": 0, "fps": 0.01}})");
  daemon_.publish(1);
  EXPECT_EQ(viewer.read_picture().header["frame"], 1);
  viewer.acknowledge(1);
  viewer.send(R"({"subscribe": ["detections"]})");
  EXPECT_EQ(viewer.read_json()["data"]["frame"], 1);
  daemon_.publish(2);
  EXPECT_EQ(viewer.read_json()["data"]["frame"], 2);  // and no image before

  viewer.send(R"({"preview": {"camera": 0, "fps": 1000}})");  // a changed request is due at once
  EXPECT_EQ(viewer.read_picture().header["frame"], 2);
}

TEST_F(ServerTest, AnImageIsEncodedOnceForEqualRequests) {
  daemon_.publish(1);
  Viewer viewer(server_.port());
  viewer.send(R"({"preview": {"camera": 0, "width": 32, "fps": 1000}})");
  viewer.read_picture();
  std::vector<std::unique_ptr<Viewer>> others;
  for (int i = 0; i < 3; ++i) {
    others.push_back(std::make_unique<Viewer>(server_.port()));
    others.back()->send(R"({"preview": {"camera": 0, "width": 32, "fps": 1000}})");
    others.back()->read_picture();
  }
  const std::uint64_t before = counters_.jpegs_encoded;
  // All viewers are due for the next frame, since the server reads acknowledgements before later messages.
  viewer.acknowledge(1);
  viewer.synchronise();
  for (const auto& other : others) {
    other->acknowledge(1);
    other->synchronise();
  }
  daemon_.publish(2);
  EXPECT_EQ(viewer.read_picture().header["frame"], 2);
  for (const auto& other : others) EXPECT_EQ(other->read_picture().header["frame"], 2);
  EXPECT_LE(counters_.jpegs_encoded, before + 2);
}

TEST_F(ServerTest, AStoppedPreviewCostsNothing) {
  Viewer viewer(server_.port());
  viewer.send(R"({"preview": {"camera": 0, "fps": 1000}})");
  daemon_.publish(1);
  viewer.read_picture();
  viewer.acknowledge(1);
  viewer.send(R"({"stop_preview": 0})");
  viewer.synchronise();
  viewer.send(R"({"subscribe": ["detections"]})");
  viewer.read_json();
  daemon_.publish(2);
  EXPECT_EQ(viewer.read_json()["data"]["frame"], 2);
  EXPECT_EQ(counters_.jpegs_encoded, 1);
}

TEST_F(ServerTest, AFrameIsLetGoWhileItsPictureIsOnTheWay) {
  std::promise<void> let_go;
  Viewer viewer(server_.port());
  viewer.send(R"({"preview": {"camera": 0}})");
  daemon_.publish(1, Json::array(), std::shared_ptr<void>(nullptr, [&](void*) { let_go.set_value(); }));
  viewer.read_picture();
  daemon_.publish(2);
  EXPECT_EQ(let_go.get_future().wait_for(test::kPatience), std::future_status::ready);
}

TEST_F(ServerTest, ASlowViewerSkipsMessagesAndDelaysNobody) {
  const Json large(std::string(400'000, 'x'));  // more than the buffers between server and slow viewer hold
  Viewer slow(server_.port(), 4096), quick(server_.port());
  slow.send(R"({"subscribe": ["detections"]})");
  slow.synchronise();  // so that it is served before the quick one
  quick.send(R"({"subscribe": ["detections"]})");
  quick.synchronise();
  for (int frame = 1; frame <= 5; ++frame) {
    daemon_.publish(frame, large);
    ASSERT_EQ(quick.read_json()["data"]["frame"], frame);
  }
  EXPECT_EQ(slow.read_json()["data"]["frame"], 1);  // its sending had begun
  EXPECT_EQ(slow.read_json()["data"]["frame"], 5);
}

}  // namespace
}  // namespace sslv::server_test
