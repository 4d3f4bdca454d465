// SPDX-License-Identifier: Apache-2.0
#include "services/recording/clip_maker.h"

#include "base/clock.h"
#include "base/error.h"
#include "base/log.h"
#include "config/version.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <optional>
#include <utility>

#include <fmt/format.h>

namespace sslv {
namespace {

constexpr std::chrono::milliseconds kNextFrames{20};
/// Waiting time for late frames after the clip's end.
constexpr double kLateFrames_s = 0.3;
constexpr std::uint64_t kCheckDiskEvery = 64'000'000;  // bytes
constexpr const char* kStopped = "the service was stopped";

std::int64_t to_ns(double steady_s) {
  return std::llround(steady_s * 1e9);
}

}  // namespace

struct ClipMaker::Work {
  const ClipOrder& order;
  const Hooks& hooks;
  std::vector<ClipCamera> cameras{};
  std::optional<ClipWriter> writer{};
  ClipProgress progress{};
  std::uint64_t checked_bytes = 0;

  void hold() {
    for (ClipCamera& camera : cameras) camera.ring().hold(to_ns(order.begin_s), to_ns(order.end_s));
  }
  bool has_begun() const { return std::ranges::any_of(cameras, &ClipCamera::has_begun); }
  void tell() {
    progress.missing = 0;
    for (const ClipCamera& camera : cameras) progress.missing += camera.missing();
    progress.bytes = writer->bytes();
    if (hooks.tell) hooks.tell(progress);
  }
};

ClipProgress ClipMaker::make(const ClipOrder& order, std::vector<LastSeconds::Ring> rings, int every_nth,
                             const Hooks& hooks, const std::stop_token& stop) {
  const auto must_wait = [&] { return order.can_wait && stop.stop_requested(); };
  // Checked before recordings are removed to make space for the clip.
  if (must_wait()) return {.why = order.why, .problem = kStopped};
  Work work{.order = order, .hooks = hooks};
  work.progress.why = order.why;
  work.cameras.reserve(rings.size());
  for (LastSeconds::Ring& ring : rings) work.cameras.emplace_back(std::move(ring), every_nth);
  work.hold();  // before the file is created, so that the frames are not overwritten meanwhile
  std::filesystem::path file;
  bool is_finished = false;
  try {
    double bytes = 0;
    for (const ClipCamera& camera : work.cameras) bytes += camera.expected_bytes(order.end_s - steady_s());
    const auto config = config_.load();
    files_.make_room(config->recording, RoomFor::kClip, events_, static_cast<std::uint64_t>(bytes));
    file = files_.begin(order.name, RecordingFile::Kind::kClip);
    work.progress.file = file.filename().string();
    const double ahead_s = unix_time_s() - steady_s();  // offset from steady to Unix time
    work.writer.emplace(file,
                        ClipAbout{.site = config->site,
                                  .version = kVersion,
                                  .kind = order.kind,
                                  .why = order.why,
                                  .begin_s = order.begin_s + ahead_s,
                                  .end_s = order.end_s + ahead_s},
                        max_blocks_);
    work.tell();
    write(work, stop);
    if (must_wait()) throw StorageError(kStopped);
    finish(work);
    is_finished = true;
  } catch (const std::exception& error) {
    work.progress.problem = error.what();
  }
  for (ClipCamera& camera : work.cameras) camera.ring().let_all_go();
  work.writer.reset();
  try {
    if (!file.empty()) files_.end(file, is_finished);
    const bool is_left = work.has_begun() && !must_wait();
    if (!file.empty() && !is_left) files_.remove(work.progress.file);
  } catch (const StorageError& error) {
    log::warning("{}", error.what());
  }
  return work.progress;
}

void ClipMaker::write(Work& work, const std::stop_token& stop) {
  std::mutex idle;
  std::condition_variable_any stopped;
  for (;;) {
    const double now_s = steady_s();
    work.hold();
    for (bool is_more = true; is_more && !stop.stop_requested();) {
      if (work.writer->is_full()) {
        log::warning("clip {} ends early: it has as many frames as a clip can have", work.progress.file);
        for (ClipCamera& camera : work.cameras) camera.end_now();
        return;
      }
      if (steady_s() >= work.order.end_s)
        for (ClipCamera& camera : work.cameras) camera.end_now();
      is_more = write_next(work);
      if (work.writer->bytes() - work.checked_bytes < kCheckDiskEvery) continue;
      work.checked_bytes = work.writer->bytes();
      files_.make_room(config_.load()->recording, RoomFor::kClip, events_);
    }
    if (work.hooks.wait) work.hooks.wait();
    // Return only if the last hold() was called after the waiting time for late frames.
    if (now_s > work.order.end_s + kLateFrames_s || stop.stop_requested()) return;
    std::unique_lock lock(idle);
    stopped.wait_for(lock, stop, kNextFrames, [] { return false; });
  }
}

/// Writes the held frame that arrived first. Returns false if no frame is held.
bool ClipMaker::write_next(Work& work) {
  ClipCamera* first = nullptr;
  std::int64_t first_ns = 0;
  for (ClipCamera& camera : work.cameras) {
    const ClipFrame* const frame = camera.ring().oldest_held();
    if (frame == nullptr || (first != nullptr && frame->info.times.arrived_ns >= first_ns)) continue;
    first = &camera;
    first_ns = frame->info.times.arrived_ns;
  }
  if (first == nullptr) return false;
  work.progress.frames += first->write_oldest(*work.writer);
  work.tell();
  return true;
}

void ClipMaker::finish(Work& work) {
  if (!work.has_begun()) throw StorageError("no camera has images from that time in memory");
  double newest_s = 0;
  for (ClipCamera& camera : work.cameras) {
    camera.note_dropped(*work.writer);
    newest_s = std::max(newest_s, camera.newest_s());
  }
  if (work.hooks.happened)
    for (const ClipEvent& event : work.hooks.happened(newest_s)) work.writer->add(event);
  work.writer->finish();
  work.tell();
  const ClipProgress& done = work.progress;
  log::info("clip {} was written: {} frames, {} missing, {} bytes ({})", done.file, done.frames, done.missing,
            done.bytes, done.why);
  events_.add({.id = "clip_written",
               .title = fmt::format("Clip {} was written: {}", done.file, done.why),
               .who = work.order.who});
}

}  // namespace sslv
