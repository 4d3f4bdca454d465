// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/error.h"
#include "services/access/access.h"
#include "support/latest.h"
#include "support/patience.h"
#include "support/temporary_folder.h"
#include "web/gate.h"
#include "web/http.h"
#include "web/route.h"
#include "web/server.h"
#include "web/view.h"
#include "web/websocket.h"

#include <atomic>
#include <cstdint>
#include <future>
#include <memory>
#include <mutex>
#include <optional>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

namespace sslv {

/// Everything that a web server needs: a daemon with camera 0, whose frames a test publishes. It must outlive
/// all servers that use it.
class FakeHost : public Gate, public ViewSource, public Topic {
 public:
  static constexpr int kWidth = 64, kHeight = 48;
  static constexpr int kLabelsWidth = 32, kLabelsHeight = 24;

  /// `robots` replaces the list of robots. `hold` is released together with the frame.
  void publish(std::uint32_t frame_number, const Json& robots = Json::array(),
               std::shared_ptr<const void> hold = {}) {
    auto view = std::make_shared<View>();
    view->hold = std::move(hold);
    view->image = {pixels_.data(), kWidth, kHeight, kWidth, PixelFormat::kMono8};
    view->frame_number = frame_number;
    view->t_capture_s = 0.5 + frame_number;
    view->detections = {{"robots", robots}, {"balls", Json::array()}};
    if (makes_runs_) {
      view->regions = [this] {
        ++region_lists_;
        return Json{{"labels", {"orange"}}, {"boxes", {{0, 1, 2, 3, 4, 5}}}, {"total", 1}};
      };
      view->draw_labels = [this](std::vector<std::uint8_t>& buffer) {
        ++drawings_;
        buffer.assign(std::size_t{3} * kLabelsWidth * kLabelsHeight, 200);
        return ImageView{buffer.data(), kLabelsWidth, kLabelsHeight, 3 * kLabelsWidth, PixelFormat::kRgb24};
      };
    }
    views_.put(std::move(view));
  }

  /// Publishes an image that makes a large JPEG.
  void publish_noise(std::uint32_t frame_number) {
    constexpr int kSide = 1024;
    auto noise = std::make_shared<std::vector<std::uint8_t>>(std::size_t{kSide} * kSide);
    std::minstd_rand random(frame_number);
    for (std::uint8_t& pixel : *noise) pixel = static_cast<std::uint8_t>(random());
    auto view = std::make_shared<View>();
    view->image = {noise->data(), kSide, kSide, kSide, PixelFormat::kMono8};
    view->hold = std::move(noise);
    view->frame_number = frame_number;
    view->detections = {{"robots", Json::array()}, {"balls", Json::array()}};
    views_.put(std::move(view));
  }

  /// Frames published from now on have no runs.
  void make_no_runs() { makes_runs_ = false; }

  /// How often a label image was drawn.
  int drawings() const { return drawings_; }
  /// How often regions were listed.
  int region_lists() const { return region_lists_; }
  /// How often a server has waited for a view.
  int looks() const { return looks_; }
  Passwords& passwords() { return passwords_; }
  void let_match_run(bool runs) { game_is_running_ = runs; }

  /// Who made the last patch.
  std::string last_author() const {
    const std::lock_guard lock(mutex_);
    return last_author_;
  }

  // Gate
  May may(std::string_view cookies) override { return access_.may(cookies); }
  std::string lock_reason() override { return game_is_running_ ? "the game is running" : ""; }
  std::vector<std::string> names() const override { return {"field-pc", "test"}; }
  bool is_trusted(const std::string& address) override { return access_.is_trusted(address); }

  // ViewSource
  std::vector<std::uint32_t> camera_ids() const override { return {0}; }
  std::optional<View> wait_view(std::uint32_t camera_id, std::uint64_t newer_than,
                                std::chrono::milliseconds timeout) override {
    ++looks_;
    if (camera_id != 0) return std::nullopt;
    const auto latest = views_.wait_newer(newer_than, timeout);
    if (!latest) return std::nullopt;
    View view = *latest->value;
    view.version = latest->version;
    return view;
  }

  // Topic
  const char* topic_name() const override { return "status"; }
  Json topic_data() override { return {{"site", "test"}, {"go", false}}; }

  /// Routes like the services' own, for everything that routers and servers do with routes.
  std::vector<Route> routes() {
    return {
        {"GET", "/api/status", [this](const Request&) { return json_response(topic_data()); }},
        {"GET", "/api/broken", [](const Request&) -> Response { throw std::runtime_error("disk on fire"); }},
        {"GET", "/api/cameras",
         [](const Request&) {
           return json_response(Json{{{"id", 0}}});
         }},
        {"GET", "/api/schema",
         [](const Request&) {
           return json_response({{"type", "object"}});
         }},
        {"GET", "/api/settings",
         [](const Request&) {
           return json_response({{"revision", 7}});
         }},
        {"PATCH", "/api/settings", [this](const Request& request) { return patch(request); }},
        {"POST", "/api/settings/check",
         [](const Request& request) {
           return json_response({{"changes", parse_json(request.body)}});
         },
         Needs::kChange},
        {"GET", "/healthz", [](const Request&) { return text_response("ok\n"); }, Needs::kNothing,
         Speed::kAtOnce},
        {"GET", "/readyz", [](const Request&) { return text_response("camera 0 is lost\n", 503); },
         Needs::kNothing, Speed::kAtOnce},
        {"POST", "/api/session",
         [this](const Request& request) {
           const std::string password = parse_json(request.body).at("password").get<std::string>();
           Response response = json_response(Json::object());
           response.headers.emplace_back("Set-Cookie", access_.sign_in(password, request.address));
           return response;
         },
         Needs::kNothing},
        {"GET", "/api/file/([^/]+)", [this](const Request&) { return bytes_response(file_); }},
        {"GET", "/api/hangs",
         [this](const Request&) {
           const int hanging = ++now_hanging_;
           for (int most = most_hanging_;
                most < hanging && !most_hanging_.compare_exchange_weak(most, hanging);) {
           }
           let_go_.wait_for(test::kPatience);
           --now_hanging_;
           return text_response("");
         }},
        {"POST", "/api/file", [](const Request&) { return text_response(""); }, Needs::kByMethod,
         Speed::kMayWait, false, 8 * 1024 * 1024},
        {"PUT", "/api/names/(.+)",
         [](const Request& request) {
           return json_response({{"name", request.matches[1]}});
         }},
        {"GET", R"(/api/cameras/(\d+)/stream\.mjpg)",
         [](const Request& request) {
           if (request.matches[1] != "0") throw HttpError(404, "no camera " + request.matches[1]);
           Response response{200, kStreamType, {}};
           response.stream = StreamWish{0, {}};
           response.stream->preview.width = query_number(request, "width", PreviewWish{}.width, 1, 16384);
           return response;
         },
         Needs::kByMethod, Speed::kMayWait, true},
        websocket_routes().front(),
    };
  }
  WebParts parts() { return {*this, *this, {this}, routes()}; }

  /// The body that GET /api/file/... returns.
  void set_file(std::vector<std::uint8_t> bytes) { file_ = std::move(bytes); }
  /// Lets the handler of GET /api/hangs return.
  void let_go() { hanging_.set_value(); }
  /// Maximum number of these handlers that ran at once.
  int most_hanging() const { return most_hanging_; }

 private:
  Response patch(const Request& request) {
    const Json patch = parse_json(request.body);
    if (!request.if_match.empty() && request.if_match != "7")
      throw HttpError(409, "revision 7 is the newest", {{"revision", 7}});
    if (patch.empty()) throw SettingsError("/site: refused");
    const std::lock_guard lock(mutex_);
    last_author_ = request.address;
    return json_response({{"revision", 8}, {"settings", patch}});
  }

  std::vector<std::uint8_t> pixels_ = std::vector<std::uint8_t>(std::size_t{kWidth} * kHeight, 100);
  Latest<std::shared_ptr<const View>> views_;
  bool makes_runs_ = true;
  std::atomic<int> drawings_ = 0;
  std::atomic<int> region_lists_ = 0;
  std::atomic<int> looks_ = 0;
  mutable std::mutex mutex_;
  std::string last_author_;
  const test::TemporaryFolder folder_;
  Passwords passwords_{folder_.path() / Passwords::kFileName};
  Access access_{passwords_, "session", [] { return 0.0; }};
  std::atomic<bool> game_is_running_ = false;
  std::vector<std::uint8_t> file_{1, 2, 3};
  std::promise<void> hanging_;
  std::atomic<int> now_hanging_ = 0, most_hanging_ = 0;
  const std::shared_future<void> let_go_{hanging_.get_future()};
};

}  // namespace sslv
