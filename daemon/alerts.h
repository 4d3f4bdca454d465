// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "capture/camera_thread.h"
#include "colors/surfaces.h"
#include "config.h"
#include "health/computer.h"
#include "health/exposure.h"
#include "health/timeline.h"
#include "net/multicast.h"
#include "net/other_visions.h"
#include "net/packets.h"
#include "net/referee_listener.h"

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

namespace sslv {

/// What is known of a camera, read once, so that alerts, checks and figures agree.
struct CameraFacts {
  int id = 0;
  std::size_t place = 0;  // in the settings' list
  std::string backend;
  std::optional<double> wanted_fps;  // as its settings ask for
  CameraHealth health;
  std::optional<CameraCalibration> calibration;
  bool field_changed_since_calibrated = false;
  double latency_p99_ms = 0;
  Timeline::Sum last_minute, last_seconds;  // kLastSeconds
  std::optional<Exposure> exposure;         // of the newest picture
  /// Of its colour table to carpet and floor; empty: not known.
  struct Margin {
    double share;      // of the light, at most kMost
    std::string text;  // "carpet becomes green at +9 %"; empty: nothing does
    static constexpr double kMost = LabelMargin::kMostFactor - 1;
  };
  std::optional<Margin> least_margin{};
  std::string flood{};  // in the last minute: "green floods the picture between ..."; empty: none

  static constexpr std::size_t kLastSeconds = 10;
};

/// What alerts and checks are made of, at one moment.
struct HealthInput {
  const Config& config;
  MulticastStatus network;
  std::shared_ptr<const Geometry> geometry;  // what is sent
  std::vector<OtherVision> other_visions;
  bool another_host_sends = false;  // one of them is on another computer
  std::string listening_error;      // why the vision group cannot be heard
  RefereeStatus referee;
  std::string settings_problem;          // at start
  std::string save_problem;              // why the last file was not saved
  std::string state_problem;             // why none can be saved now
  std::string reload_problem;            // why the settings file was not taken over
  std::vector<std::string> lost_tables;  // why saved colour tables could not be used at start
  ComputerFigures computer;
  std::optional<ClockFigures> clock;
  std::vector<CameraFacts> cameras;
};

/// What is to be right before a match, in the order in which it is shown.
enum class CheckId {
  kCameras,
  kPictures,
  kLatency,
  kCalibration,
  kColors,
  kNetwork,
  kOtherVisions,
  kReferee,
  kTeams,
  kClock,
  kComputer,
};

enum class Severity { kBad, kWarn, kInfo };

struct Alert {
  std::string id;  // its kind: "camera_lost"
  CheckId check;   // that it belongs to
  Severity severity;
  std::string title, fix;
  std::string page{};           // of the panel, where it is mended; empty: not there
  std::optional<int> camera{};  // that it is about
  std::string about{};          // what else tells it from others of its kind: an address, say
  double since_s = 0;           // Unix time; see AlertTimes
};

/// The sizes of the field that another vision tells otherwise.
std::vector<SizeConflict> field_conflicts(const HealthInput& input, const OtherVision& other);

/// What is wrong, worst first, each with what to do about it.
std::vector<Alert> find_alerts(const HealthInput& input);

/// As docs/openapi.json has it.
Json to_json(const Alert& alert);

/// Remembers since when alerts have been there. May be used from any thread.
class AlertTimes {
 public:
  /// Fills in `since_s`: of one that was not there the last time, now. How long one has been there is known
  /// by a steady clock, whatever becomes of the other.
  void stamp(std::vector<Alert>& alerts, double now_s, double steady_s);

 private:
  using Key = std::tuple<std::string, std::optional<int>, std::string>;
  std::mutex mutex_;
  struct Since {
    double unix_s, steady_s;
  };
  std::map<Key, Since> since_;
};

}  // namespace sslv
