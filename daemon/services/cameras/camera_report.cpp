// SPDX-License-Identifier: Apache-2.0
#include "services/cameras/camera_report.h"

#include "base/clock.h"
#include "base/plain_text.h"
#include "config/backends.h"
#include "config/missing_stages.h"

#include <algorithm>
#include <cctype>
#include <utility>

#include <fmt/format.h>

namespace sslv {
namespace {

// Share of the last minute's frames. Trackers bridge a few lost frames; one lost frame in a thousand means
// that a cable or a computer is at its limit.
constexpr double kLostShare = 0.001;
/// Share of the frames in the last kLastSeconds. If one frame in twenty is lost, trackers lose fast balls.
constexpr double kLostBadShare = 0.05;
constexpr std::uint64_t kFewPictures = 3;
// The painted lines cover under 1 % of a field's image, and they may clip: white has no colour to lose. A
// share above twice that comes from glare or too much light, and clipped colours are confused with others.
constexpr double kClippedShare = 0.02;
// Mean luma, 0 to 255. Below this, the camera's noise is as large as the differences between dark colours.
constexpr double kDarkLuma = 25;
/// Shares of the requested rate, over kLastSeconds and over kNewestSeconds; a short break weighs more in the
/// latter.
constexpr double kSlowShare = 0.9, kNewestSlowShare = 0.85;
/// In this time a ball at 6 m/s moves 30 mm.
constexpr double kLateAfter_ms = 5;
/// Longer than a frame at 60 Hz: teams then get data of the previous frame.
constexpr double kTooLateAfter_ms = 17;
/// Share of the images in the last kLastSeconds.
constexpr double kStagesLoseShare = 0.01;

std::string camera_page(const CameraFacts& camera) {
  return fmt::format("#/camera/{}", camera.id);
}

// Counts all images that the camera sends, including images that are then dropped or damaged.
bool is_slow(const CameraFacts& camera, const Timeline::Sum& sum, std::size_t seconds, double share) {
  return camera.wanted_fps && sum.seconds >= seconds &&
         static_cast<double>(sum.all() + kFewPictures) < share * *camera.wanted_fps * sum.seconds;
}

bool is_slow_now(const CameraFacts& camera) {
  return is_slow(camera, camera.newest_seconds, CameraFacts::kNewestSeconds, kNewestSlowShare);
}

StackFacts stack_facts(const CameraFacts& camera) {
  const Timeline::Sum& newest = camera.newest_seconds;
  StackFacts out{.camera = camera.id, .check = "pictures", .stages = camera.stages};
  if (newest.seconds == 0) return out;
  out.come_per_s = static_cast<double>(newest.all()) / newest.seconds;
  out.processed_per_s = static_cast<double>(newest.frames) / newest.seconds;
  const auto dropped = camera.last_seconds.dropped;
  out.loses = dropped > kFewPictures && static_cast<double>(dropped) >
                                            kStagesLoseShare * static_cast<double>(camera.last_seconds.all());
  // Some drivers do not count images that were not fetched in time.
  out.is_slow = is_slow_now(camera);
  if (out.is_slow) out.come_per_s = *camera.wanted_fps;
  return out;
}

void add_source_alerts(std::vector<Alert>& alerts, const CameraFacts& camera) {
  const CameraHealth& health = camera.health;
  for (const std::string& warning : health.warnings) {
    alerts.push_back({.id = "control_refused",
                      .check = "cameras",
                      .severity = Severity::kWarn,
                      .title = fmt::format("Camera {} refused a control: {}", camera.id, warning),
                      .fix = "Set it to a value that the camera accepts, or remove it from source/controls.",
                      .page = camera_page(camera),
                      .camera = camera.id,
                      .about = warning});
  }
  if (camera.controls_unsaved > 0) {
    alerts.push_back(
        {.id = "controls_unsaved",
         .check = "cameras",
         .severity = Severity::kInfo,
         .title = fmt::format("Camera {}: {} set and not saved", camera.id,
                              camera.controls_unsaved == 1
                                  ? "1 control is"
                                  : fmt::format("{} controls are", camera.controls_unsaved)),
         .fix = "Save or revert on the camera's page; when the camera loses its power, they are lost.",
         .page = camera_page(camera),
         .camera = camera.id});
  }
  if (health.state == CameraState::kLost) {
    alerts.push_back({.id = "camera_lost",
                      .check = "cameras",
                      .severity = Severity::kBad,
                      .title = fmt::format("Camera {} is lost: {}", camera.id, health.error),
                      .fix = camera.backend == "files"
                                 ? "Check source/path in its settings; the service tries again automatically."
                                 : "Check its cable and power; the service tries again automatically.",
                      .page = camera_page(camera),
                      .camera = camera.id});
  }
  if (const std::string missing = missing_text(camera.running); !missing.empty()) {
    alerts.push_back({.id = "stage_missing",
                      .check = "cameras",
                      .severity = camera.running.idle.empty() ? Severity::kWarn : Severity::kBad,
                      .title = fmt::format("Camera {} runs {}", camera.id, missing),
                      .fix = missing_fix(camera.running),
                      .page = "#/settings/cameras",
                      .camera = camera.id});
  }
  if (!camera.sends) {
    alerts.push_back({.id = "not_published",
                      .check = "network",
                      .severity = Severity::kBad,
                      .title = fmt::format(
                          "Camera {} sends nothing to the teams: its stack has no stage publish", camera.id),
                      .fix = "Add the stage publish at the end of its stack.",
                      .page = "#/settings/cameras",
                      .camera = camera.id});
  }
  if (camera.hang) {
    const auto hung_s = (steady_ns() - camera.hang->since_ns) / 1'000'000'000;
    alerts.push_back(
        {.id = "camera_hangs",
         .check = "cameras",
         .severity = Severity::kBad,
         .title =
             fmt::format("Camera {} has hung for {} s{}", camera.id, hung_s,
                         camera.hang->stage.empty() ? ", outside of its stages" : place_text(*camera.hang)),
         .fix = camera.hang->stage.empty()
                    ? "Most likely its driver does not answer. The service manager restarts the service."
                    : "The stage is faulty. The service manager restarts the service; if it hangs again, "
                      "remove the stage from the stack.",
         .page = "#/settings/cameras",
         .camera = camera.id});
  }
  const bool is_slow_lately = is_slow_now(camera);
  const Timeline::Sum& sum = is_slow_lately ? camera.newest_seconds : camera.last_seconds;
  const auto slow_stage = find_slow_stage(stack_facts(camera));
  const bool is_by_stages = slow_stage && slow_stage->is_always;
  if (!is_by_stages && (is_slow_lately || is_slow(camera, sum, CameraFacts::kLastSeconds, kSlowShare))) {
    alerts.push_back(
        {.id = "camera_slow",
         .check = "cameras",
         .severity = Severity::kWarn,
         .title = fmt::format("Camera {} sends {:.1f} images per second instead of {:g}", camera.id,
                              static_cast<double>(sum.all()) / sum.seconds, *camera.wanted_fps),
         .fix = "Shorten its exposure, make the image smaller, or ask for a lower frame rate.",
         .page = camera_page(camera),
         .camera = camera.id});
  }
}

void add_picture_alerts(std::vector<Alert>& alerts, const CameraFacts& camera) {
  const auto say = [&](const char* id, Severity severity, std::string title, std::string fix,
                       std::string page) {
    alerts.push_back({.id = id,
                      .check = "pictures",
                      .severity = severity,
                      .title = std::move(title),
                      .fix = std::move(fix),
                      .page = std::move(page),
                      .camera = camera.id});
  };
  const auto warn = [&](const char* id, std::string title, std::string fix, std::string page) {
    say(id, Severity::kWarn, std::move(title), std::move(fix), std::move(page));
  };
  const auto severity_of_loss = [&](std::uint64_t count) {
    const auto all = static_cast<double>(camera.last_seconds.all());
    return count > kFewPictures && static_cast<double>(count) > kLostBadShare * all ? Severity::kBad
                                                                                    : Severity::kWarn;
  };
  const Timeline::Sum& minute = camera.last_minute;
  const auto is_much = [&](std::uint64_t count) {
    return count > kFewPictures &&
           static_cast<double>(count) > kLostShare * static_cast<double>(minute.all());
  };
  const auto slow_stage = find_slow_stage(stack_facts(camera));
  if (is_much(minute.dropped)) {
    say("frames_dropped", severity_of_loss(camera.last_seconds.dropped),
        fmt::format("Camera {}: {} of {} images of the last minute were not processed", camera.id,
                    minute.dropped, minute.all()),
        slow_stage ? fmt::format("{}{}.", static_cast<char>(std::toupper(slow_stage->text.front())),
                                 slow_stage->text.substr(1))
                   : "This computer is too slow: close other programs, give the camera's thread a priority "
                     "(thread/realtime_priority), or lower the frame rate.",
        "#/diagnostics");
  }
  if (is_much(minute.incomplete)) {
    say("frames_incomplete", severity_of_loss(camera.last_seconds.incomplete),
        fmt::format("Camera {}: {} of {} images of the last minute arrived damaged", camera.id,
                    minute.incomplete, minute.all()),
        "Check cable and switch, and that the cameras together stay below the link's speed.",
        camera_page(camera));
  }
  if (minute.capped > 0) {
    const std::string what = camera.flood.empty() ? "too much to process" : camera.flood;
    // Without a flood, only the last part of the search is skipped: robots whose centre dot was not seen in
    // the previous images. Other checks report missing robots.
    const bool is_minor = camera.flood.empty() && 2 * minute.capped < minute.all();
    say("frames_capped", is_minor ? Severity::kInfo : Severity::kWarn,
        fmt::format("Camera {}: {}, in {} of {} images of the last minute", camera.id, what, minute.capped,
                    minute.all()),
        camera.flood.empty() ? "Its colour table labels too much of the image: narrow the colours, or "
                               "mask everything that is not field."
                             : "Nothing of that colour is found there. Learn the colours again, widen their "
                               "margins, or mask that "
                               "part if it is not field.",
        fmt::format("#/colours/{}", camera.id));
  }
  if (!camera.exposure) return;
  if (camera.exposure->clipped_share > kClippedShare) {
    warn("picture_clipped",
         fmt::format("Camera {}: {:.1f} % of the image is over-exposed", camera.id,
                     100 * camera.exposure->clipped_share),
         "Shorten its exposure, lower its gain or close its aperture; mask lamps and windows beside the "
         "field.",
         camera_page(camera));
  }
  if (camera.exposure->mean_luma < kDarkLuma) {
    warn("picture_dark",
         fmt::format("Camera {}: the image is dark, its mean luma is {:.0f} of 255", camera.id,
                     camera.exposure->mean_luma),
         "Turn on the light, open its aperture, lengthen its exposure, or raise its gain.",
         camera_page(camera));
  }
}

/// A simulated or recorded camera among real cameras makes parts of the field appear covered that no real
/// camera sees.
void add_origin_alerts(std::vector<Alert>& alerts, std::span<const CameraFacts> cameras) {
  if (std::ranges::count(cameras, ImageOrigin::kCamera, &CameraFacts::origin) == 0) return;
  for (const CameraFacts& camera : cameras) {
    if (camera.origin == ImageOrigin::kCamera) continue;
    alerts.push_back(
        {.id = "camera_not_real",
         .check = "cameras",
         .severity = Severity::kBad,
         .title = fmt::format("Camera {} is {} beside real cameras", camera.id,
                              camera.origin == ImageOrigin::kSimulation ? "simulated" : "a recording"),
         .fix = "Remove it, or choose a real camera as its source: its detections are sent to the teams.",
         .page = camera_page(camera),
         .camera = camera.id});
  }
}

bool is_running(const CameraFacts& camera) {
  return camera.health.state == CameraState::kRunning;
}

std::size_t running(std::span<const CameraFacts> cameras) {
  return static_cast<std::size_t>(std::count_if(cameras.begin(), cameras.end(), is_running));
}

constexpr const char* kNoneRuns = "no camera is running";

Check check_cameras(std::span<const CameraFacts> cameras) {
  const std::size_t count = running(cameras);
  Check check{"cameras",
              "Cameras",
              CheckState::kPass,
              std::to_string(count),
              fmt::format("of {}", cameras.size()),
              "all are running"};
  if (cameras.empty()) {
    check.state = CheckState::kFail;
    check.text = "there is no camera in the settings";
  } else if (count == 0) {
    check.state = CheckState::kFail;
    check.text = kNoneRuns;
  } else if (count < cameras.size()) {
    check.state = CheckState::kWarn;
    check.text = "not all are running";
  }
  for (const ImageOrigin origin : {ImageOrigin::kSimulation, ImageOrigin::kRecording}) {
    const auto such = std::ranges::count(cameras, origin, &CameraFacts::origin);
    if (such > 0)
      check.text +=
          fmt::format(", {} {}", such, origin == ImageOrigin::kSimulation ? "simulated" : "recorded");
  }
  return check;
}

Check check_pictures(std::span<const CameraFacts> cameras) {
  Timeline::Sum sum;
  double clipped = 0;
  std::optional<double> slowest;
  for (const CameraFacts& camera : cameras) {
    if (is_running(camera)) slowest = std::min(slowest.value_or(camera.health.fps), camera.health.fps);
    sum.dropped += camera.last_minute.dropped;
    sum.incomplete += camera.last_minute.incomplete;
    if (camera.exposure) clipped = std::max(clipped, camera.exposure->clipped_share);
  }
  std::string text = sum.dropped + sum.incomplete == 0
                         ? "none lost in 60 s"
                         : fmt::format("{} dropped, {} damaged in 60 s", sum.dropped, sum.incomplete);
  if (clipped >= 0.001) text += fmt::format(", {:.1f} % over-exposed", 100 * clipped);
  if (!slowest) return {"pictures", "Images", CheckState::kUnknown, kNoFigure, "", kNoneRuns};
  return {"pictures", "Images", CheckState::kPass, fmt::format("{:.1f}", *slowest), "per second", text};
}

void report_latency(std::span<const CameraFacts> cameras, HealthReport& report) {
  Check check{"latency", "Latency", CheckState::kUnknown, kNoFigure, "", kNoneRuns};
  constexpr std::uint64_t kMinImages = 100;
  const CameraFacts* worst = nullptr;
  for (const CameraFacts& camera : cameras) {
    if (!is_running(camera)) continue;
    if (!worst) check.text = fmt::format("known after {} images", kMinImages);
    if (camera.latency_images < kMinImages) continue;
    if (!worst || camera.latency_p99_ms > worst->latency_p99_ms) worst = &camera;
  }
  if (!worst) {
    report.checks.push_back(std::move(check));
    return;
  }
  const double worst_ms = worst->latency_p99_ms;
  const bool is_late = worst_ms > kLateAfter_ms, is_too_late = worst_ms > kTooLateAfter_ms;
  check.state = is_too_late ? CheckState::kFail : is_late ? CheckState::kWarn : CheckState::kPass;
  check.value = fmt::format("{:.2f}", worst_ms);
  check.unit = "ms";
  check.text = fmt::format("p99, limit {:g} ms", kLateAfter_ms);
  report.checks.push_back(std::move(check));
  // Where this camera's images are lost, the alert about them names the cause.
  const bool are_lost = std::ranges::any_of(report.alerts, [&](const Alert& alert) {
    return alert.camera == worst->id && (alert.id == "frames_dropped" || alert.id == "stage_slow");
  });
  if (!is_late || (are_lost && !is_too_late)) return;
  const StageFigures* slowest = nullptr;  // the slowest stage, if it takes over half of the allowed time
  for (const StageFigures& stage : worst->stages) {
    if (stage.mean_ms > std::max(kLateAfter_ms / 2, slowest ? slowest->mean_ms : 0)) slowest = &stage;
  }
  report.alerts.push_back(
      {.id = "latency_high",
       .check = "latency",
       .severity = is_too_late ? Severity::kBad : Severity::kWarn,
       .title = fmt::format("Detections leave late: one image in 100 takes more than {:g} ms",
                            is_too_late ? kTooLateAfter_ms : kLateAfter_ms),
       .fix = slowest ? fmt::format("Reduce the work of {}, which takes {:.1f} ms an image.",
                                    stage_text(slowest->name, slowest->library), slowest->mean_ms)
                      : "Close other programs on this computer, or lower the cameras' rates.",
       .page = "#/diagnostics"});
}

}  // namespace

ImageOrigin origin_of(const Json& source) {
  const Json& backend = camera_source(source).at("backend");
  if (backend == "simulator") return ImageOrigin::kSimulation;
  return backend == "files" ? ImageOrigin::kRecording : ImageOrigin::kCamera;
}

const char* name_of(ImageOrigin origin) {
  switch (origin) {
    case ImageOrigin::kRecording: return "recording";
    case ImageOrigin::kSimulation: return "simulation";
    default: return "camera";
  }
}

void report_cameras(std::span<const CameraFacts> cameras, HealthReport& report) {
  add_origin_alerts(report.alerts, cameras);
  for (const CameraFacts& camera : cameras) add_source_alerts(report.alerts, camera);
  for (const CameraFacts& camera : cameras) add_picture_alerts(report.alerts, camera);
  for (const CameraFacts& camera : cameras) report_stages(stack_facts(camera), report);
  for (const auto check : {check_cameras, check_pictures}) report.checks.push_back(check(cameras));
  report_latency(cameras, report);
}

void report_left_out(std::span<const LeftOutLibrary> libraries, HealthReport& report) {
  for (const LeftOutLibrary& library : libraries) {
    report.alerts.push_back({.id = "stage_library",
                             .check = "cameras",
                             .severity = Severity::kWarn,
                             .title = fmt::format("The stage library {} is left out: it {}",
                                                  escaped_text(library.file.string()), library.why),
                             .fix = "Replace it with a working one, or remove it, and restart the service.",
                             .about = escaped_text(library.file.string())});
  }
}

std::string camera_summary(std::span<const CameraFacts> cameras) {
  double fps = 0, p99_ms = 0;
  bool is_first = true;
  for (const CameraFacts& camera : cameras) {
    if (!is_running(camera)) continue;
    fps = std::exchange(is_first, false) ? camera.health.fps : std::min(fps, camera.health.fps);
    p99_ms = std::max(p99_ms, camera.latency_p99_ms);
  }
  return fmt::format("{}/{} cameras {:.1f} fps p99 {:.1f} ms", running(cameras), cameras.size(), fps, p99_ms);
}

std::optional<Hang> find_hang(const CameraProgress& camera, std::int64_t now_ns) {
  const CameraHealth& health = camera.health;
  if (health.state != CameraState::kRunning) {
    // The hanging thread may be the camera's previous thread: the thread that will reopen the camera waits
    // for it to end.
    const bool hangs = camera.stage && now_ns - camera.stage->since_ns >= kHangs_ns;
    return hangs ? camera.stage : std::nullopt;
  }
  if (now_ns - health.progress_ns < kHangs_ns) return std::nullopt;
  Hang hang = camera.stage.value_or(Hang{});
  hang.since_ns = health.progress_ns;
  return hang;
}

std::string find_hanging(const std::vector<CameraProgress>& cameras, std::int64_t now_ns) {
  std::string out;
  for (const CameraProgress& camera : cameras) {
    const auto hang = find_hang(camera, now_ns);
    if (!hang) continue;
    out += fmt::format("{}camera {} has hung for {} s{}", out.empty() ? "" : ", ", camera.id,
                       (now_ns - hang->since_ns) / 1'000'000'000, place_text(*hang));
  }
  return out;
}

std::string find_missing(const std::vector<CameraProgress>& cameras) {
  std::string out;
  for (const auto& [id, health, stage] : cameras) {
    if (health.state == CameraState::kRunning) continue;
    out += fmt::format("camera {} is {}{}{}\n", id, name_of(health.state), health.error.empty() ? "" : ": ",
                       health.error);
  }
  return out;
}

}  // namespace sslv
