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

/// Origin of a camera's images: only a real camera sees the field.
enum class ImageOrigin { kCamera, kRecording, kSimulation };
/// Origin of a complete "source"; for a tile, the origin of the camera that the tile is cut from.
ImageOrigin origin_of(const Json& source);
/// Name in docs/openapi.json.
const char* name_of(ImageOrigin origin);

/// Facts about a camera, read once so that alerts, checks and figures agree.
struct CameraFacts {
  int id = 0;
  std::string backend;
  std::optional<double> wanted_fps;  // frame rate in its settings
  CameraHealth health;
  double latency_p99_ms = 0;                // over the last images
  std::uint64_t latency_images = 0;         // since its start; below 100, the p99 is the slowest image
  Timeline::Sum last_minute, last_seconds;  // last_seconds: over kLastSeconds
  Timeline::Sum newest_seconds;             // over kNewestSeconds
  std::optional<Exposure> exposure;         // exposure of the newest frame
  std::size_t controls_unsaved = 0;         // controls set and not saved
  bool sends = true;                        // its stack has the stage that sends packets
  ImageOrigin origin = ImageOrigin::kCamera;
  RunningStack running{};              // stages of its stack: running, missing, idle
  std::vector<StageFigures> stages{};  // figures of its stack's stages
  std::optional<Hang> hang{};          // hang of its thread; none: it does not hang
  std::string flood{};  // "green floods the image between ...", in the last minute; empty: none

  static constexpr std::size_t kLastSeconds = 10, kNewestSeconds = 3;
};

/// Adds the cameras' alerts and the checks `cameras`, `pictures` and `latency`.
void report_cameras(std::span<const CameraFacts> cameras, HealthReport& report);

/// Adds an alert for each stage library that was left out.
void report_left_out(std::span<const LeftOutLibrary> libraries, HealthReport& report);

/// "2/2 cameras 60.0 fps p99 0.9 ms".
std::string camera_summary(std::span<const CameraFacts> cameras);

struct CameraProgress {
  int id;
  CameraHealth health;
  std::optional<Hang> stage{};  // stage that its thread is executing
};

/// Returns where a camera's thread hangs; nothing if it does not hang. A thread that is opening its camera
/// does not hang. `now_ns`: steady clock.
std::optional<Hang> find_hang(const CameraProgress& camera, std::int64_t now_ns);

/// The reason for not feeding the watchdog: the cameras whose threads hang, with the stages. Empty if no
/// thread hangs.
std::string find_hanging(const std::vector<CameraProgress>& cameras, std::int64_t now_ns);

/// One line for each camera that is not running, with the reason; empty if all are running.
std::string find_missing(const std::vector<CameraProgress>& cameras);

}  // namespace sslv
