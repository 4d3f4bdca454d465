// SPDX-License-Identifier: Apache-2.0
#pragma once

// Alerts and checks of cameras.

#include "base/json.h"
#include "capture/camera_thread.h"
#include "health/exposure.h"
#include "health/timeline.h"
#include "kit/load_stages.h"
#include "pipeline/pipeline.h"
#include "services/health_report.h"
#include "services/stage_report.h"
#include "services/stage_watch.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace sslv {

/// What a camera's images are of: only a real camera sees the field.
enum class ImageOrigin { kCamera, kRecording, kSimulation };
/// Of a camera's complete "source", and of a tile's big camera.
ImageOrigin origin_of(const Json& source);
/// As docs/openapi.json has it.
const char* name_of(ImageOrigin origin);

/// What is known of a camera, read once, so that alerts, checks and figures agree.
struct CameraFacts {
  int id = 0;
  std::string backend;
  std::optional<double> wanted_fps;  // as its settings ask for
  CameraHealth health;
  double latency_p99_ms = 0;                // of the last images
  std::uint64_t latency_images = 0;         // since its start: of fewer than 100, one late image is the p99
  Timeline::Sum last_minute, last_seconds;  // kLastSeconds
  Timeline::Sum newest_seconds;             // kNewestSeconds
  std::optional<Exposure> exposure;         // of the newest frame
  std::size_t controls_unsaved = 0;         // that are set and not saved
  bool sends = true;                        // its stack ends in the stage that sends
  ImageOrigin origin = ImageOrigin::kCamera;
  RunningStack running{};              // of its stack
  std::vector<StageFigures> stages{};  // of its stack
  std::optional<Hang> hang{};          // of its thread
  std::string flood{};  // in the last minute: "green floods the image between ..."; empty: none

  static constexpr std::size_t kLastSeconds = 10, kNewestSeconds = 3;
};

/// Adds their alerts and the checks `cameras`, `pictures` and `latency`.
void report_cameras(std::span<const CameraFacts> cameras, HealthReport& report);

/// Adds an alert for each stage library that was left out.
void report_left_out(std::span<const LeftOutLibrary> libraries, HealthReport& report);

/// "2/2 cameras 60.0 fps p99 0.9 ms".
std::string camera_summary(std::span<const CameraFacts> cameras);

struct CameraProgress {
  int id;
  CameraHealth health;
  std::optional<Hang> stage{};  // that its thread is in
};

/// A thread that neither goes on nor is known to open its camera. `now_ns`: of the steady clock.
std::optional<Hang> find_hang(const CameraProgress& camera, std::int64_t now_ns);

/// Why the watchdog is not fed: the cameras whose threads hang, and the stages that they are in. Empty while
/// all is well.
std::string find_hanging(const std::vector<CameraProgress>& cameras, std::int64_t now_ns);

/// What is missing for all cameras to run, a line for each; empty when nothing is.
std::string find_missing(const std::vector<CameraProgress>& cameras);

}  // namespace sslv
