// SPDX-License-Identifier: Apache-2.0
#include "web/router.h"

#include "base/log.h"
#include "routes.h"
#include "unit/web/fake_host.h"

#include <filesystem>
#include <fstream>
#include <regex>
#include <set>

#include <archive.h>
#include <archive_entry.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

namespace sslv {
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

/// Names and contents of a .tar.gz's files.
std::vector<std::pair<std::string, std::string>> unpacked(const std::string& bytes) {
  std::vector<std::pair<std::string, std::string>> files;
  const std::unique_ptr<archive, decltype(&archive_read_free)> in(archive_read_new(), archive_read_free);
  archive_read_support_filter_gzip(in.get());
  archive_read_support_format_tar(in.get());
  EXPECT_EQ(archive_read_open_memory(in.get(), bytes.data(), bytes.size()), ARCHIVE_OK);
  archive_entry* entry = nullptr;
  while (archive_read_next_header(in.get(), &entry) == ARCHIVE_OK) {
    std::string content(static_cast<std::size_t>(archive_entry_size(entry)), '\0');
    EXPECT_EQ(archive_read_data(in.get(), content.data(), content.size()),
              static_cast<la_ssize_t>(content.size()));
    files.emplace_back(archive_entry_pathname(entry), content);
  }
  return files;
}

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
  const WebHost host_ = daemon_.host();
  const Router router_{host_, routes(), folder_ / "panel"};
};

TEST_F(RouterTest, AnswersFromTheHost) {
  EXPECT_EQ(ask("GET", "/api/status").body, to_text(host_.status()));
  EXPECT_EQ(ask("GET", "/api/cameras").body, R"([{"id":0}])");
  EXPECT_EQ(ask("GET", "/api/settings").body, R"({"revision":7,"settings":{"site":"test"}})");
  EXPECT_EQ(ask("GET", "/api/schema").body, R"({"type":"object"})");
  EXPECT_EQ(ask("GET", "/api/field/presets").body, R"([{"name":"division-b"}])");
  EXPECT_EQ(ask("GET", "/api/network/interfaces").body, R"({"interfaces":[{"name":"lo"}]})");
  EXPECT_THAT(ask("GET", "/api/schema").header, AllOf(HasSubstr("Content-Type: application/json\r\n"),
                                                      HasSubstr("Cache-Control: no-store\r\n")));
}

TEST_F(RouterTest, MonitoringGetsPlainTextThatNobodyKeeps) {
  for (const auto& [path, status, text, type] :
       {std::tuple("/metrics", 200, "up 1\n", "text/plain; version=0.0.4; charset=utf-8"),
        {"/healthz", 200, "ok\n", "text/plain; charset=utf-8"},
        {"/readyz", 503, "camera 0 is lost\n", "text/plain; charset=utf-8"}}) {
    const Answer answer = ask("GET", path);
    EXPECT_EQ(answer.status, status) << path;
    EXPECT_EQ(answer.body, text);
    EXPECT_THAT(answer.header, AllOf(HasSubstr(std::string("Content-Type: ") + type + "\r\n"),
                                     HasSubstr("Cache-Control: no-store\r\n")));
    EXPECT_EQ(ask("HEAD", path).status, status) << path;
    EXPECT_EQ(ask("HEAD", path).body, "");
    EXPECT_EQ(ask("POST", path).status, 405) << path;
  }
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

/// Routes by what they ask for, so that a new one cannot be open by mistake.
TEST_F(RouterTest, EveryRouteAsksForWhatItNeeds) {
  daemon_.passwords().set(Role::kAdmin, "correct horse");
  daemon_.passwords().set(Role::kViewer, "battery staple");
  const auto signed_in = [&](const std::string& password) {
    const Answer answer = ask("POST", "/api/session", R"({"password": ")" + password + R"("})");
    EXPECT_EQ(answer.status, 200) << answer.body;
    const std::size_t at = answer.header.find("Set-Cookie: ") + std::string_view("Set-Cookie: ").size();
    return "Cookie: " + answer.header.substr(at, answer.header.find(';', at) - at) + "\r\n";
  };
  const std::string admin = signed_in("correct horse"), viewer = signed_in("battery staple");
  const std::set<std::string> open{"GET /api/session", "POST /api/session", "DELETE /api/session",
                                   "GET /metrics",     "GET /healthz",      "GET /readyz"};
  const std::set<std::string> for_admins{"GET /api/support"};
  for (const Route& route : routes()) {
    std::string path =
        std::regex_replace(route.pattern, std::regex(R"(\(\\d\+\)|\(\[\^/\]\+\)|\(\.\+\))"), "9");
    path = std::regex_replace(path, std::regex(R"(\\)"), "");
    const std::string name = std::string(route.method) + " " + path;
    const auto status = [&](const std::string& cookie) {
      return ask(route.method, path, "{", cookie).status;
    };
    if (open.contains(name)) {
      EXPECT_NE(status(""), 401) << name;
      continue;
    }
    EXPECT_EQ(status(""), 401) << name;
    EXPECT_EQ(status("Cookie: session=0123\r\n"), 401) << name;
    const bool looks = route.method == std::string("GET") && !for_admins.contains(name);
    EXPECT_EQ(status(viewer) == 401, !looks) << name;
    EXPECT_NE(status(admin), 401) << name;
  }
  EXPECT_EQ(ask("GET", "/").status, 200) << "the page that asks for the password";
}

TEST_F(RouterTest, AWrongPasswordSaysSo) {
  EXPECT_EQ(ask("POST", "/api/session", R"({"password": "correct horse"})").status, 409) << "none is set";
  daemon_.passwords().set(Role::kAdmin, "correct horse");
  const Answer wrong = ask("POST", "/api/session", R"({"password": "wrong horse"})");
  EXPECT_EQ(wrong.status, 401);
  EXPECT_EQ(wrong.body, R"({"error":"this is not a password of this service"})");
  EXPECT_THAT(wrong.header, AllOf(Not(HasSubstr("Set-Cookie")), HasSubstr("WWW-Authenticate: Session")));
  for (int i = 0; i < 4; ++i) ask("POST", "/api/session", R"({"password": "wrong horse"})");
  const Answer late = ask("POST", "/api/session", R"({"password": "correct horse"})");
  EXPECT_EQ(late.status, 429);
  EXPECT_THAT(late.header, HasSubstr("Retry-After: 10\r\n"));
}

TEST_F(RouterTest, AMatchLocksTheSettings) {
  const std::string patch = R"([{"op": "replace", "path": "/site", "value": "x"}])";
  daemon_.let_match_run(true);
  const Answer locked = ask("PATCH", "/api/settings", patch);
  EXPECT_EQ(locked.status, 423);
  EXPECT_THAT(locked.body, HasSubstr("the game is running"));
  EXPECT_EQ(ask("POST", "/api/settings/check", patch).status, 200) << "looking is allowed";
  EXPECT_EQ(ask("GET", "/api/settings").status, 200);
  EXPECT_THAT(ask("GET", "/api/session").body, HasSubstr(R"("locked":true)"));
  EXPECT_EQ(ask("POST", "/api/match_lock", R"({"opened": true})").body,
            R"({"game_is_running":true,"opened":true,"locked":false})");
  EXPECT_EQ(ask("PATCH", "/api/settings", patch).status, 200);
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
  EXPECT_THAT(lines([&] { ask("PUT", "/api/passwords/admin", R"({"password": "correct horse"})"); }),
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
  for (const char* target :
       {"/api", "/api/nothing", "/api/status/more", "/api/cameras/0", "/api/cameras/0/colors/table/x",
        "/api/cameras/x/colors", "/api/../secret.txt"}) {
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
  EXPECT_THAT(ask("PATCH", "/api/cameras/0/colors/table", "[]").header,
              AllOf(StartsWith("HTTP/1.1 405"), HasSubstr("Allow: GET\r\n")));
  EXPECT_EQ(ask("DELETE", "/index.html").status, 405);
  EXPECT_EQ(ask("POST", "/api/nothing").status, 404);
}

TEST_F(RouterTest, PatchesReachTheHost) {
  const std::string patch = R"([{"op":"replace","path":"/site","value":"x"}])";
  const Answer saved = ask("PATCH", "/api/settings", patch);
  EXPECT_EQ(saved.status, 200);
  EXPECT_EQ(saved.body, R"({"revision":8,"settings":)" + patch + R"(,"saved":true})");
  EXPECT_EQ(daemon_.last_author(), "192.0.2.7");
  EXPECT_EQ(ask("PATCH", "/api/settings", patch, "If-Match: 7\r\n").status, 200);
  EXPECT_EQ(ask("PATCH", "/api/settings", patch, "If-Match: \"7\"\r\n").status, 200);
}

TEST_F(RouterTest, BadPatchesAreRefused) {
  EXPECT_EQ(ask("PATCH", "/api/settings", "[{").status, 400);
  EXPECT_EQ(ask("PATCH", "/api/settings", "[1]", "If-Match: 6\r\n").status, 409);
  EXPECT_EQ(ask("PATCH", "/api/settings", "[1]", "If-Match: *\r\n").status, 400);
  const Answer refused = ask("PATCH", "/api/settings", "[]");
  EXPECT_EQ(refused.status, 422);
  EXPECT_EQ(refused.body, R"({"error":"/site: refused"})");
}

TEST_F(RouterTest, ChangesAreCheckedWithoutASave) {
  const std::string patch = R"([{"op":"replace","path":"/site","value":"x"}])";
  EXPECT_EQ(ask("POST", "/api/settings/check", patch).body, R"({"changes":)" + patch + "}");
  EXPECT_EQ(daemon_.last_author(), "");
  EXPECT_EQ(ask("POST", "/api/settings/check", "[]").body, R"({"error":"/site: refused"})");
  EXPECT_EQ(ask("POST", "/api/settings/check", "[").status, 400);
  EXPECT_EQ(ask("GET", "/api/settings/check").status, 405);
}

TEST_F(RouterTest, ProfilesReachTheHost) {
  EXPECT_EQ(ask("GET", "/api/profiles").body, R"({"profiles":[{"name":"night"}]})");
  EXPECT_EQ(ask("GET", "/api/profiles/night").body, R"({"name":"night"})");
  EXPECT_EQ(ask("GET", "/api/profiles/day").status, 404);
  EXPECT_EQ(ask("DELETE", "/api/profiles/night").body, R"({"profiles":[]})");

  const auto saved = [&](const std::string& name, const std::string& body = {}) {
    return Json::parse(ask("PUT", "/api/profiles/" + name, body).body);
  };
  EXPECT_EQ(saved("Nacht%20%C3%A4%2B+")["name"], "Nacht ä++");
  EXPECT_EQ(saved("a%2Fb")["name"], "a/b");  // for the host to refuse
  EXPECT_EQ(saved("x")["settings"], "in force");
  EXPECT_EQ(saved("x", "{}")["settings"], "in force");
  EXPECT_EQ(saved("x", R"({"settings": {"site": "y"}})")["settings"], Json::parse(R"({"site": "y"})"));
  for (const char* body : {"[]", "7", "{", R"({"setings": {}})", R"({"settings": {}, "more": 1})"})
    EXPECT_EQ(ask("PUT", "/api/profiles/x", body).status, 400) << body;

  const std::string apply = "/api/profiles/x/apply";
  EXPECT_EQ(Json::parse(ask("POST", apply).body), Json::parse(R"({"name": "x", "paths": ["all"]})"));
  EXPECT_EQ(Json::parse(ask("POST", apply, R"({"paths": ["/field"]})").body)["paths"], Json{"/field"});
  EXPECT_EQ(ask("POST", apply, "", "If-Match: 6\r\n").status, 409);
  for (const char* body : {R"({"paths": "/field"})", R"({"paths": [1]})", R"({"path": []})"})
    EXPECT_EQ(ask("POST", apply, body).status, 400) << body;
}

TEST_F(RouterTest, ASupportBundleIsAnArchiveThatSaysWhatIsMissing) {
  const Answer bundle = ask("GET", "/api/support");
  EXPECT_EQ(bundle.status, 200);
  EXPECT_THAT(bundle.header, AllOf(HasSubstr("Content-Type: application/gzip\r\n"),
                                   HasSubstr("attachment; filename=\"ssl-visiond-"), HasSubstr(".tar.gz\"")));
  const auto files = unpacked(bundle.body);
  EXPECT_THAT(files, AllOf(Contains(Key(EndsWith("/status.json"))), Contains(Key(EndsWith("/settings.json"))),
                           Contains(Key(EndsWith("/settings_history.json"))),
                           Contains(Key(EndsWith("/camera_0/calibration.json")))));
  // This daemon has neither a version nor a picture.
  EXPECT_THAT(files,
              AllOf(Not(Contains(Key(EndsWith("version.txt")))), Not(Contains(Key(EndsWith(".jpg"))))));
  const auto readme = files.begin();
  EXPECT_THAT(readme->first, EndsWith("/README.txt"));
  EXPECT_THAT(readme->second,
              AllOf(HasSubstr("\nstatus.json: "), HasSubstr("\ncamera_0/picture.jpg: its newest picture, in "
                                                            "full size; missing: no picture yet\n")));

  daemon_.publish(1);
  const auto with_picture = unpacked(ask("GET", "/api/support").body);
  EXPECT_THAT(with_picture, Contains(Pair(EndsWith("/camera_0/picture.jpg"), StartsWith("\xff\xd8\xff"))));
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
  EXPECT_EQ(plain.stream->preview.width, PreviewWish{}.width);

  const HttpAnswer wish = head_of("GET", "?width=99&quality=12&fps=2.5&picture=labels");
  ASSERT_TRUE(wish.stream);
  EXPECT_EQ(wish.stream->camera_id, 0u);
  EXPECT_EQ(wish.stream->preview.width, 99);
  EXPECT_EQ(wish.stream->preview.quality, 12);
  EXPECT_EQ(wish.stream->preview.fps, 2.5);
  EXPECT_EQ(wish.stream->preview.picture, PictureKind::kLabels);

  const HttpAnswer head = head_of("HEAD", "");
  EXPECT_EQ(head.bytes, plain.bytes);
  EXPECT_FALSE(head.stream);
}

TEST_F(RouterTest, BadRequestsForAStreamAreRefused) {
  for (const char* query : {"?width=0", "?width=x", "?quality=101", "?fps=0", "?fps=nan", "?fps=1e9",
                            "?fps=", "?picture=regions"}) {
    const Answer refused = ask("GET", std::string("/api/cameras/0/stream.mjpg") + query);
    EXPECT_EQ(refused.status, 400) << query;
    EXPECT_THAT(refused.body, HasSubstr("is not allowed; expected ")) << query;
  }
  EXPECT_THAT(ask("GET", "/api/cameras/0/stream.mjpg?fps=0").body,
              HasSubstr("fps: \\\"0\\\" is not allowed; expected a number 0.01 .. 1000"));
  EXPECT_EQ(ask("GET", "/api/cameras/1/stream.mjpg").status, 404);
  EXPECT_EQ(ask("HEAD", "/api/cameras/1/stream.mjpg").status, 404);
  EXPECT_EQ(ask("POST", "/api/cameras/0/stream.mjpg").status, 405);
}

TEST_F(RouterTest, CalibrationReachesTheHost) {
  const std::string path = "/api/cameras/0/calibration";
  EXPECT_EQ(Json::parse(ask("GET", path).body)["state"], "idle");
  const Answer started = ask("POST", path, R"({"frames": 3, "force": true})");
  EXPECT_EQ(started.status, 202);
  EXPECT_EQ(Json::parse(started.body),
            Json::parse(R"({"camera": 0, "request": {"frames": 3}, "force": true, "who": "192.0.2.7"})"));
  const Json plain = Json::parse(ask("POST", path).body);
  EXPECT_EQ(plain["request"], Json::object());
  EXPECT_EQ(plain["force"], false);
  EXPECT_EQ(Json::parse(ask("DELETE", path).body)["cancelled"], 0);
  EXPECT_EQ(Json::parse(ask("POST", path + "/accept").body)["force"], false);
  EXPECT_EQ(Json::parse(ask("POST", path + "/accept", R"({"force": true})").body)["force"], true);
  EXPECT_EQ(ask("POST", path + "/reject").status, 200);
  EXPECT_EQ(Json::parse(ask("POST", path + "/revert", R"({"force": true})").body)["who"], "192.0.2.7");
}

TEST_F(RouterTest, BadRequestsForCalibrationAreRefused) {
  const std::string path = "/api/cameras/0/calibration";
  EXPECT_EQ(ask("GET", "/api/cameras/7/calibration").status, 404);
  EXPECT_EQ(ask("POST", "/api/cameras/7/calibration/accept").status, 404);
  EXPECT_EQ(ask("POST", path, "{").status, 400);
  EXPECT_EQ(ask("POST", path, R"({"busy": 1})").status, 409);
  const Answer wrong = ask("POST", path, R"({"force": "yes"})");
  EXPECT_EQ(wrong.status, 422);
  EXPECT_THAT(wrong.body, HasSubstr("/force: \\\"yes\\\" is not allowed; expected true or false"));
  EXPECT_THAT(ask("POST", path + "/accept", R"({"forse": true})").body, HasSubstr("/forse: no such"));
  EXPECT_EQ(ask("POST", path + "/revert").status, 423);
  EXPECT_EQ(ask("PUT", path).status, 405);
}

TEST_F(RouterTest, CalibrationOfCamerasTogetherReachesTheHost) {
  const std::string path = "/api/calibration";
  EXPECT_EQ(Json::parse(ask("GET", path).body)["state"], "idle");
  const Answer started = ask("POST", path, R"({"cameras": [0, 1], "force": true})");
  EXPECT_EQ(started.status, 202);
  EXPECT_EQ(Json::parse(started.body),
            Json::parse(R"({"request": {"cameras": [0, 1]}, "force": true, "who": "192.0.2.7"})"));
  EXPECT_EQ(Json::parse(ask("DELETE", path).body)["cancelled"], "all");
  EXPECT_EQ(Json::parse(ask("POST", path + "/accept").body)["force"], false);
  EXPECT_EQ(Json::parse(ask("POST", path + "/accept", R"({"force": true})").body)["force"], true);
  EXPECT_EQ(ask("POST", path + "/reject").status, 200);
  EXPECT_EQ(ask("POST", path, "{").status, 400);
  EXPECT_EQ(ask("POST", path + "/accept", R"({"force": 1})").status, 422);
  EXPECT_EQ(ask("PUT", path).status, 405);
  EXPECT_EQ(ask("POST", path + "/revert").status, 404);
}

TEST_F(RouterTest, ControlsOfACameraReachTheHost) {
  const std::string path = "/api/cameras/0/controls";
  EXPECT_EQ(Json::parse(ask("GET", path).body)["controls"][0]["name"], "Gain");
  const Json set = Json::parse(ask("POST", path + "/Gain", R"({"value": 3})").body);
  EXPECT_EQ(set, Json::parse(R"({"camera": 0, "name": "Gain", "value": 3, "who": "192.0.2.7"})"));
  EXPECT_EQ(Json::parse(ask("POST", path + "/Gain").body)["value"], nullptr);  // an action
  EXPECT_EQ(ask("POST", path + "/Glow", R"({"value": 3})").status, 422);
  EXPECT_EQ(ask("POST", path + "/Gain", "3").status, 400);
  EXPECT_EQ(ask("POST", path + "/Gain", R"({"value": 3, "save": true})").status, 400);
  EXPECT_EQ(ask("GET", "/api/cameras/7/controls").status, 404);
  EXPECT_EQ(Json::parse(ask("GET", "/api/sources").body)["sources"][0]["backend"], "aravis");
}

TEST_F(RouterTest, WritesFromOtherSitesAreRefused) {
  const std::string foreign = "Origin: http://evil.example\r\n";
  EXPECT_EQ(ask("PATCH", "/api/settings", "[1]", foreign).status, 403);
  EXPECT_EQ(daemon_.last_author(), "");
  // The browser keeps it from the other site.
  EXPECT_EQ(ask("GET", "/api/settings", "", foreign).status, 200);
}

TEST_F(RouterTest, SnapshotsAreOfTheCameraOrItsLabels) {
  daemon_.publish(1);
  const Answer camera = ask("GET", "/api/cameras/0/snapshot.jpg?picture=camera");
  EXPECT_EQ(camera.body, ask("GET", "/api/cameras/0/snapshot.jpg").body);
  EXPECT_EQ(daemon_.drawings(), 0);
  const Answer labels = ask("GET", "/api/cameras/0/snapshot.jpg?picture=labels");
  EXPECT_THAT(labels.body, StartsWith("\xff\xd8\xff"));
  EXPECT_NE(labels.body, camera.body);
  EXPECT_EQ(daemon_.drawings(), 1);
  const Answer refused = ask("GET", "/api/cameras/0/snapshot.jpg?picture=regions");
  EXPECT_EQ(refused.status, 400);
  EXPECT_THAT(refused.body, HasSubstr("picture: \\\"regions\\\" is not allowed"));

  daemon_.make_no_runs();
  daemon_.publish(2);
  EXPECT_EQ(ask("GET", "/api/cameras/0/snapshot.jpg?picture=labels").body, camera.body);
}

TEST_F(RouterTest, SnapshotsAreJpegs) {
  EXPECT_EQ(ask("GET", "/api/cameras/0/snapshot.jpg").status, 503);
  daemon_.publish(1);
  const Answer large = ask("GET", "/api/cameras/0/snapshot.jpg");
  const Answer small = ask("GET", "/api/cameras/0/snapshot.jpg?width=8&quality=20");
  EXPECT_EQ(large.status, 200);
  EXPECT_THAT(large.header, HasSubstr("Content-Type: image/jpeg\r\n"));
  EXPECT_THAT(large.body, StartsWith("\xff\xd8\xff"));
  EXPECT_THAT(small.body, StartsWith("\xff\xd8\xff"));
  EXPECT_LT(small.body.size(), large.body.size());

  const Answer refused = ask("GET", "/api/cameras/0/snapshot.jpg?width=wide");
  EXPECT_EQ(refused.status, 400);
  EXPECT_THAT(refused.body, HasSubstr("width"));
  EXPECT_EQ(ask("GET", "/api/cameras/0/snapshot.jpg?quality=101").status, 400);
  EXPECT_EQ(ask("GET", "/api/cameras/1/snapshot.jpg").status, 404);
  EXPECT_EQ(ask("GET", "/api/cameras/99999999999/snapshot.jpg").status, 400);
}

TEST_F(RouterTest, TheColourTableIsAFile) {
  EXPECT_EQ(ask("GET", "/api/cameras/0/colors/table").body, "\x01\x02\x03");
  const Answer lut = ask("GET", "/api/cameras/0/colors/export");
  EXPECT_EQ(lut.body, "\x01\x02\x03");
  EXPECT_THAT(lut.header,
              HasSubstr("Content-Disposition: attachment; filename=\"colours-of-camera-0.lut\"\r\n"));
  EXPECT_EQ(ask("GET", "/api/cameras/1/colors/table").status, 404);
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
       {"/nothing.js", "/assets", "/assets/nothing.js", "/secret.txt", "//etc/passwd", "/panel/index.html",
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
    EXPECT_EQ(answer.body, R"({"error":"the address has a zero byte in it"})") << target;
  }
}

TEST_F(RouterTest, SaysHowToBuildAMissingPanel) {
  const Router router(host_, routes(), folder_ / "nowhere");
  const Answer response = ask(router, "GET", "/");
  EXPECT_EQ(response.status, 503);
  EXPECT_THAT(response.body, HasSubstr("./run build"));
}

TEST_F(RouterTest, AnUnexpectedFailureIs500) {
  WebHost broken = daemon_.host();
  broken.status = []() -> Json { throw std::runtime_error("disk on fire"); };
  const Router router(broken, routes(), folder_);
  const Answer response = ask(router, "GET", "/api/status");
  EXPECT_EQ(response.status, 500);
  EXPECT_EQ(response.body, R"({"error":"disk on fire"})");
}

TEST_F(RouterTest, RequestsThatMakeNoSenseAreTheLastOfTheirConnection) {
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

TEST_F(RouterTest, HeadIsGetWithoutTheBody) {
  const Answer head = ask("HEAD", "/api/schema"), file = ask("HEAD", "/");
  EXPECT_THAT(head.header, AllOf(StartsWith("HTTP/1.1 200"), HasSubstr("Content-Length: 17\r\n")));
  EXPECT_EQ(head.body, "");
  EXPECT_THAT(file.header, AllOf(StartsWith("HTTP/1.1 200"), HasSubstr("Content-Length: 15\r\n")));
  EXPECT_EQ(file.body, "");
  EXPECT_EQ(ask("HEAD", "/api/nothing").status, 404);
}

TEST_F(RouterTest, NothingIsMultipliedOrUnpackedForAClient) {
  std::string ranges = "Range: bytes=0-";
  while (ranges.size() < 1000) ranges += ",0-";
  EXPECT_EQ(ask("GET", "/", "", ranges + "\r\n").body, "<!doctype html>");
  EXPECT_EQ(ask("GET", "/", "", "Range: bytes=" + std::string(1000, '1') + "-\r\n").status, 416);
  EXPECT_EQ(ask("GET", "/api/cameras/" + std::string(1000, '1') + "/colors").status, 400);
  EXPECT_THAT(ask("GET", "/", "", "Accept-Encoding: gzip, br\r\n").header,
              Not(HasSubstr("Content-Encoding")));
  EXPECT_EQ(ask("PATCH", "/api/settings", "[1]", "Content-Encoding: gzip\r\n").status, 200);
  EXPECT_EQ(ask("PATCH", "/api/settings", "[1]", "Content-Type: multipart/form-data; boundary=x\r\n").status,
            200);
  EXPECT_THAT(ask("PATCH", "/api/settings", "[1]", "Expect: 100-continue\r\n").header,
              StartsWith("HTTP/1.1 200"));
}

}  // namespace
}  // namespace sslv
