// SPDX-License-Identifier: Apache-2.0
#pragma once

// The settings tree. Each part declares its own fields; this file combines them.

#include "base/json.h"
#include "base/params.h"
#include "capture/camera_thread.h"
#include "colors/light_follower.h"
#include "config/stages.h"
#include "geometry/ball_models.h"
#include "geometry/camera_model.h"
#include "geometry/field.h"
#include "geometry/limits.h"
#include "net/multicast.h"
#include "net/referee_listener.h"
#include "net/tracker_settings.h"
#include "pipeline/frame.h"
#include "recording/recording_settings.h"
#include "settings/migrations.h"
#include "tracking/ball_motion.h"
#include "vision/lut.h"

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace sslv {

struct TeamSettings {
  std::string name;
  double robot_height = 140;
  std::vector<int> ids;
  static constexpr auto fields() {
    return std::tuple{
        text("name", &TeamSettings::name, "as the game controller spells it"),
        numbers(
            "ids", &TeamSettings::ids, 0, 255,
            "ids of the robots that play, if known: a robot with a hidden dot is then reported when only one "
            "of them fits. Others are still reported when all their dots are seen"),
        number("robot_height", &TeamSettings::robot_height, 20.0, 1000.0, "mm",
               "height of the pattern above the floor; used where height_from_referee finds none"),
    };
  }
};

struct TeamsSettings {
  bool height_from_referee = true;
  TeamSettings yellow, blue;
  static constexpr auto fields() {
    return std::tuple{flag("height_from_referee", &TeamsSettings::height_from_referee,
                           "use the height of the team that the game controller names, if it is known; "
                           "otherwise robot_height"),
                      group("yellow", &TeamsSettings::yellow, "the yellow team"),
                      group("blue", &TeamsSettings::blue, "the blue team")};
  }
};

/// The field, and the processing of everything its cameras detect.
struct FieldSettings : FieldSize {
  std::vector<std::string> stack = default_field_stack();
  Json stages = Json::object();
  // Set by read_config(): the parameters of `stages` in the order of the field's stage table, and the stages
  // of `stack` that run.
  std::vector<StageParams> stage_params{};
  RunningStack running{};
  std::vector<std::string> other_computers{};
  static constexpr auto fields() {
    using F = FieldSettings;
    return std::tuple_cat(
        FieldSize::fields(),
        std::tuple{
            names("stack", &F::stack, "stages that process the cameras' results, in order; none: no tracks",
                  64),
            object("stages", &F::stages, "parameters of the field's stages"),
            names("other_computers", &F::other_computers,
                  "IPv4 addresses of this field's other computers with cameras: their detections are used "
                  "for tracks. Cameras of other senders to the vision group are only shown",
                  limits::kMaxComputers),
        });
  }
};

struct NetworkSettings {
  MulticastSettings vision;
  TrackerSettings tracker;
  RefereeSettings referee;
  static constexpr auto fields() {
    return std::tuple{group("vision", &NetworkSettings::vision, "where detections and geometry are sent"),
                      group("tracker", &NetworkSettings::tracker, "where tracks are sent"),
                      group("referee", &NetworkSettings::referee, "where the game controller is received")};
  }
};

struct PanelSettings {
  std::string address;
  int port = 8090;
  std::vector<std::string> names;
  bool match_lock = true;
  static constexpr auto fields() {
    return std::tuple{
        text(
            "address", &PanelSettings::address,
            "address the panel listens on; 0.0.0.0: all; empty: all if an admin's password is set, otherwise "
            "only this computer (127.0.0.1)"),
        number("port", &PanelSettings::port, 0, 65535, "", "port of the panel; 0: any free one"),
        sslv::names("names", &PanelSettings::names,
                    "names by which browsers reach the panel, besides this computer's own name and addresses",
                    32),
        flag("match_lock", &PanelSettings::match_lock,
             "lock the settings while the game controller says that a match is running; an admin can unlock "
             "them"),
    };
  }
};

struct CameraSettings {
  int id = 0;
  std::string name;
  Json source = Json{{"backend", "simulator"}};
  std::optional<CameraCalibration> calibration;
  ColorSettings colors;
  FollowLightParams follow_light;
  MaskSettings mask;
  std::vector<std::string> stack = default_stack();
  Json stages = Json::object();
  // Set by read_config(): the parameters of `stages` in the order of the stage table, and the stages of
  // `stack` that run.
  std::vector<StageParams> stage_params{};
  RunningStack running{};
  ThreadSettings thread;
  static constexpr auto fields() {
    using C = CameraSettings;
    return std::tuple{
        number("id", &C::id, 0, 255, "", "camera_id in the packets"),
        text("name", &C::name, "a name for people, such as the part of the field that the camera sees"),
        object("source", &C::source, "where images come from: \"backend\" and that backend's options"),
        group("calibration", &C::calibration,
              "named as in SSL_GeometryCameraCalibration; null: not calibrated yet"),
        group("colors", &C::colors, "the colour lookup table"),
        group("follow_light", &C::follow_light, "whether the table follows the light, and how far"),
        group("mask", &C::mask, "which part of the image is searched"),
        names("stack", &C::stack, "stages that process an image, in order", 64),
        object("stages", &C::stages, "parameters of the stages"),
        group("thread", &C::thread, "priority and processor of the camera's thread"),
    };
  }
};

struct Config {
  std::string site = "Field";
  FieldSettings field;
  std::optional<BallModels> ball_models = BallModels{};
  TeamsSettings teams;
  std::string patterns_file;
  std::vector<OwnLabel> own_labels;
  NetworkSettings network;
  RecordingSettings recording;
  PanelSettings panel;
  std::vector<CameraSettings> cameras;
  static constexpr auto fields() {
    return std::tuple{
        text("site", &Config::site, "name of the field, shown in the panel"),
        group("field", &Config::field,
              "the playing field: sizes and lines, and the processing of all its cameras' results"),
        group("ball_models", &Config::ball_models, "how the ball slows down; null: not published"),
        group("teams", &Config::teams, "names and heights of the teams"),
        file("patterns_file", &Config::patterns_file, "a pattern table; empty: the league's 16 patterns"),
        list("own_labels", &Config::own_labels,
             "labels of colour tables besides the built-in ones, for patterns of your own",
             label::kMaxCount - label::kCount),
        group("network", &Config::network, "where packets are sent to and received from"),
        group("recording", &Config::recording, "which matches are recorded, and the disk space for them"),
        group("panel", &Config::panel, "where the web panel listens"),
        list("cameras", &Config::cameras, "the cameras of this service", limits::kMaxCameras),
    };
  }
};

/// Reads each part of a settings tree once; the tree may be incomplete. Throws SettingsError for anything
/// that is not allowed: unknown keys, values out of range, two cameras with one id, an impossible stack, a
/// calibration that no camera can have.
Config read_config(const Json& settings);

/// Migrations of settings from earlier versions. To change the meaning of settings, add one more function at
/// the end, and a test.
const Migrations& settings_migrations();

/// Returns the whole tree with every default filled in. Throws like read_config().
Json complete_settings(const Json& settings);

/// JSON Schema (2020-12) of the tree, with the stages' and backends' own parameters.
Json settings_schema();

/// Returns the ball model of the settings, in the tracker's units (mm, s); the league's usual values if the
/// settings have none.
BallModel ball_model_of(const Config& config);

/// Returns the colour table that the service saved under a name; null: use the other colour settings. Throws
/// SettingsError, beginning with `path`.
using LoadTable = std::function<std::shared_ptr<const Lut>(const std::string& name, const std::string& path,
                                                           const LabelSet& labels)>;

/// Returns the context for frames of the camera at index `i`. Reads the pattern table if `patterns` is null,
/// and the colour table if `lut` is null. Throws SettingsError if their files are not usable, and for a
/// saved colour table without `load_table`.
CameraContext make_context(const Config& config, std::size_t i, std::shared_ptr<const Lut> lut = nullptr,
                           const LoadTable& load_table = {},
                           std::shared_ptr<const PatternTable> patterns = nullptr);

}  // namespace sslv
