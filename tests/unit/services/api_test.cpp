// SPDX-License-Identifier: Apache-2.0
// The routes of all services, asked over HTTP from a whole daemon with one simulated camera.
#include "base/error.h"
#include "base/json.h"
#include "daemon.h"
#include "net/multicast.h"
#include "ssl_vision_wrapper.pb.h"
#include "support/becomes.h"
#include "support/group_listener.h"
#include "support/paths.h"
#include "support/temporary_folder.h"

#include <cctype>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <memory>
#include <optional>
#include <regex>
#include <set>
#include <span>
#include <stop_token>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <archive.h>
#include <archive_entry.h>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <httplib.h>

namespace sslv::api_test {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::EndsWith;
using testing::HasSubstr;
using testing::Key;
using testing::Not;
using testing::Pair;
using testing::StartsWith;

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

struct Reply {
  int status = 0;
  std::string body;
  httplib::Headers headers;
  Json json() const { return Json::parse(body); }
  std::string header(const std::string& name) const {
    const auto found = headers.find(name);
    return found == headers.end() ? "" : found->second;
  }
};

class Api : public testing::Test {
 protected:
  Api() {
    const Json settings{
        {"site", "test"},
        {"network",
         {{"vision", {{"group", GroupListener::kGroup}, {"port", group_.port()}, {"interface", "127.0.0.1"}}},
          {"referee", {{"enabled", false}}}}},
        {"panel", {{"port", 0}}},
        {"cameras",
         {{{"id", 0},
           {"calibration",
            {{"focal_length", 190},
             {"principal_point_x", 160},
             {"principal_point_y", 120},
             {"distortion", 0.08},
             {"q0", 0.7071},
             {"q1", -0.7071},
             {"q2", 0},
             {"q3", 0},
             {"tx", 0},
             {"ty", 0},
             {"tz", 4000},
             {"pixel_image_width", 320},
             {"pixel_image_height", 240}}},
           // So slow that a calibration of a hundred images outlasts every request.
           {"source", {{"backend", "simulator"}, {"width", 320}, {"height", 240}, {"frame_rate_hz", 2}}}}}}};
    std::ofstream(folder_.path() / "settings.json") << settings;
    daemon_.emplace(
        Daemon::Options{folder_.path() / "settings.json", folder_.path() / "state", "/var/empty"});
  }

  Reply ask(const std::string& method, const std::string& target, const std::string& body = {},
            httplib::Headers headers = {}) {
    httplib::Client client("127.0.0.1", daemon_->panel_port());
    client.set_read_timeout(test::kPatience);
    httplib::Request request;
    request.method = method;
    request.path = target;
    request.body = body;
    request.headers = std::move(headers);
    const auto result = client.send(request);
    if (!result) throw std::runtime_error(method + " " + target + ": no answer");
    return {result->status, result->body, result->headers};
  }

  /// Waits for the camera's first image.
  void wait_for_frame() {
    ASSERT_TRUE(test::becomes([&] { return ask("GET", "/api/cameras/0/snapshot.jpg").status != 503; }));
  }

  const test::TemporaryFolder folder_;
  const GroupListener group_;  // reserves its port
  std::optional<Daemon> daemon_;
};

std::string upper(std::string text) {
  for (char& letter : text) letter = static_cast<char>(std::toupper(static_cast<unsigned char>(letter)));
  return text;
}

TEST_F(Api, OpenApiNamesEveryRouteAndNoOther) {
  const Json file = Json::parse(std::ifstream(source_path("/docs/openapi.json")));
  std::set<const Route*> documented;
  for (const auto& [path, methods] : file.at("paths").items()) {
    if (path == "/api/openapi.json") continue;  // a file of the panel
    const std::string example = std::regex_replace(path, std::regex(R"(\{\w+\})"), "7");
    for (const auto& [method, operation] : methods.items()) {
      const Route* found = nullptr;
      for (const Route& route : daemon_->routes()) {
        if (upper(method) == route.method && std::regex_match(example, std::regex(route.pattern))) {
          found = &route;
          break;
        }
      }
      ASSERT_NE(found, nullptr) << method << " " << path << " is no route";
      EXPECT_TRUE(documented.insert(found).second) << method << " " << path;
    }
  }
  for (const Route& route : daemon_->routes())
    EXPECT_TRUE(documented.contains(&route)) << route.method << " " << route.pattern << " is not documented";
}

/// Routes by what they require, so that a new one cannot be open by mistake.
TEST_F(Api, EveryRouteAsksForWhatItNeeds) {
  const auto cookie_of = [](const Reply& reply) {
    EXPECT_EQ(reply.status, 200) << reply.body;
    const std::string cookie = reply.header("Set-Cookie");
    return cookie.substr(0, cookie.find(';'));
  };
  const std::string admin = cookie_of(ask("PUT", "/api/passwords/admin", R"({"password": "correct horse"})"));
  ask("PUT", "/api/passwords/viewer", R"({"password": "battery staple", "admin_password": "correct horse"})",
      {{"Cookie", admin}});
  const std::string viewer = cookie_of(ask("POST", "/api/session", R"({"password": "battery staple"})"));
  const std::set<std::string> open{"GET /api/session", "POST /api/session", "DELETE /api/session",
                                   "GET /metrics",     "GET /healthz",      "GET /readyz"};
  const std::set<std::string> for_admins{"GET /api/support", "GET /api/backup", "GET /api/files"};
  for (const Route& route : daemon_->routes()) {
    std::string path =
        std::regex_replace(route.pattern, std::regex(R"(\(\\d\+\)|\(\[\^/\]\+\)|\(\.\+\))"), "9");
    path = std::regex_replace(path, std::regex(R"(\\)"), "");
    const std::string name = std::string(route.method) + " " + path;
    const auto status = [&](const std::string& cookie) {
      return ask(route.method, path, "{", {{"Cookie", cookie}}).status;
    };
    if (open.contains(name)) {
      EXPECT_NE(status(""), 401) << name;
      continue;
    }
    EXPECT_EQ(status(""), 401) << name;
    EXPECT_EQ(status("ssl_visiond_0=0123"), 401) << name;
    const bool looks = route.method == std::string("GET") && !for_admins.contains(name);
    EXPECT_EQ(status(viewer) == 401, !looks) << name;
    EXPECT_NE(status(admin), 401) << name;
  }
}

TEST_F(Api, AWrongPasswordSaysSo) {
  EXPECT_EQ(ask("POST", "/api/session", R"({"password": "correct horse"})").status, 409) << "none is set";
  ask("PUT", "/api/passwords/admin", R"({"password": "correct horse"})");
  const Reply wrong = ask("POST", "/api/session", R"({"password": "wrong horse"})");
  EXPECT_EQ(wrong.status, 401);
  EXPECT_EQ(wrong.body, R"({"error":"wrong password"})");
  EXPECT_EQ(wrong.header("Set-Cookie"), "");
  EXPECT_EQ(wrong.header("WWW-Authenticate"), "Session");
  Reply late;
  EXPECT_TRUE(test::becomes([&] {
    late = ask("POST", "/api/session", R"({"password": "wrong horse"})");
    return late.status == 429;
  }));
  EXPECT_GT(std::stoi("0" + late.header("Retry-After")), 0);
  EXPECT_EQ(ask("POST", "/api/match_lock", R"({"opened": true})").status, 401);
}

TEST_F(Api, PacketsAreThoseThatCameBackFromTheNetwork) {
  Json packets;
  EXPECT_TRUE(test::becomes([&] {
    packets = ask("GET", "/api/network/packets").json();
    return !packets.at("detections").empty() && !packets.at("geometry").is_null();
  }));
  ASSERT_EQ(packets.at("detections").size(), 1U);
  const Json& detection = packets["detections"][0];
  EXPECT_EQ(detection.at("camera"), 0);
  EXPECT_EQ(detection.at("packet").at("detection").at("camera_id"), 0);
  EXPECT_GT(detection.at("bytes"), 0);
  EXPECT_EQ(packets.at("not_heard_because"), "");
  EXPECT_EQ(packets.at("broadcasts_not_heard_because"), "");
  EXPECT_EQ(packets["geometry"].at("packet").at("geometry").at("calib").size(), 1U);
  const Json listeners = ask("GET", "/api/network/listeners").json();
  EXPECT_EQ(listeners.at("group"), GroupListener::kGroup);
  EXPECT_EQ(listeners.at("programs"), Json::array());  // only the service itself listens
  EXPECT_EQ(listeners.at("memberships").at(0).at("interface"), "lo");
}

TEST_F(Api, PatchesAreSavedOrSayWhyNot) {
  const auto site = [](const char* name) {
    return Json{{{"op", "replace"}, {"path", "/site"}, {"value", name}}}.dump();
  };
  const std::string patch = site("x");
  const Json saved = ask("PATCH", "/api/settings", patch).json();
  EXPECT_EQ(saved["settings"]["site"], "x");
  EXPECT_EQ(saved["saved"], true);
  EXPECT_EQ(saved["revision"], 2);
  const Json again = ask("PATCH", "/api/settings", patch).json();
  EXPECT_EQ(again["revision"], 2) << "nothing has changed";
  EXPECT_EQ(ask("GET", "/api/settings/history").json().size(), 1U);
  EXPECT_EQ(ask("PATCH", "/api/settings", site("y"), {{"If-Match", "2"}}).status, 200);
  EXPECT_EQ(ask("PATCH", "/api/settings", site("z"), {{"If-Match", "\"3\""}}).status, 200);
  const Reply stale = ask("PATCH", "/api/settings", patch, {{"If-Match", "1"}});
  EXPECT_EQ(stale.status, 409);
  EXPECT_EQ(stale.json()["revision"], 4);
  EXPECT_EQ(stale.json()["changed_since"][0]["revision"], 4);
  EXPECT_EQ(ask("PATCH", "/api/settings", patch, {{"If-Match", "*"}}).status, 400);
  EXPECT_EQ(ask("PATCH", "/api/settings", "[{").status, 400);
  EXPECT_EQ(ask("PATCH", "/api/settings", "{}").status, 422);
  const Reply refused =
      ask("PATCH", "/api/settings", R"([{"op":"replace","path":"/panel/port","value":-1}])");
  EXPECT_EQ(refused.status, 422);
  EXPECT_THAT(refused.json()["error"].get<std::string>(), StartsWith("/panel/port: -1 is not allowed"));
}

TEST_F(Api, ChangesAreCheckedWithoutASave) {
  const std::string patch = R"([{"op":"replace","path":"/site","value":"x"}])";
  EXPECT_EQ(ask("POST", "/api/settings/check", patch).json()["changes"][0]["after"], "x");
  EXPECT_EQ(ask("GET", "/api/settings").json()["settings"]["site"], "test");
  EXPECT_EQ(ask("POST", "/api/settings/check", "[").status, 400);
  EXPECT_EQ(
      ask("POST", "/api/settings/check", R"([{"op":"replace","path":"/cameras/0/stack","value":["x"]}])")
          .status,
      422);
  EXPECT_EQ(ask("GET", "/api/settings/check").status, 405);
}

TEST_F(Api, ProfilesAreSavedAppliedAndRefused) {
  EXPECT_EQ(ask("GET", "/api/profiles").body, R"({"profiles":[]})");
  EXPECT_EQ(ask("GET", "/api/profiles/day").status, 404);
  EXPECT_EQ(ask("PUT", "/api/profiles/Nacht%20%C3%A4%2B+").json()["name"], "Nacht ä++");
  EXPECT_EQ(ask("PUT", "/api/profiles/x", R"({"settings": {"site": "y"}})").status, 200);
  for (const char* body : {"[]", "7", "{", R"({"setings": {}})", R"({"settings": {}, "more": 1})"})
    EXPECT_EQ(ask("PUT", "/api/profiles/x", body).status, 400) << body;

  const std::string apply = "/api/profiles/x/apply";
  for (const char* body : {R"({"paths": "/field"})", R"({"paths": [1]})", R"({"path": []})"})
    EXPECT_EQ(ask("POST", apply, body).status, 400) << body;
  EXPECT_EQ(ask("POST", apply, R"({"paths": ["/nowhere"]})").status, 422);
  EXPECT_EQ(ask("POST", apply, "", {{"If-Match", "7"}}).status, 409);
  EXPECT_EQ(ask("POST", apply, R"({"paths": ["/site"]})").json()["settings"]["site"], "y");
  EXPECT_EQ(ask("DELETE", "/api/profiles/x").json()["profiles"].size(), 1u);
}

TEST_F(Api, CalibrationSaysWhatIsWrongWithARequest) {
  const std::string path = "/api/cameras/0/calibration";
  EXPECT_EQ(ask("GET", path).json()["state"], "idle");
  EXPECT_EQ(ask("GET", "/api/cameras/7/calibration").status, 404);
  EXPECT_EQ(ask("POST", "/api/cameras/7/calibration/accept").status, 404);
  EXPECT_EQ(ask("POST", path, "{").status, 400);
  const Reply wrong = ask("POST", path, R"({"force": "yes"})");
  EXPECT_EQ(wrong.status, 422);
  EXPECT_THAT(wrong.json()["error"].get<std::string>(),
              HasSubstr(R"(/force: "yes" is not allowed; expected true or false)"));
  EXPECT_THAT(ask("POST", path + "/accept", R"({"forse": true})").body, HasSubstr("/forse: no such"));
  EXPECT_EQ(ask("POST", path + "/accept", R"({"force": true})").status, 409) << "there is none";
  EXPECT_EQ(ask("POST", path + "/reject").status, 409);
  EXPECT_EQ(ask("POST", path + "/revert").status, 409);
  EXPECT_EQ(ask("DELETE", path).status, 409);
  EXPECT_EQ(ask("PUT", path).status, 405);

  wait_for_frame();
  EXPECT_EQ(ask("POST", path, R"({"frames": 100, "force": true})").status, 202);
  EXPECT_EQ(ask("POST", path).status, 409) << "one at a time";
  EXPECT_EQ(ask("DELETE", path).json()["state"], "cancelled");
}

TEST_F(Api, CalibrationOfCamerasTogetherSaysWhatIsWrongWithARequest) {
  const std::string path = "/api/calibration";
  EXPECT_EQ(ask("GET", path).json()["state"], "idle");
  EXPECT_EQ(ask("POST", path, "{").status, 400);
  EXPECT_EQ(ask("POST", path, R"({"cameras": [7, 8]})").status, 422);
  EXPECT_EQ(ask("POST", path, R"({"cameras": [0]})").status, 422);
  EXPECT_EQ(ask("POST", path).status, 409) << "too few are calibrated";
  EXPECT_EQ(ask("POST", path + "/accept", R"({"force": 1})").status, 422);
  EXPECT_EQ(ask("POST", path + "/accept").status, 409);
  EXPECT_EQ(ask("POST", path + "/reject").status, 409);
  EXPECT_EQ(ask("DELETE", path).status, 409);
  EXPECT_EQ(ask("PUT", path).status, 405);
  EXPECT_EQ(ask("POST", path + "/revert").status, 404);
}

TEST_F(Api, OnlyACameraThatIsLostCanBeReopened) {
  wait_for_frame();
  EXPECT_EQ(ask("POST", "/api/cameras/9/reopen").status, 404);
  const Reply open = ask("POST", "/api/cameras/0/reopen");
  EXPECT_EQ(open.status, 409);
  EXPECT_THAT(open.body, HasSubstr("camera 0 is open"));
}

TEST_F(Api, ControlsSayWhatIsWrongWithARequest) {
  const std::string path = "/api/cameras/0/controls";
  wait_for_frame();
  EXPECT_EQ(ask("GET", path).status, 409) << "a simulated camera has none";
  EXPECT_EQ(ask("POST", path + "/Gain", "3").status, 400);
  EXPECT_EQ(ask("POST", path + "/Gain", R"({"value": 3, "save": true})").status, 400);
  EXPECT_EQ(ask("GET", "/api/cameras/7/controls").status, 404);
  EXPECT_EQ(ask("GET", "/api/cameras/99999999999/controls").status, 400);
}

TEST_F(Api, SnapshotsAreJpegsOfTheCameraOrItsLabels) {
  wait_for_frame();
  const Reply large = ask("GET", "/api/cameras/0/snapshot.jpg");
  const Reply small = ask("GET", "/api/cameras/0/snapshot.jpg?width=8&quality=20");
  const Reply labels = ask("GET", "/api/cameras/0/snapshot.jpg?picture=labels");
  EXPECT_EQ(large.header("Content-Type"), "image/jpeg");
  for (const Reply& one : {large, small, labels}) EXPECT_THAT(one.body, StartsWith("\xff\xd8\xff"));
  EXPECT_LT(small.body.size(), large.body.size());
  for (const char* query : {"?width=wide", "?width=0", "?quality=101", "?picture=regions"}) {
    const Reply refused = ask("GET", std::string("/api/cameras/0/snapshot.jpg") + query);
    EXPECT_EQ(refused.status, 400) << query;
    EXPECT_THAT(refused.body, HasSubstr("is not allowed; expected ")) << query;
  }
  EXPECT_EQ(ask("GET", "/api/cameras/1/snapshot.jpg").status, 404);
}

/// A camera's path in its settings, or another one, encoded for a URL query.
std::string query_of(const std::filesystem::path& path) {
  return httplib::detail::encode_query_param(path.string());
}

TEST_F(Api, ACameraThatIsNotAddedYetShowsOneImage) {
  const auto image_of = [&](const Json& source, const char* query = "") {
    return ask("POST", std::string("/api/sources/image") + query, Json{{"source", source}}.dump());
  };
  const auto photo = folder_.path() / "photo.jpg";
  std::filesystem::copy_file(source_path("/tests/golden/division_b.jpg"), photo);
  const Json found{{"backend", "files"}, {"path", photo.string()}};
  const Reply image = image_of(found, "?width=160");
  ASSERT_EQ(image.status, 200) << image.body;
  EXPECT_EQ(image.header("Content-Type"), "image/jpeg");
  EXPECT_THAT(image.body, StartsWith("\xff\xd8\xff"));
  EXPECT_EQ(ask("GET", "/api/settings").json()["settings"]["cameras"].size(), 1U) << "nothing is added";

  const Reply recorded =
      image_of({{"backend", "files"}, {"path", (folder_.path() / "settings.json").string()}});
  EXPECT_EQ(recorded.status, 503) << "no image";
  const Reply elsewhere = image_of({{"backend", "files"}, {"path", "/etc/passwd"}});
  EXPECT_EQ(elsewhere.status, 422);
  EXPECT_THAT(elsewhere.body, HasSubstr("/source/path: \\\"/etc/passwd\\\" is not allowed here"));
  EXPECT_THAT(elsewhere.body, Not(HasSubstr("root:")));
  EXPECT_EQ(image_of({{"backend", "telescope"}}).status, 422);
  EXPECT_EQ(image_of(found, "?width=0").status, 400);
  EXPECT_EQ(ask("POST", "/api/sources/image", "{}").status, 400);
}

TEST_F(Api, FilesAreListedWhereSettingsMayNameThem) {
  const auto in = folder_.path() / "state" / "recordings";
  std::filesystem::create_directories(in / "one");
  for (const char* name : {"b.jpg", "a.png", "film.mp4", "secret.json", ".hidden.jpg", "one/c.raw"})
    std::ofstream(in / name) << "x";
  std::filesystem::create_symlink("/etc", in / "out");
  std::filesystem::create_symlink("/etc/hostname", in / "out.jpg");
  std::filesystem::create_symlink(in / "one", in / "two");

  const auto names_in = [&](const std::string& target) {
    std::vector<std::string> names;
    const Json list = ask("GET", target).json();
    for (const Json& entry : list.at("entries")) names.push_back(entry["name"]);
    return names;
  };
  const auto real = std::filesystem::canonical(in);
  EXPECT_THAT(names_in("/api/files"), Contains((folder_.path() / "state").string()));
  EXPECT_THAT(names_in("/api/files?folder=" + query_of(in)),
              testing::ElementsAre("one", "two", "a.png", "b.jpg", "film.mp4"));
  const Json list = ask("GET", "/api/files?folder=" + query_of(in)).json();
  EXPECT_EQ(list["images"], 2);
  EXPECT_EQ(list["folder"], real.string());
  EXPECT_EQ(list["parent"], real.parent_path().string());

  for (const std::string& out :
       std::vector<std::string>{"/etc", "/", "etc", "..", (in / "out").string(), (in / "../../..").string(),
                                (in / "none").string()}) {
    const Reply refused = ask("GET", "/api/files?folder=" + query_of(out));
    EXPECT_EQ(refused.status, 422) << out << refused.body;
    EXPECT_THAT(refused.body, HasSubstr("folder: "));
  }
}

TEST_F(Api, ImagesAreUploadedWithinBounds) {
  std::ifstream file(source_path("/tests/golden/division_b.jpg"), std::ios::binary);
  const std::string jpeg{std::istreambuf_iterator<char>(file), {}};
  const auto upload = [&](const std::string& folder, const std::string& name, const std::string& bytes) {
    return ask("POST", "/api/images?folder=" + query_of(folder) + "&name=" + query_of(name), bytes);
  };
  const Reply saved = upload("hall 1", "a.jpg", jpeg);
  ASSERT_EQ(saved.status, 200) << saved.body;
  const std::string path = saved.json()["path"];
  EXPECT_THAT(path, EndsWith("/state/images/hall 1"));
  EXPECT_EQ(upload("hall 1", "a.jpg", jpeg).status, 200) << "in the place of the same";
  Json folders = ask("GET", "/api/images").json()["folders"];
  ASSERT_EQ(folders.size(), 1U);
  EXPECT_EQ(folders[0]["images"], 1);
  EXPECT_EQ(folders[0]["bytes"], jpeg.size());

  const auto expect_refused = [](const Reply& reply, const std::string& why) {
    EXPECT_EQ(reply.status, 422);
    EXPECT_THAT(reply.body, HasSubstr(why));
  };
  expect_refused(upload("hall 1", "b.jpg", "not an image"), "b.jpg: this is neither a JPEG nor a PNG");
  expect_refused(upload("hall 1", "b.png", jpeg), "b.png: this is a JPEG; expected a name that ends in .jpg");
  expect_refused(upload("hall 1", "b.jpg", jpeg.substr(0, jpeg.size() / 2)),
                 "b.jpg: this image cannot be read");
  std::string huge = "\x89PNG\r\n\x1a\n";
  huge += std::string("\0\0\0\rIHDR\0\0\x30\0\0\0\x30\0\x08\2\0\0\0", 21);
  expect_refused(upload("hall 1", "b.png", huge), "b.png: the image has more than 32 million pixels");
  for (const char* name : {"", "../a.jpg", "/etc/a.jpg", ".a.jpg"})
    expect_refused(upload("hall 1", name, jpeg), "name: ");
  for (const char* name : {"", "..", "a/b", ".trial"})
    expect_refused(upload(name, "a.jpg", jpeg), "folder: ");
  EXPECT_EQ(upload("hall 1", "b.jpg", std::string(17 * 1024 * 1024, 'x')).status, 413);
  EXPECT_EQ(ask("GET", "/api/images").json()["folders"], folders) << "nothing was added";

  // Images that a camera uses cannot be removed.
  const Json add = {{{"op", "add"},
                     {"path", "/cameras/-"},
                     {"value", {{"id", 1}, {"source", {{"backend", "files"}, {"path", path}}}}}}};
  ASSERT_EQ(ask("PATCH", "/api/settings", add.dump()).status, 200);
  const Json cameras = ask("GET", "/api/status").json()["cameras"];
  EXPECT_EQ(cameras[0]["origin"], "simulation");
  EXPECT_EQ(cameras[1]["origin"], "recording");
  const Reply used = ask("DELETE", "/api/images/hall%201");
  EXPECT_EQ(used.status, 409);
  EXPECT_THAT(used.body, HasSubstr("/cameras/1/source/path names these images"));
  ASSERT_EQ(ask("PATCH", "/api/settings", R"([{"op": "remove", "path": "/cameras/1"}])").status, 200);
  EXPECT_EQ(ask("DELETE", "/api/images/hall%201").status, 200);
  EXPECT_EQ(ask("DELETE", "/api/images/hall%201").status, 404);
  EXPECT_EQ(ask("DELETE", "/api/images/..").status, 422);
  EXPECT_TRUE(ask("GET", "/api/images").json()["folders"].empty());
}

TEST_F(Api, StatusSaysWhereThePanelIs) {
  const Json panel = ask("GET", "/api/status").json()["panel"];
  EXPECT_EQ(panel["port"], daemon_->panel_port());
  EXPECT_TRUE(panel["addresses"].empty()) << "only this computer reaches it without a password";
}

TEST_F(Api, BadRequestsForAStreamAreRefused) {
  for (const char* query : {"?width=0", "?width=x", "?quality=101", "?fps=0", "?fps=nan", "?fps=1e9",
                            "?fps=", "?picture=regions"}) {
    const Reply refused = ask("GET", std::string("/api/cameras/0/stream.mjpg") + query);
    EXPECT_EQ(refused.status, 400) << query;
    EXPECT_THAT(refused.body, HasSubstr("is not allowed; expected ")) << query;
  }
  EXPECT_THAT(ask("GET", "/api/cameras/0/stream.mjpg?fps=0").body,
              HasSubstr("fps: \\\"0\\\" is not allowed; expected a number 0.01 .. 1000"));
  EXPECT_EQ(ask("GET", "/api/cameras/1/stream.mjpg").status, 404);
}

TEST_F(Api, TheColourTableIsAFile) {
  const Reply table = ask("GET", "/api/cameras/0/colors/table");
  const Reply lut = ask("GET", "/api/cameras/0/colors/export");
  EXPECT_EQ(table.body, lut.body);
  EXPECT_EQ(lut.header("Content-Disposition"), "attachment; filename=\"colours-of-camera-0.lut\"");
  EXPECT_THAT(ask("GET", "/api/cameras/0/colors/export?format=json").header("Content-Disposition"),
              HasSubstr("colours-of-camera-0.json"));
  EXPECT_EQ(ask("GET", "/api/cameras/1/colors/table").status, 404);
  EXPECT_EQ(ask("POST", "/api/cameras/0/colors/undo").status, 409);
  EXPECT_EQ(ask("POST", "/api/cameras/0/colors/edits", "{}").status, 422);
}

TEST_F(Api, ASupportBundleSaysWhatIsInIt) {
  wait_for_frame();
  const Reply bundle = ask("GET", "/api/support");
  EXPECT_EQ(bundle.header("Content-Type"), "application/gzip");
  EXPECT_THAT(bundle.header("Content-Disposition"),
              AllOf(HasSubstr("attachment; filename=\"ssl-visiond-"), HasSubstr(".tar.gz\"")));
  const auto files = unpacked(bundle.body);
  for (const char* name :
       {"/version.txt", "/status.json", "/settings.json", "/settings_history.json", "/diagnostics.json",
        "/timeline.json", "/events.json", "/log.txt", "/camera_0/calibration.json"})
    EXPECT_THAT(files, Contains(Key(EndsWith(name))));
  EXPECT_THAT(files, Contains(Pair(EndsWith("/camera_0/picture.jpg"), StartsWith("\xff\xd8\xff"))));
  EXPECT_THAT(files.front().first, EndsWith("/README.txt"));
  EXPECT_THAT(files.front().second, HasSubstr("\nstatus.json: "));
}

TEST_F(Api, AReaddedCameraKeepsNothingOfTheOldOne) {
  wait_for_frame();
  // The camera is removed and added again: the daemon does not wait for the old one, and the new one
  // delivers.
  const Json source = ask("GET", "/api/settings").json()["settings"]["cameras"][0];
  EXPECT_EQ(ask("PATCH", "/api/settings", R"([{"op":"remove","path":"/cameras/0"}])").status, 200);
  EXPECT_EQ(ask("GET", "/api/cameras").body, "[]");
  EXPECT_EQ(ask("GET", "/api/cameras/0/snapshot.jpg").status, 404);
  const Json patch{{{"op", "add"}, {"path", "/cameras/-"}, {"value", source}}};
  EXPECT_EQ(ask("PATCH", "/api/settings", patch.dump()).status, 200);
  wait_for_frame();
}

/// Listeners on the network must stop before the services that they notify.
TEST(AStartThatFails, StopsListenersBeforeTheServicesTheyNotify) {
  const GroupListener group;
  const test::TemporaryFolder folder;
  boost::asio::io_context io;
  const boost::asio::ip::tcp::acceptor taken(io, {boost::asio::ip::make_address("127.0.0.1"), 0});
  const MulticastSettings vision{
      .group = GroupListener::kGroup, .port = group.port(), .interface = "127.0.0.1"};
  const Json settings{
      {"network",
       {{"vision", {{"group", vision.group}, {"port", vision.port}, {"interface", vision.interface}}},
        {"referee", {{"enabled", false}}}}},
      {"panel", {{"port", taken.local_endpoint().port()}}}};
  std::ofstream(folder.path() / "settings.json") << settings;
  SSL_WrapperPacket other;
  auto& frame = *other.mutable_detection();
  frame.set_frame_number(1);
  frame.set_t_capture(1);
  frame.set_t_sent(1);
  frame.set_camera_id(21);
  const std::string bytes = other.SerializeAsString();
  MulticastSender sender(vision);
  const std::jthread sending([&](const std::stop_token& stop) {
    while (!stop.stop_requested()) sender.send(std::as_bytes(std::span(bytes)));
  });
  for (int i = 0; i < 10; ++i) {
    EXPECT_THROW(Daemon({folder.path() / "settings.json", folder.path() / "state", "/var/empty"}), BusyError);
  }
}

}  // namespace
}  // namespace sslv::api_test
