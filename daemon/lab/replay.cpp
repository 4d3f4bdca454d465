// SPDX-License-Identifier: Apache-2.0
#include "lab/replay.h"

#include "base/clock.h"
#include "base/plain_text.h"
#include "config/version.h"
#include "ctl/table.h"
#include "vision/detections_json.h"

#include <algorithm>
#include <memory>
#include <ostream>

#include <fmt/format.h>

namespace sslv {
namespace {

void write_found(const ClipReplay::Result& result, std::ostream& out) {
  const Frame& frame = *result.frame;
  Json line{{"frame", clip_frame_name(frame.info.number)},
            {"camera", frame.info.camera_id},
            {"t", frame.info.times.t_capture_s},
            {"exact", result.is_exact}};
  line.update(detections_json(frame.robots, frame.balls));
  out << json_text(line) << '\n';
}

ReplayedCamera replay_camera(ClipReader& clip, std::uint32_t camera_id, const ReplayCommand& command) {
  ReplayedCamera out{camera_id};
  // Repeats the live run with the clip's settings. The run with other settings is compared with this
  // repetition, so that both runs have the same input.
  std::vector<std::vector<std::byte>> packets;
  const auto begin_s = steady_s();
  if (command.compares && command.other) {
    ClipReplay live(clip, camera_id, command.span);
    ClipReplay::Result result;
    while (live.next(result)) packets.emplace_back(result.packet.begin(), result.packet.end());
    out.processed += live.processed();
  }
  ClipReplay replay(clip, camera_id, command.span, command.other);
  if (command.compares) out.comparison.emplace(command.limits);
  ClipReplay::Result result;
  double first_s = 0, last_s = 0;
  while (replay.next(result)) {
    const double t_s = result.recorded->info.times.t_capture_s;
    if (out.frames == 0) first_s = t_s;
    last_s = t_s;
    if (command.found != nullptr) write_found(result, *command.found);
    if (out.comparison) {
      if (command.other) {
        out.comparison->add(packets.at(out.frames), result.packet);
      } else {
        out.comparison->add(result.recorded->packet, result.packet);
      }
    }
    ++out.frames;
    out.exact += result.is_exact;
  }
  out.took_s = steady_s() - begin_s;
  out.processed += replay.processed();
  out.clip_s = last_s - first_s;
  out.doubts = replay.doubts();
  if (out.comparison) {
    out.differs = command.other ? out.comparison->frames_that_differ() > 0
                                : out.comparison->frames_with_other_bytes() > 0;
  }
  return out;
}

double speed_of(const ReplayedCamera& camera) {
  return camera.took_s > 0 ? camera.clip_s / camera.took_s : 0;
}

std::string thing_text(const ClipDifference& one) {
  if (!one.team) return "ball";
  const int id = one.id_after >= 0 ? one.id_after : one.id_before;
  return fmt::format("{} {}", name_of(*one.team), id);
}

std::string difference_text(const ClipDifference& one) {
  const std::string place = fmt::format("at {:.0f}, {:.0f}", one.x_mm, one.y_mm);
  switch (one.kind) {
    case ClipDifference::Kind::kFound: return fmt::format("{} found {}", thing_text(one), place);
    case ClipDifference::Kind::kLost: return fmt::format("{} lost {}", thing_text(one), place);
    case ClipDifference::Kind::kIdChanged:
      return fmt::format("{} was {} {}", thing_text(one), one.id_before, place);
    case ClipDifference::Kind::kMoved: break;
  }
  return fmt::format("{} moved by {:.1f} mm, {:.1f} deg {}", thing_text(one), one.moved_mm, one.turned_deg,
                     place);
}

std::string counts_text(const char* what, const DifferenceCounts& counts) {
  return fmt::format(
      "  {:<7} {:>8} before {:>8} after {:>6} found {:>6} lost {:>6} moved {:>6} with another "
      "id; at most {:.3f} mm, {:.3f} deg apart\n",
      what, counts.before, counts.after, counts.found, counts.lost, counts.moved, counts.id_changed,
      counts.max_moved_mm, counts.max_turned_deg);
}

std::string comparison_text(const ClipComparison& comparison, bool with_other_settings) {
  constexpr std::size_t kShown = 20;
  std::string out;
  if (!with_other_settings && comparison.frames_with_other_bytes() == 0)
    return "  every packet is the live one, byte for byte\n";
  if (!with_other_settings)
    out += fmt::format("  {} of {} packets are other bytes than the live ones\n",
                       comparison.frames_with_other_bytes(), comparison.frames());
  out += fmt::format("  {} of {} frames differ\n", comparison.frames_that_differ(), comparison.frames());
  out += counts_text("robots", comparison.robots()) + counts_text("balls", comparison.balls());
  std::size_t shown = 0;
  for (const FrameDifferences& frame : comparison.different_frames()) {
    if (frame.differences.empty()) continue;
    if (++shown > kShown) {
      out += fmt::format("  ... and {} more frames; all are in --json\n",
                         comparison.frames_that_differ() - kShown);
      break;
    }
    std::string what;
    for (const ClipDifference& one : frame.differences)
      what += (what.empty() ? "" : "; ") + difference_text(one);
    out += fmt::format("  frame {:>7}  {}\n", frame.number, what);
  }
  return out;
}

}  // namespace

Json clip_info_json(const std::filesystem::path& file, const ClipReader& clip) {
  const auto& entries = clip.entries();
  const ClipAbout& about = clip.about();
  Json cameras = Json::array(), events = Json::array();
  for (const ClipReader::Camera& camera : clip.cameras()) {
    std::uint64_t in_parts = 0, memories = 0;
    double first_s = 0, last_s = 0;
    for (const std::size_t place : camera.frames) {
      in_parts += !entries[place].is_whole;
      memories += entries[place].has_memory;
    }
    if (!camera.frames.empty()) {
      first_s = entries[camera.frames.front()].t_capture_s;
      last_s = entries[camera.frames.back()].t_capture_s;
    }
    cameras.push_back({{"id", camera.id},
                       {"frames", camera.frames.size()},
                       {"missing", camera.missing},
                       {"in_parts", in_parts},
                       {"begins", memories},
                       {"begin_s", first_s},
                       {"seconds", last_s - first_s}});
  }
  for (const ClipEvent& event : clip.events())
    events.push_back({{"time_s", event.time_s}, {"kind", event.kind}, {"text", event.text}});
  std::error_code ignored;
  return {{"clip", file.string()},
          {"bytes", std::filesystem::file_size(file, ignored)},
          {"site", about.site},
          {"version", about.version},
          {"why", about.why},
          {"begin_s", entries.empty() ? about.begin_s : entries.front().t_capture_s},
          {"seconds", entries.empty() ? 0.0 : entries.back().t_capture_s - entries.front().t_capture_s},
          {"setups", clip.setup_count()},
          {"unfinished", clip.is_unfinished()},
          {"problem", clip.problem()},
          {"cameras", std::move(cameras)},
          {"events", std::move(events)}};
}

std::string clip_info_text(const Json& info) {
  const double begin_s = info.at("begin_s").get<double>();
  const std::string version = info.at("version").get<std::string>();
  std::string out = fmt::format(
      "{}\n  {}, begins {}, lasts {:.1f} s, {:.1f} MB{}\n  kept: {}\n  by ssl-visiond {}{}\n",
      info.at("clip").get<std::string>(), info.at("site").get<std::string>(), local_time_text(begin_s),
      info.at("seconds").get<double>(), info.at("bytes").get<double>() * 1e-6,
      info.at("unfinished").get<bool>() ? ", was not ended" : "", info.at("why").get<std::string>(), version,
      version == kVersion ? "" : fmt::format("; this is {}, which may find other things", kVersion));
  if (const std::string problem = info.at("problem").get<std::string>(); !problem.empty())
    out += fmt::format("  {}\n", problem);
  std::vector<std::vector<std::string>> rows;
  for (const Json& camera : info.at("cameras")) {
    const double seconds = camera.at("seconds").get<double>();
    const auto frames = camera.at("frames").get<std::uint64_t>();
    rows.push_back({std::to_string(camera.at("id").get<int>()), std::to_string(frames),
                    seconds > 0 ? fmt::format("{:.1f}", static_cast<double>(frames - 1) / seconds) : "",
                    std::to_string(camera.at("missing").get<std::uint64_t>()),
                    std::to_string(camera.at("in_parts").get<std::uint64_t>()),
                    std::to_string(camera.at("begins").get<std::uint64_t>())});
  }
  out += "\n" + table_text({{"camera", true},
                            {"frames", true},
                            {"fps", true},
                            {"missing", true},
                            {"in parts", true},
                            {"exact begins", true}},
                           rows);
  for (const Json& event : info.at("events")) {
    out += fmt::format("  {:>8.1f} s  {:<8} {}\n", event.at("time_s").get<double>() - begin_s,
                       event.at("kind").get<std::string>(), event.at("text").get<std::string>());
  }
  return out;
}

std::vector<ReplayedCamera> replay_cameras(ClipReader& clip, const ReplayCommand& command) {
  std::vector<ReplayedCamera> out;
  if (command.camera_id) {
    out.push_back(replay_camera(clip, *command.camera_id, command));
  } else {
    for (const ClipReader::Camera& camera : clip.cameras())
      out.push_back(replay_camera(clip, camera.id, command));
  }
  return out;
}

Json replayed_json(const std::vector<ReplayedCamera>& cameras) {
  Json out = Json::array();
  for (const ReplayedCamera& camera : cameras) {
    out.push_back({{"camera", camera.camera_id},
                   {"frames", camera.frames},
                   {"exact", camera.exact},
                   {"doubts", camera.doubts},
                   {"processed", camera.processed},
                   {"clip_s", camera.clip_s},
                   {"took_s", camera.took_s},
                   {"times_real_time", speed_of(camera)},
                   {"differs", camera.differs},
                   {"comparison", camera.comparison ? comparison_json(*camera.comparison) : Json(nullptr)}});
  }
  return out;
}

std::string replayed_text(const std::vector<ReplayedCamera>& cameras, bool with_other_settings) {
  std::string out;
  for (const ReplayedCamera& camera : cameras) {
    const std::string how = with_other_settings             ? "other settings"
                            : camera.exact == camera.frames ? "exact"
                                                            : fmt::format("{} of them exact", camera.exact);
    out += fmt::format("camera {}: {} frames, {}; {:.1f} s in {:.2f} s: {:.1f}x real time\n",
                       camera.camera_id, camera.frames, how, camera.clip_s, camera.took_s, speed_of(camera));
    for (const std::string& doubt : camera.doubts) out += fmt::format("  {}\n", escaped_text(doubt));
    if (camera.comparison) out += comparison_text(*camera.comparison, with_other_settings);
  }
  return out;
}

std::string exported_text(const std::vector<ExportedCamera>& cameras) {
  std::string out;
  for (const ExportedCamera& camera : cameras) {
    out += fmt::format("camera {}: {} frames, {} robots, {} balls\n", camera.camera_id, camera.frames,
                       camera.robots, camera.balls);
    for (const std::string& doubt : camera.doubts) out += fmt::format("  {}\n", escaped_text(doubt));
  }
  return out;
}

}  // namespace sslv
