// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/error.h"
#include "support/latest.h"
#include "support/temporary_folder.h"
#include "services/access/access.h"
#include "web/host.h"
#include "web/http.h"

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <random>
#include <string>
#include <vector>

namespace sslv {

/// A daemon with camera 0, whose frames a test publishes. Every server made of it must be gone before it is.
class FakeHost {
 public:
  static constexpr int kWidth = 64, kHeight = 48;
  static constexpr int kLabelsWidth = 32, kLabelsHeight = 24;

  /// `robots` stands in the place of the list of robots. `hold` is let go together with the frame.
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

  /// A picture that makes a large JPEG.
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

  /// From the next frame on.
  void make_no_runs() { makes_runs_ = false; }

  /// How often a labelled picture was drawn.
  int drawings() const { return drawings_; }
  /// How often regions were listed.
  int region_lists() const { return region_lists_; }
  /// How often a view was waited for.
  int looks() const { return looks_; }
  Passwords& passwords() { return passwords_; }
  void let_match_run(bool runs) { game_is_running_ = runs; }

  /// Who made the last patch.
  std::string last_author() const {
    const std::lock_guard lock(mutex_);
    return last_author_;
  }

  WebHost host() {
    WebHost host;
    host.access = &access_;
    host.panel_names = [] { return std::vector<std::string>{"field-pc", "test"}; };
    host.match_lock = [this] { return MatchLock{game_is_running_, lock_opened_}; };
    host.open_match_lock = [this](bool opened, const std::string&) {
      lock_opened_ = opened;
      return MatchLock{game_is_running_, lock_opened_};
    };
    host.status = [] {
      return Json{{"site", "test"},
                  {"alerts", {{{"id", "camera_lost"}}}},
                  {"go", false},
                  {"checks", {{{"id", "cameras"}}}},
                  {"cameras", {{{"id", 0}}}}};
    };
    host.timeline = [](int seconds) { return Json{{"seconds", seconds}}; };
    host.diagnostics = [] { return Json{{"clock", nullptr}}; };
    host.metrics = [] { return std::string("up 1\n"); };
    host.hanging = [] { return std::string(); };
    host.missing = [] { return std::string("camera 0 is lost\n"); };
    host.settings = [] { return Json{{"revision", 7}, {"settings", {{"site", "test"}}}}; };
    host.schema = [] { return Json{{"type", "object"}}; };
    host.field_presets = [] { return Json{{{"name", "division-b"}}}; };
    host.network_interfaces = [] { return Json{{{"name", "lo"}}}; };
    host.patch_settings = [this](const Json& patch, std::optional<std::uint64_t> if_revision,
                                 const std::string& who) {
      if (if_revision && *if_revision != 7) throw StaleRevision("revision 7 is the newest", 7, Json::array());
      if (patch.empty()) throw SettingsError("/site: refused");
      const std::lock_guard lock(mutex_);
      last_author_ = who;
      return Json{{"revision", 8}, {"settings", patch}, {"saved", true}};
    };
    host.check_settings = [](const Json& patch) {
      if (patch.empty()) throw SettingsError("/site: refused");
      return patch;
    };
    host.profiles = [] { return Json{{{"name", "night"}}}; };
    host.profile = [](const std::string& name) {
      if (name != "night") throw HttpError(404, "no profile " + name);
      return Json{{"name", name}};
    };
    host.save_profile = [](const std::string& name, const std::optional<Json>& settings,
                           const std::string& who) {
      return Json{{"name", name}, {"settings", settings.value_or("in force")}, {"who", who}};
    };
    host.apply_profile = [](const std::string& name, const std::optional<std::vector<std::string>>& paths,
                            std::optional<std::uint64_t> if_revision, const std::string&) {
      if (if_revision && *if_revision != 7) throw StaleRevision("revision 7 is the newest", 7, Json::array());
      return Json{{"name", name}, {"paths", paths.value_or(std::vector<std::string>{"all"})}};
    };
    host.delete_profile = [](const std::string&) { return Json::array(); };
    host.settings_history = [] { return Json{{{"revision", 7}}}; };
    host.undo_settings = [](std::uint64_t revision, const std::string&) {
      return Json{{"revision", revision + 1}};
    };
    host.controls = [](std::uint32_t id) { return Json{{{"name", "Gain"}, {"camera", id}}}; };
    host.set_control = [](std::uint32_t id, const std::string& name, const Json& value,
                          const std::string& who) {
      if (name != "Gain") throw SettingsError(name + ": the camera has no such control");
      return Json{{"camera", id}, {"name", name}, {"value", value}, {"who", who}};
    };
    host.sources = [] { return Json{{{"backend", "aravis"}}}; };
    host.camera_ids = [] { return std::vector<std::uint32_t>{0}; };
    host.wait_view = [this](std::uint32_t camera_id, std::uint64_t newer_than,
                            std::chrono::milliseconds timeout) -> std::optional<View> {
      ++looks_;
      if (camera_id != 0) return std::nullopt;
      const auto latest = views_.wait_newer(newer_than, timeout);
      if (!latest) return std::nullopt;
      View view = *latest->value;
      view.version = latest->version;
      return view;
    };
    host.calibration = [](std::uint32_t id) { return Json{{"camera", id}, {"state", "idle"}}; };
    host.start_calibration = [](std::uint32_t id, const Json& request, bool force, const std::string& who) {
      if (request.contains("busy")) throw HttpError(409, "it is being calibrated already");
      return Json{{"camera", id}, {"request", request}, {"force", force}, {"who", who}};
    };
    host.cancel_calibration = [](std::uint32_t id) { return Json{{"cancelled", id}}; };
    host.accept_calibration = [](std::uint32_t id, bool force, const std::string& who) {
      return Json{{"accepted", id}, {"force", force}, {"who", who}};
    };
    host.reject_calibration = [](std::uint32_t id) { return Json{{"rejected", id}}; };
    host.revert_calibration = [](std::uint32_t id, bool force, const std::string& who) {
      if (!force) throw HttpError(423, "the game is running");
      return Json{{"reverted", id}, {"who", who}};
    };
    host.joint_calibration = [] { return Json{{"state", "idle"}}; };
    host.start_joint_calibration = [](const Json& request, bool force, const std::string& who) {
      return Json{{"request", request}, {"force", force}, {"who", who}};
    };
    host.cancel_joint_calibration = [] { return Json{{"cancelled", "all"}}; };
    host.accept_joint_calibration = [](bool force, const std::string& who) {
      return Json{{"accepted", "all"}, {"force", force}, {"who", who}};
    };
    host.reject_joint_calibration = [] { return Json{{"rejected", "all"}}; };
    host.colors.lut_file = [](std::uint32_t, bool) { return std::vector<std::uint8_t>{1, 2, 3}; };
    return host;
  }

 private:
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
  std::atomic<bool> game_is_running_ = false, lock_opened_ = false;
};

}  // namespace sslv
