// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"
#include "image/image.h"
#include "settings/store.h"

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace sslv {

/// A processed frame as viewers see it. It holds a slot of the camera's ring: let go soon.
struct View {
  std::uint64_t version = 0;         // see WebHost::wait_view
  std::shared_ptr<const void> hold;  // keeps the picture's bytes where they are
  ImageView image;
  std::uint32_t camera_id = 0;
  std::uint32_t frame_number = 0;
  double t_capture_s = 0;
  Json detections;  // {"robots": [...], "balls": [...]} as docs/openapi.json has them

  /// As docs/openapi.json's PreviewRegions; not set when the camera's stack makes no runs.
  std::function<Json()> regions;

  /// Draws the labelled picture into the buffer, where it then lies; not set when the camera's stack makes no
  /// runs.
  std::function<ImageView(std::vector<std::uint8_t>& buffer)> draw_labels;
};

/// A picture on loan: let go soon.
struct LentPicture {
  std::shared_ptr<const void> hold;
  ImageView image;
};

/// A rectangle of a camera's picture to look at.
struct PixelWish {
  int x = 0, y = 0, width = 1, height = 1;  // px
  bool region = false;                      // of the region that its middle lies in
  std::optional<int> still;                 // none: the newest picture
};

/// A file that somebody brings, or wants to look into.
struct TableFile {
  std::string_view bytes;
  std::string name;                  // for messages
  std::optional<std::size_t> table;  // which of several
  bool only_try = false;
};

/// Colour tables: docs/openapi.json's "colours". All may throw HttpError 404 for an unknown camera; what
/// writes, as `WebHost::patch_settings` does.
struct ColorHost {
  std::function<Json(std::uint32_t camera_id)> state;
  /// As a .lut file; as it is in today's light, or as it was accepted.
  std::function<std::vector<std::uint8_t>(std::uint32_t camera_id, bool in_todays_light)> lut_file;
  std::function<std::string(std::uint32_t camera_id)> json_file;
  std::function<Json(std::uint32_t camera_id, const Json& edits, const std::string& who)> edit;
  std::function<Json(std::uint32_t camera_id, const std::string&who)> undo, redo, reset;  // or HttpError 409
  std::function<Json(std::uint32_t camera_id, int from_camera_id, const std::string& who)> copy;
  std::function<Json(std::uint32_t camera_id, const TableFile& file, const std::string& who)> import_file;
  std::function<Json(std::uint32_t camera_id, const std::string&who)> revert_light, keep_light;  // likewise

  std::function<Json(std::uint32_t camera_id)> learning;
  std::function<Json(std::uint32_t camera_id, const Json& request, const std::string& who)> start_learning;
  std::function<Json(std::uint32_t camera_id)> cancel_learning, reject_learning;  // or HttpError 409
  std::function<Json(std::uint32_t camera_id, const std::string& who)> accept_learning;
  std::function<LentPicture(std::uint32_t camera_id, int picture)> learning_picture;
  /// As docs/openapi.json's LabelPicture.
  std::function<std::vector<std::uint8_t>(std::uint32_t camera_id, int picture, bool after)> learning_labels;

  std::function<Json(std::uint32_t camera_id, const PixelWish& wish)> pixels;
  std::function<Json(std::uint32_t camera_id)> take_still;
  std::function<LentPicture(std::uint32_t camera_id, int still)> still_picture;
  std::function<std::vector<std::uint8_t>(std::uint32_t camera_id, int still)> still_labels;
};

/// Settings are locked while a match runs, as the game controller says, unless an admin opened them for this
/// match.
struct MatchLock {
  bool game_is_running = false, opened = false;
  bool is_locked() const { return game_is_running && !opened; }
};
inline constexpr const char* kMatchRuns =
    "the game is running, as the game controller says, and nothing is changed meanwhile: wait for HALT, or "
    "unlock the settings for this match";

class Access;

/// All that the web server needs of the daemon. Every member must be set, and is called from several threads
/// at once. JSON values are those of docs/openapi.json.
struct WebHost {
  Access* access = nullptr;                               // who may do what
  std::function<std::vector<std::string>()> panel_names;  // besides this computer's own
  std::function<MatchLock()> match_lock;
  /// Until the match ends. `who`: the client's address.
  std::function<MatchLock(bool opened, const std::string& who)> open_match_lock;

  std::function<Json()> status;
  std::function<Json(int seconds)> timeline;
  std::function<Json()> diagnostics;
  std::function<std::string()> metrics;  // in the text format of Prometheus
  /// Why the service must be started anew, and what is missing for all packets to leave, a line for each;
  /// both empty when all is well.
  std::function<std::string()> hanging, missing;
  std::function<Json()> settings;  // with its revision
  std::function<Json()> schema;
  std::function<Json()> field_presets;
  std::function<Json()> network_interfaces;

  /// Applies a JSON Patch and returns once it is on disk. `if_revision`: the revision the patch was made for;
  /// `who`: the client's address, for the history. Throws SettingsError when the patch is refused,
  /// StaleRevision when the revision is not the newest.
  std::function<Json(const Json& patch, std::optional<std::uint64_t> if_revision, const std::string& who)>
      patch_settings;

  /// What a JSON Patch would change, as the history has it; changes nothing. Throws SettingsError as
  /// `patch_settings` would.
  std::function<Json(const Json& patch)> check_settings;

  /// What was changed, newest first, and one of these taken back. Throws as `patch_settings` does:
  /// StaleRevision when what it changed was changed again.
  std::function<Json()> settings_history;
  std::function<Json(std::uint64_t revision, const std::string& who)> undo_settings;

  /// Settings that are kept under a name; see docs/openapi.json. All but the first and `save_profile` throw
  /// HttpError 404 for an unknown one.
  std::function<Json()> profiles;
  std::function<Json(const std::string& name)> profile;
  /// The settings in force, or those given. Throws SettingsError.
  std::function<Json(const std::string& name, const std::optional<Json>& settings, const std::string& who)>
      save_profile;
  /// The changes at or below one of `paths`, or all; throws as `patch_settings` does.
  std::function<Json(const std::string& name, const std::optional<std::vector<std::string>>& paths,
                     std::optional<std::uint64_t> if_revision, const std::string& who)>
      apply_profile;
  std::function<Json(const std::string& name)> delete_profile;

  /// Must not block: it is called from the thread that serves all sockets.
  std::function<std::vector<std::uint32_t>()> camera_ids;

  /// The newest view of a camera once its version is newer than the given one (0: any); nothing after the
  /// timeout, without a picture yet, or for a camera that is not there. Versions of a camera id start at 1
  /// and only grow, also across a reconnection.
  std::function<std::optional<View>(std::uint32_t camera_id, std::uint64_t newer_than_version,
                                    std::chrono::milliseconds timeout)>
      wait_view;

  /// What can be set at a camera itself, as it is now. May take as long as the camera needs. Throws
  /// HttpError: 404 no such camera, 409 not open, or it has none.
  std::function<Json(std::uint32_t camera_id)> controls;
  /// Sets one without saving it, or does an action; answers with the control. Throws SettingsError when the
  /// camera refuses it, and as `controls` does.
  std::function<Json(std::uint32_t camera_id, const std::string& name, const Json& value,
                     const std::string& who)>
      set_control;
  /// Cameras found now, of all backends. Takes a second or so.
  std::function<Json()> sources;

  /// Calibration of a camera; each answers with its state. All but the first may throw HttpError: 404 no such
  /// camera, 409 not in this state, 423 not while the game runs, unless `force`; and what patch_settings
  /// throws.
  /// What lies too far beyond the field for the camera to look at.
  std::function<Json(std::uint32_t camera_id)> field_view;
  std::function<Json(std::uint32_t camera_id)> calibration;
  std::function<Json(std::uint32_t camera_id, const Json& request, bool force, const std::string& who)>
      start_calibration;
  std::function<Json(std::uint32_t camera_id)> cancel_calibration;
  std::function<Json(std::uint32_t camera_id, bool force, const std::string& who)> accept_calibration;
  std::function<Json(std::uint32_t camera_id)> reject_calibration;
  std::function<Json(std::uint32_t camera_id, bool force, const std::string& who)> revert_calibration;

  /// Calibration of several cameras together: likewise.
  std::function<Json()> joint_calibration;
  std::function<Json(const Json& request, bool force, const std::string& who)> start_joint_calibration;
  std::function<Json()> cancel_joint_calibration;
  std::function<Json(bool force, const std::string& who)> accept_joint_calibration;
  std::function<Json()> reject_joint_calibration;

  ColorHost colors;
};

}  // namespace sslv
