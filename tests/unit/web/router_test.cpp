// SPDX-License-Identifier: Apache-2.0
#include "web/router.h"

#include "base/log.h"
#include "unit/web/fake_host.h"

#include <filesystem>
#include <fstream>
#include <regex>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

namespace sslv::router_test {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::EndsWith;
using testing::HasSubstr;
using testing::Key;
using testing::Not;
using testing::Pair;
using testing::StartsWith;

struct Answer {
  int status;
  std::string header, body;
  bool keep_alive;
};

class RouterTest : public testing::Test {
 protected:
  ~RouterTest() override { std::filesystem::remove_all(folder_); }

  static std::filesystem::path make_folder() {
    const auto folder =
        std::filesystem::temp_directory_path() / ("sslv_router_test_" + std::to_string(getpid()));
    std::filesystem::create_directories(folder / "panel/assets");
    for (const auto& [name, text] : {std::pair("secret.txt", "secret"),
                                     {"panel/index.html", "<!doctype html>"},
                                     {"panel/favicon.svg", "<svg/>"},
                                     {"panel/assets/index-1a2b3c.js", "run()"}}) {
      std::ofstream(folder / name) << text;
    }
    return folder;
  }

  Answer ask(const std::string& method, const std::string& target, const std::string& body = {},
             const std::string& more_headers = {}) const {
    return ask(router_, method, target, body, more_headers);
  }
  static Answer ask(const Router& router, const std::string& method, const std::string& target,
                    const std::string& body = {}, const std::string& more_headers = {}) {
    const HttpAnswer answer =
        router.answer(method + " " + target + " HTTP/1.1\r\nHost: field-pc:8090\r\n" + more_headers +
                          "Content-Length: " + std::to_string(body.size()) + "\r\n\r\n" + body,
                      "192.0.2.7");
    const std::size_t end = answer.bytes.find("\r\n\r\n");
    return {std::stoi(answer.bytes.substr(std::string_view("HTTP/1.1 ").size())),
            answer.bytes.substr(0, end + 2), answer.bytes.substr(end + 4), answer.keep_alive};
  }

  const std::filesystem::path folder_ = make_folder();
  FakeHost daemon_;
  const Router router_{daemon_, daemon_.routes(), folder_ / "panel"};
};

TEST_F(RouterTest, AnswersWithWhatHandlersMake) {
  EXPECT_EQ(ask("GET", "/api/schema").body, R"({"type":"object"})");
  EXPECT_THAT(ask("GET", "/api/schema").header, AllOf(HasSubstr("Content-Type: application/json\r\n"),
                                                      HasSubstr("Cache-Control: no-store\r\n")));
  EXPECT_EQ(ask("GET", "/api/file/x").body, "\x01\x02\x03");
  EXPECT_EQ(Json::parse(ask("PUT", "/api/names/Nacht%20%C3%A4%2B+").body)["name"], "Nacht ä++");
  EXPECT_EQ(Json::parse(ask("PUT", "/api/names/a%2Fb").body)["name"], "a/b");  // the handler must refuse it
}

TEST_F(RouterTest, MonitoringGetsUncachedPlainText) {
  for (const auto& [path, status, text] :
       {std::tuple("/healthz", 200, "ok\n"), {"/readyz", 503, "camera 0 is lost\n"}}) {
    const Answer answer = ask("GET", path);
    EXPECT_EQ(answer.status, status) << path;
    EXPECT_EQ(answer.body, text);
    EXPECT_THAT(answer.header, AllOf(HasSubstr("Content-Type: text/plain; charset=utf-8\r\n"),
                                     HasSubstr("Cache-Control: no-store\r\n")));
    EXPECT_EQ(ask("HEAD", path).status, status) << path;
    EXPECT_EQ(ask("HEAD", path).body, "");
    EXPECT_EQ(ask("POST", path).status, 405) << path;
  }
  EXPECT_EQ(router_.speed_of("GET", "/healthz"), Speed::kAtOnce);
  EXPECT_EQ(router_.speed_of("HEAD", "/healthz?verbose"), Speed::kAtOnce);
  EXPECT_EQ(router_.speed_of("POST", "/healthz"), Speed::kMayWait);
  EXPECT_EQ(router_.speed_of("GET", "/api/hangs"), Speed::kMayWait);
}

TEST_F(RouterTest, ARouteAsksForWhatItNeeds) {
  daemon_.passwords().set(Role::kAdmin, "correct horse");
  daemon_.passwords().set(Role::kViewer, "battery staple");
  const auto signed_in = [&](const std::string& password) {
    const Answer answer = ask("POST", "/api/session", R"({"password": ")" + password + R"("})");
    EXPECT_EQ(answer.status, 200) << answer.body;
    const std::size_t at = answer.header.find("Set-Cookie: ") + std::string_view("Set-Cookie: ").size();
    return "Cookie: " + answer.header.substr(at, answer.header.find(';', at) - at) + "\r\n";
  };
  const std::string admin = signed_in("correct horse"), viewer = signed_in("battery staple");
  for (const std::string& nobody : {std::string(), std::string("Cookie: session=0123\r\n")}) {
    EXPECT_EQ(ask("GET", "/api/status", "", nobody).status, 401);
    EXPECT_EQ(ask("PATCH", "/api/settings", "[1]", nobody).status, 401);
    EXPECT_EQ(ask("POST", "/api/settings/check", "[1]", nobody).status, 401);
    EXPECT_EQ(ask("GET", "/healthz", "", nobody).status, 200);
  }
  EXPECT_EQ(ask("GET", "/api/status", "", viewer).status, 200);
  EXPECT_EQ(ask("PATCH", "/api/settings", "[1]", viewer).status, 401);
  EXPECT_EQ(ask("POST", "/api/settings/check", "[1]", viewer).status, 401);
  EXPECT_EQ(ask("PATCH", "/api/settings", "[1]", admin).status, 200);
  EXPECT_EQ(ask("POST", "/api/settings/check", "[1]", admin).status, 200);
  EXPECT_EQ(ask("GET", "/").status, 200) << "the page that asks for the password";

  daemon_.let_match_run(true);
  const Answer locked = ask("PATCH", "/api/settings", "[1]", admin);
  EXPECT_EQ(locked.status, 423);
  EXPECT_EQ(locked.body, R"({"error":"the game is running"})");
  EXPECT_EQ(ask("POST", "/api/settings/check", "[1]", admin).status, 200) << "it changes nothing";
  EXPECT_EQ(ask("GET", "/api/status", "", admin).status, 200);
}

TEST_F(RouterTest, AStreamBeginsWithItsHead) {
  const auto head_of = [&](const std::string& method, const std::string& query) {
    return router_.answer(method + " /api/cameras/0/stream.mjpg" + query + " HTTP/1.1\r\n\r\n", "192.0.2.7");
  };
  const HttpAnswer plain = head_of("GET", "");
  EXPECT_THAT(plain.bytes,
              AllOf(StartsWith("HTTP/1.1 200 "), testing::EndsWith("\r\n\r\n"),
                    HasSubstr("Content-Type: multipart/x-mixed-replace; boundary=ssl-visiond-picture\r\n"),
                    HasSubstr("Connection: close\r\n"), HasSubstr("Cache-Control: no-store\r\n"),
                    HasSubstr("X-Content-Type-Options: nosniff\r\n"), Not(HasSubstr("Content-Length"))));
  ASSERT_TRUE(plain.stream);
  EXPECT_FALSE(plain.keep_alive);
  EXPECT_EQ(head_of("GET", "?width=99").stream->preview.width, 99);
  const HttpAnswer head = head_of("HEAD", "");
  EXPECT_EQ(head.bytes, plain.bytes);
  EXPECT_FALSE(head.stream);
  const HttpAnswer refused = head_of("GET", "?width=0");
  EXPECT_THAT(refused.bytes, StartsWith("HTTP/1.1 400 "));
  EXPECT_FALSE(refused.stream);
  EXPECT_FALSE(router_.answer("GET /api/schema HTTP/1.1\r\n\r\n", "192.0.2.7").stream)
      << "what another request wanted";
  EXPECT_EQ(ask("POST", "/api/cameras/0/stream.mjpg").status, 405);
}

TEST_F(RouterTest, AnUnexpectedFailureIs500) {
  const Answer response = ask("GET", "/api/broken");
  EXPECT_EQ(response.status, 500);
  EXPECT_EQ(response.body, R"({"error":"disk on fire"})");
}

TEST_F(RouterTest, AnswersByItsOwnNamesOnly) {
  const auto asked_by = [&](const std::string& host) {
    return router_.answer("GET /api/schema HTTP/1.1\r\nHost: " + host + "\r\n\r\n", "192.0.2.7").bytes;
  };
  for (const char* host :
       {"field-pc", "FIELD-PC:8090", "localhost:8090", "127.0.0.1:8090", "[::1]:8090", "192.0.2.1"})
    EXPECT_THAT(asked_by(host), StartsWith("HTTP/1.1 200")) << host;
  for (const char* host : {"evil.example", "evil.example:8090", "127.0.0.1.evil.example",
                           "localhost.evil.example:80", "evil.example:field-pc"}) {
    EXPECT_THAT(asked_by(host), AllOf(StartsWith("HTTP/1.1 403"), HasSubstr("/panel/names"))) << host;
  }
  EXPECT_EQ(ask("GET", "/").status, 200);
  EXPECT_THAT(router_.answer("GET / HTTP/1.1\r\nHost: evil.example\r\n\r\n", "192.0.2.7").bytes,
              StartsWith("HTTP/1.1 403"))
      << "files too";
}

TEST_F(RouterTest, AWrongPasswordSaysSo) {
  EXPECT_EQ(ask("POST", "/api/session", R"({"password": "correct horse"})").status, 409) << "none is set";
  daemon_.passwords().set(Role::kAdmin, "correct horse");
  const Answer wrong = ask("POST", "/api/session", R"({"password": "wrong horse"})");
  EXPECT_EQ(wrong.status, 401);
  EXPECT_EQ(wrong.body, R"({"error":"wrong password"})");
  EXPECT_THAT(wrong.header, AllOf(Not(HasSubstr("Set-Cookie")), HasSubstr("WWW-Authenticate: Session")));
  for (int i = 0; i < 4; ++i) ask("POST", "/api/session", R"({"password": "wrong horse"})");
  const Answer late = ask("POST", "/api/session", R"({"password": "correct horse"})");
  EXPECT_EQ(late.status, 429);
  EXPECT_THAT(late.header, HasSubstr("Retry-After: 10\r\n"));
}

TEST_F(RouterTest, WritesLeaveALineInTheLogAndReadsNone) {
  const auto lines = [&](const auto& act) {
    const std::uint64_t before = log::recent().newer_than(0, log::Level::kInfo).newest;
    act();
    std::vector<std::string> out;
    for (const auto& line : log::recent().newer_than(before, log::Level::kInfo).lines)
      out.push_back(line.text);
    return out;
  };
  EXPECT_THAT(lines([&] { ask("GET", "/api/settings"); }), testing::IsEmpty());
  EXPECT_THAT(lines([&] { ask("PATCH", "/api/settings", "[1]"); }),
              testing::Contains(R"(audit: 192.0.2.7 PATCH "/api/settings" 200)"));
  EXPECT_THAT(lines([&] { ask("PUT", "/api/x%0Aaudit:", "[1]"); }),
              testing::Contains(R"(audit: 192.0.2.7 PUT "/api/x%0Aaudit:" 404)"));
  EXPECT_THAT(lines([&] { ask("POST", "/api/session", R"({"password": "correct horse"})"); }),
              testing::Each(Not(HasSubstr("horse"))));
}

TEST_F(RouterTest, RefusalsOfOneAddressLeaveOneLine) {
  const std::uint64_t before = log::recent().newer_than(0, log::Level::kInfo).newest;
  for (int i = 0; i < 200; ++i) ask("PUT", "/api/nothing", "[1]");
  for (int i = 0; i < 200; ++i) ask("DELETE", "/api/session");
  const auto after = log::recent().newer_than(before, log::Level::kInfo);
  EXPECT_EQ(after.newest, before + 1);
}

TEST_F(RouterTest, UnknownApiRoutesAre404InJson) {
  for (const char* target : {"/api", "/api/nothing", "/api/status/more", "/api/cameras/0",
                             "/api/cameras/0/stream.mjpg/x", "/api/../secret.txt"}) {
    const Answer response = ask("GET", target);
    EXPECT_EQ(response.status, 404) << target;
    EXPECT_THAT(response.header, HasSubstr("Content-Type: application/json\r\n"));
    EXPECT_THAT(response.body, StartsWith("{\"error\":"));
  }
}

TEST_F(RouterTest, WrongMethodsAre405AndSayWhatIsAllowed) {
  const Answer settings = ask("POST", "/api/settings");
  EXPECT_EQ(settings.status, 405);
  EXPECT_THAT(settings.header, HasSubstr("Allow: GET, PATCH\r\n"));
  EXPECT_THAT(settings.body, StartsWith("{\"error\":"));
  EXPECT_THAT(ask("PATCH", "/api/file/x", "[]").header,
              AllOf(StartsWith("HTTP/1.1 405"), HasSubstr("Allow: GET\r\n")));
  EXPECT_EQ(ask("DELETE", "/index.html").status, 405);
  EXPECT_EQ(ask("POST", "/api/nothing").status, 404);
}

TEST_F(RouterTest, PatchesReachTheHost) {
  const std::string patch = R"([{"op":"replace","path":"/site","value":"x"}])";
  const Answer saved = ask("PATCH", "/api/settings", patch);
  EXPECT_EQ(saved.status, 200);
  EXPECT_EQ(saved.body, R"({"revision":8,"settings":)" + patch + "}");
  EXPECT_EQ(daemon_.last_author(), "192.0.2.7");
  EXPECT_EQ(ask("PATCH", "/api/settings", patch, "If-Match: 7\r\n").status, 200);
}

TEST_F(RouterTest, BadPatchesAreRefused) {
  EXPECT_EQ(ask("PATCH", "/api/settings", "[{").status, 400);
  EXPECT_EQ(ask("PATCH", "/api/settings", "[1]", "If-Match: 6\r\n").body,
            R"({"error":"revision 7 is the newest","revision":7})");
  const Answer refused = ask("PATCH", "/api/settings", "[]");
  EXPECT_EQ(refused.status, 422);
  EXPECT_EQ(refused.body, R"({"error":"/site: refused"})");
}

TEST_F(RouterTest, WritesFromOtherSitesAreRefused) {
  const std::string foreign = "Origin: http://evil.example\r\n";
  EXPECT_EQ(ask("PATCH", "/api/settings", "[1]", foreign).status, 403);
  EXPECT_EQ(daemon_.last_author(), "");
  // The browser hides the answer from the other site.
  EXPECT_EQ(ask("GET", "/api/settings", "", foreign).status, 200);
}

TEST_F(RouterTest, ServesThePanel) {
  const Answer index = ask("GET", "/");
  EXPECT_EQ(index.status, 200);
  EXPECT_EQ(index.body, "<!doctype html>");
  EXPECT_THAT(index.header,
              AllOf(HasSubstr("Content-Type: text/html\r\n"), HasSubstr("Cache-Control: no-cache\r\n")));
  EXPECT_THAT(ask("GET", "/favicon.svg").header, HasSubstr("Content-Type: image/svg+xml\r\n"));

  const Answer script = ask("GET", "/assets/index-1a2b3c.js");
  EXPECT_THAT(script.header,
              AllOf(HasSubstr("Content-Type: text/javascript\r\n"), HasSubstr("immutable\r\n")));

  for (const char* missing :
       {"/nothing.js", "/assets/", "/assets/nothing.js", "/secret.txt", "//etc/passwd", "/panel/index.html",
        "/../secret.txt", "/%2e%2e/secret.txt", "/assets/..%2f..%2fsecret.txt", "/..", "*",
        "http://example.org/", "/%2e%2e%2fsecret.txt", "/assets/%2e%2e/%2e%2e/secret.txt",
        "/assets/..%5c..%5csecret.txt", "/%252e%252e/secret.txt", "/..;/secret.txt"}) {
    const Answer answer = ask("GET", missing);
    EXPECT_EQ(answer.status, 404) << missing;
    EXPECT_THAT(answer.header, HasSubstr("Cache-Control: no-store\r\n"));
  }
}

TEST_F(RouterTest, AnAddressWithAZeroByteIsRefused) {
  for (const char* target : {"/index.html%00.txt", "/%00", "/api/status%00", "/api/profiles/a%00b"}) {
    const Answer answer = ask("GET", target);
    EXPECT_EQ(answer.status, 400) << target;
    EXPECT_EQ(answer.body, R"({"error":"the address contains a zero byte"})") << target;
  }
}

TEST_F(RouterTest, SaysHowToBuildAMissingPanel) {
  const Router router(daemon_, daemon_.routes(), folder_ / "nowhere");
  const Answer response = ask(router, "GET", "/");
  EXPECT_EQ(response.status, 503);
  EXPECT_THAT(response.body, HasSubstr("./run build"));
}

TEST_F(RouterTest, InvalidRequestsCloseTheirConnection) {
  for (const std::string& request :
       {std::string("\r\n\r\n"), std::string("GET / HTTP/9.9\r\n\r\n"), std::string("GET /\r\n\r\n"),
        std::string("FETCH / HTTP/1.1\r\n\r\n"), "GET /" + std::string(9000, 'x') + " HTTP/1.1\r\n\r\n",
        std::string("GET / HTTP/1.1\r\nRange: bytes=x\r\n\r\n")}) {
    const HttpAnswer answer = router_.answer(request, "192.0.2.7");
    EXPECT_THAT(answer.bytes, AllOf(StartsWith("HTTP/1.1 4"), HasSubstr("{\"error\":")));
    EXPECT_FALSE(answer.keep_alive);
  }
}

TEST_F(RouterTest, TheClientDecidesWhetherItsConnectionIsKept) {
  const auto keeps = [&](const std::string& version, const std::string& headers = {}) {
    return router_.answer("GET /api/status " + version + "\r\n" + headers + "\r\n", "192.0.2.7").keep_alive;
  };
  EXPECT_TRUE(keeps("HTTP/1.1"));
  EXPECT_FALSE(keeps("HTTP/1.1", "Connection: close\r\n"));
  EXPECT_FALSE(keeps("HTTP/1.0"));
  EXPECT_TRUE(keeps("HTTP/1.0", "Connection: Keep-Alive\r\n"));
  EXPECT_THAT(router_.answer("GET / HTTP/1.0\r\n\r\n", "").bytes, HasSubstr("Connection: close\r\n"));
}

TEST_F(RouterTest, CompressedFilesAreSentToClientsThatAcceptThem) {
  const auto pack = [&](const std::string& name) {
    std::ofstream(folder_ / "panel" / (name + ".gz")) << "packed";
  };
  pack("assets/index-1a2b3c.js");
  pack("index.html");
  std::ofstream(folder_ / "secret.txt.gz") << "packed";
  std::ofstream(folder_ / "panel/panel.webmanifest") << "{}";
  const auto get = [&](const std::string& path, const std::string& codings,
                       const std::string& method = "GET") {
    return ask(method, path, "", codings.empty() ? "" : "Accept-Encoding: " + codings + "\r\n");
  };
  const Answer script = get("/assets/index-1a2b3c.js", "gzip, deflate, br");
  EXPECT_EQ(script.body, "packed");
  EXPECT_THAT(script.header,
              AllOf(HasSubstr("Content-Encoding: gzip\r\n"), HasSubstr("Content-Type: text/javascript\r\n"),
                    HasSubstr("Vary: Accept-Encoding\r\n"), HasSubstr("immutable\r\n"),
                    Not(HasSubstr("application/gzip"))));
  EXPECT_THAT(get("/", "gzip").header,
              AllOf(HasSubstr("Content-Type: text/html\r\n"), HasSubstr("Cache-Control: no-cache\r\n")));
  EXPECT_EQ(get("/?x=1", "br;q=1, GZIP;q=0.5").body, "packed");
  EXPECT_THAT(get("/", "gzip", "HEAD").header, HasSubstr("Content-Length: 6\r\n"));
  for (const char* codings : {"", "br", "gzip;q=0", "x-gzip", "gzip;q=0.000"}) {
    const Answer plain = get("/", codings);
    EXPECT_EQ(plain.body, "<!doctype html>") << codings;
    EXPECT_THAT(plain.header,
                AllOf(HasSubstr("Vary: Accept-Encoding\r\n"), Not(HasSubstr("Content-Encoding"))));
  }
  EXPECT_EQ(get("/favicon.svg", "gzip").body, "<svg/>") << "not packed";
  EXPECT_THAT(get("/assets/index-1a2b3c.js.gz", "gzip").header, Not(HasSubstr("Content-Encoding")));
  EXPECT_EQ(get("/../secret.txt", "gzip").status, 404);
  EXPECT_EQ(get("/%2e%2e/secret.txt", "gzip").status, 404);
  EXPECT_EQ(ask("POST", "/", "", "Accept-Encoding: gzip\r\n").status, 405);
  EXPECT_THAT(get("/panel.webmanifest", "").header, HasSubstr("Content-Type: application/manifest+json\r\n"));
}

TEST_F(RouterTest, HeadIsGetWithoutTheBody) {
  const Answer head = ask("HEAD", "/api/schema"), file = ask("HEAD", "/");
  EXPECT_THAT(head.header, AllOf(StartsWith("HTTP/1.1 200"), HasSubstr("Content-Length: 17\r\n")));
  EXPECT_EQ(head.body, "");
  EXPECT_THAT(file.header, AllOf(StartsWith("HTTP/1.1 200"), HasSubstr("Content-Length: 15\r\n")));
  EXPECT_EQ(file.body, "");
  EXPECT_EQ(ask("HEAD", "/api/nothing").status, 404);
}

TEST_F(RouterTest, IgnoresMultipleRangesAndCompressedBodies) {
  std::string ranges = "Range: bytes=0-";
  while (ranges.size() < 1000) ranges += ",0-";
  EXPECT_EQ(ask("GET", "/", "", ranges + "\r\n").body, "<!doctype html>");
  EXPECT_EQ(ask("GET", "/", "", "Range: bytes=" + std::string(1000, '1') + "-\r\n").status, 416);
  EXPECT_EQ(ask("GET", "/api/file/" + std::string(1000, '1')).status, 200);
  EXPECT_THAT(ask("GET", "/", "", "Accept-Encoding: gzip, br\r\n").header,
              Not(HasSubstr("Content-Encoding")));
  EXPECT_EQ(ask("PATCH", "/api/settings", "[1]", "Content-Encoding: gzip\r\n").status, 200);
  EXPECT_EQ(ask("PATCH", "/api/settings", "[1]", "Content-Type: multipart/form-data; boundary=x\r\n").status,
            200);
  EXPECT_THAT(ask("PATCH", "/api/settings", "[1]", "Expect: 100-continue\r\n").header,
              StartsWith("HTTP/1.1 200"));
}

}  // namespace
}  // namespace sslv::router_test
