// SPDX-License-Identifier: Apache-2.0
#include "web/router.h"

#include "routes.h"
#include "unit/web/fake_host.h"

#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

namespace sslv {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::Pair;
using testing::StartsWith;

class RouterTest : public testing::Test {
 protected:
  RouterTest() {
    std::filesystem::create_directories(folder_ / "panel/assets");
    write("secret.txt", "secret");
    write("panel/index.html", "<!doctype html>");
    write("panel/favicon.svg", "<svg/>");
    write("panel/assets/index-1a2b3c.js", "run()");
  }
  ~RouterTest() override { std::filesystem::remove_all(folder_); }

  void write(const std::string& name, const std::string& text) { std::ofstream(folder_ / name) << text; }

  Response ask(const std::string& method, std::string_view target, const std::string& body = {},
               const std::map<std::string, std::string>& headers = {}) const {
    Request request;
    request.method = method;
    EXPECT_TRUE(parse_target(target, request)) << target;
    request.headers = headers;
    request.body = body;
    request.remote_address = "192.0.2.7";
    return router_.answer(std::move(request));
  }

  const std::filesystem::path folder_ =
      std::filesystem::temp_directory_path() / ("sslv_router_test_" + std::to_string(getpid()));
  FakeHost daemon_;
  const WebHost host_ = daemon_.host();
  const Router router_{host_, routes(), folder_ / "panel"};
};

TEST_F(RouterTest, AnswersFromTheHost) {
  EXPECT_EQ(ask("GET", "/api/status").body, R"({"site":"test","cameras":[{"id":0}]})");
  EXPECT_EQ(ask("GET", "/api/cameras").body, R"([{"id":0}])");
  EXPECT_EQ(ask("GET", "/api/settings").body, R"({"revision":7,"settings":{"site":"test"}})");
  EXPECT_EQ(ask("GET", "/api/schema").body, R"({"type":"object"})");
  EXPECT_EQ(ask("GET", "/api/schema").content_type, "application/json");
}

TEST_F(RouterTest, UnknownApiRoutesAre404InJson) {
  for (const char* target :
       {"/api", "/api/nothing", "/api/status/more", "/api/cameras/0", "/api/cameras/0/lut/x"}) {
    const Response response = ask("GET", target);
    EXPECT_EQ(response.status, 404) << target;
    EXPECT_EQ(response.content_type, "application/json");
    EXPECT_THAT(response.body, StartsWith("{\"error\":"));
  }
}

TEST_F(RouterTest, WrongMethodsAre405AndSayWhatIsAllowed) {
  const Response settings = ask("POST", "/api/settings");
  EXPECT_EQ(settings.status, 405);
  EXPECT_THAT(settings.headers, Contains(Pair("Allow", "GET, PATCH")));
  EXPECT_EQ(ask("DELETE", "/index.html").status, 405);
  EXPECT_EQ(ask("POST", "/api/nothing").status, 404);
}

TEST_F(RouterTest, PatchesReachTheHost) {
  const std::string patch = R"([{"op":"replace","path":"/site","value":"x"}])";
  const Response saved = ask("PATCH", "/api/settings", patch);
  EXPECT_EQ(saved.status, 200);
  EXPECT_EQ(saved.body, R"({"revision":8,"settings":)" + patch + R"(,"saved":true})");
  EXPECT_EQ(daemon_.last_author(), "192.0.2.7");
  EXPECT_EQ(ask("PATCH", "/api/settings", patch, {{"if-match", "7"}}).status, 200);
  EXPECT_EQ(ask("PATCH", "/api/settings", patch, {{"if-match", "\"7\""}}).status, 200);
}

TEST_F(RouterTest, BadPatchesAreRefused) {
  EXPECT_EQ(ask("PATCH", "/api/settings", "[{").status, 400);
  EXPECT_EQ(ask("PATCH", "/api/settings", "[1]", {{"if-match", "6"}}).status, 409);
  EXPECT_EQ(ask("PATCH", "/api/settings", "[1]", {{"if-match", "*"}}).status, 400);
  const Response refused = ask("PATCH", "/api/settings", "[]");
  EXPECT_EQ(refused.status, 422);
  EXPECT_EQ(refused.body, R"({"error":"/site: refused"})");
}

TEST_F(RouterTest, WritesFromOtherSitesAreRefused) {
  const std::map<std::string, std::string> foreign{{"host", "field-pc:8090"},
                                                   {"origin", "http://evil.example"}};
  EXPECT_EQ(ask("PATCH", "/api/settings", "[1]", foreign).status, 403);
  EXPECT_EQ(daemon_.last_author(), "");
  EXPECT_EQ(ask("GET", "/api/settings", "", foreign).status,
            200);  // the browser keeps it from the other site
}

TEST_F(RouterTest, SnapshotsAreJpegs) {
  EXPECT_EQ(ask("GET", "/api/cameras/0/snapshot.jpg").status, 503);
  daemon_.publish(1);
  const Response large = ask("GET", "/api/cameras/0/snapshot.jpg");
  const Response small = ask("GET", "/api/cameras/0/snapshot.jpg?width=8&quality=20");
  EXPECT_EQ(large.status, 200);
  EXPECT_EQ(large.content_type, "image/jpeg");
  EXPECT_THAT(large.body, StartsWith("\xff\xd8\xff"));
  EXPECT_THAT(small.body, StartsWith("\xff\xd8\xff"));
  EXPECT_LT(small.body.size(), large.body.size());

  const Response refused = ask("GET", "/api/cameras/0/snapshot.jpg?width=wide");
  EXPECT_EQ(refused.status, 400);
  EXPECT_THAT(refused.body, HasSubstr("width"));
  EXPECT_EQ(ask("GET", "/api/cameras/0/snapshot.jpg?quality=101").status, 400);
  EXPECT_EQ(ask("GET", "/api/cameras/1/snapshot.jpg").status, 404);
  EXPECT_EQ(ask("GET", "/api/cameras/x/snapshot.jpg").status, 400);
}

TEST_F(RouterTest, TheColourTableIsAFile) {
  const Response lut = ask("GET", "/api/cameras/0/lut");
  EXPECT_EQ(lut.body, "\x01\x02\x03");
  EXPECT_THAT(lut.headers, Contains(Pair("Content-Disposition", "attachment; filename=\"camera-0.lut\"")));
  EXPECT_EQ(ask("GET", "/api/cameras/1/lut").status, 404);
}

TEST_F(RouterTest, ServesThePanel) {
  const Response index = ask("GET", "/");
  EXPECT_EQ(index.status, 200);
  EXPECT_EQ(index.body, "<!doctype html>");
  EXPECT_EQ(index.content_type, "text/html; charset=utf-8");
  EXPECT_THAT(index.headers, Contains(Pair("Cache-Control", "no-cache")));
  EXPECT_EQ(ask("GET", "/favicon.svg").content_type, "image/svg+xml");

  const Response script = ask("GET", "/assets/index-1a2b3c.js");
  EXPECT_EQ(script.content_type, "text/javascript; charset=utf-8");
  EXPECT_THAT(script.headers, Contains(Pair("Cache-Control", HasSubstr("immutable"))));

  for (const char* missing : {"/nothing.js", "/assets", "/secret.txt", "//etc/passwd", "/panel/index.html"}) {
    EXPECT_EQ(ask("GET", missing).status, 404) << missing;
  }
}

TEST_F(RouterTest, SaysHowToBuildAMissingPanel) {
  const Router router(host_, routes(), folder_ / "nowhere");
  Request request;
  request.method = "GET";
  const Response response = router.answer(request);
  EXPECT_EQ(response.status, 503);
  EXPECT_THAT(response.body, HasSubstr("./run build"));
}

TEST_F(RouterTest, AnUnexpectedFailureIs500) {
  WebHost broken = daemon_.host();
  broken.status = []() -> Json { throw std::runtime_error("disk on fire"); };
  const Router router(broken, routes(), folder_);
  Request request;
  request.method = "GET";
  request.path = {"api", "status"};
  const Response response = router.answer(request);
  EXPECT_EQ(response.status, 500);
  EXPECT_EQ(response.body, R"({"error":"disk on fire"})");
}

}  // namespace
}  // namespace sslv
