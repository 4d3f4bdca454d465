// SPDX-License-Identifier: Apache-2.0
#include "capture/camera_thread.h"

#include "base/clock.h"
#include "base/log.h"
#include "capture/picture_check.h"

#include <algorithm>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <system_error>
#include <utility>

#include <fmt/format.h>
#include <pthread.h>
#include <sched.h>

namespace sslv {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kTurn{100};  // the longest wait for a picture, and so for stop() to be seen
constexpr milliseconds kStopPatience{1500};
/// After more damaged pictures than this in a row, a pause before the next: a source that fails at once must
/// not take a whole processor.
constexpr int kStorm = 10;
constexpr milliseconds kStormPause{1};
constexpr std::int64_t kSecondNs = 1'000'000'000;
constexpr std::int64_t kRepeatedLossNs = 60 * kSecondNs;

/// Pictures that came damaged, or whose time cannot be: one line a second, with their number.
class DamageLog {
 public:
  DamageLog(const std::string& name, const char* what) : name_(name), what_(what) {}

  void add(std::string& problem) {
    ++count_;
    last_.swap(problem);
  }
  void write_if_due() {
    if (steady_ns() >= due_ns_) write();
  }
  void write() {
    if (count_ == 0) return;
    if (count_ == 1) log::warning("{}: picture {}: {}", name_, what_, last_);
    if (count_ > 1) log::warning("{}: {} pictures {}, the last: {}", name_, count_, what_, last_);
    count_ = 0;
    due_ns_ = steady_ns() + kSecondNs;
  }

 private:
  const std::string& name_;
  const char* const what_;
  std::string last_;
  int count_ = 0;
  std::int64_t due_ns_ = 0;
};

/// Losses of the camera: each new reason at once, one that stays the same once a minute, with its number.
class LossLog {
 public:
  explicit LossLog(const std::string& name) : name_(name) {}

  void lost(const std::string& reason) {
    ++count_;
    const std::int64_t now_ns = steady_ns();
    if (reason == reason_ && now_ns < due_ns_) return;
    log::error("{}: {}{}", name_, reason,
               reason == reason_ && count_ > 1 ? fmt::format(" ({} times in the last minute)", count_) : "");
    reason_ = reason;
    count_ = 0;
    due_ns_ = now_ns + kRepeatedLossNs;
    announce_open_ = true;
  }
  void opened() {
    if (std::exchange(announce_open_, false)) log::info("{}: open", name_);
  }

 private:
  const std::string& name_;
  std::string reason_;
  int count_ = 0;
  std::int64_t due_ns_ = 0;
  bool announce_open_ = true;
};

/// The thread goes on without what the system does not grant.
void apply(const ThreadSettings& settings, const std::string& name) {
  constexpr std::size_t kLongestName = 15;
  pthread_setname_np(pthread_self(), name.substr(0, kLongestName).c_str());
  if (settings.realtime_priority > 0) {
    sched_param parameters{};
    parameters.sched_priority = settings.realtime_priority;
    if (const int error = pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameters); error != 0) {
      log::warning("{}: real-time priority {} not set: {}", name, settings.realtime_priority,
                   std::generic_category().message(error));
    }
  }
  if (settings.cpu >= 0) {
    cpu_set_t set;
    CPU_ZERO(&set);
    CPU_SET(static_cast<std::size_t>(settings.cpu), &set);
    if (const int error = pthread_setaffinity_np(pthread_self(), sizeof set, &set); error != 0) {
      log::warning("{}: not bound to processor {}: {}", name, settings.cpu,
                   std::generic_category().message(error));
    }
  }
}

}  // namespace

std::string_view name_of(CameraState state) {
  switch (state) {
    case CameraState::kOpening: return "opening";
    case CameraState::kRunning: return "running";
    case CameraState::kLost: return "lost";
    case CameraState::kEnded: return "ended";
  }
  return "unknown";
}

/// What the threads work on; a thread that stop() left behind keeps it alive.
struct CameraThread::Shared : std::enable_shared_from_this<Shared> {
  Shared(std::string thread_name, const ThreadSettings& thread_settings, Open open_source, OnImage take_image,
         RetryDelays retry_delays, std::shared_ptr<CaptureTotals> capture_totals)
      : name(std::move(thread_name)),
        settings(thread_settings),
        open(std::move(open_source)),
        on_image(std::move(take_image)),
        delays(retry_delays),
        totals(std::move(capture_totals)) {}

  void run();
  std::unique_ptr<Source> try_open();
  CaptureStatus serve(Source& source);
  CaptureStatus turn(Source& source, CapturedImage& image, std::string& problem);
  void check_times(CaptureTimes& times);
  bool deliver(CapturedImage&& image);
  void forget_controls();
  void lose(const std::string& reason);
  void close_aside(std::unique_ptr<Source> source);
  CameraHealth health_now() const {
    const std::lock_guard lock(mutex);
    return health;
  }
  bool stopping() const {
    const std::lock_guard lock(mutex);
    return stop_asked;
  }

  const std::string name;
  const ThreadSettings settings;
  const Open open;
  const OnImage on_image;
  const RetryDelays delays;
  const std::shared_ptr<CaptureTotals> totals;

  // Used by the camera's thread alone.
  DamageLog damages{name, "damaged"}, strange_times{name, "with a time that cannot be"};
  LossLog losses{name};
  milliseconds delay = delays.first;
  bool was_open = false;

  std::mutex delivery;    // held during on_image
  bool silenced = false;  // guarded by delivery: no more on_image

  mutable std::mutex mutex;  // guards what follows
  std::condition_variable changed;
  CameraHealth health;
  std::shared_ptr<Controls> controls;
  bool stop_asked = false;
  std::chrono::steady_clock::time_point stop_asked_at{};
  bool finished = false;
  int closing = 0;  // sources being closed aside
};

void CameraThread::Shared::run() {
  apply(settings, name);
  while (!stopping()) {
    const std::int64_t began_ns = steady_ns();
    milliseconds tried_for{0};
    if (std::unique_ptr<Source> source = try_open()) {
      const CaptureStatus end = serve(*source);
      forget_controls();
      close_aside(std::move(source));
      if (end == CaptureStatus::kEnd) break;
    } else {
      tried_for = milliseconds((steady_ns() - began_ns) / 1'000'000);
    }
    std::unique_lock lock(mutex);
    changed.wait_for(lock, std::max(delays.first, delay - tried_for), [&] { return stop_asked; });
    delay = std::min(2 * delay, delays.longest);
  }
  damages.write();
  strange_times.write();
  {
    const std::lock_guard lock(mutex);
    finished = true;
  }
  changed.notify_all();
}

std::unique_ptr<Source> CameraThread::Shared::try_open() {
  {
    const std::lock_guard lock(mutex);
    health.progress_ns = steady_ns();
  }
  try {
    std::unique_ptr<Source> source = open();
    if (!source) throw CaptureError("the driver has opened nothing");
    std::vector<std::string> warnings = source->warnings();
    if (!stopping()) {
      losses.opened();
      for (const std::string& warning : warnings) log::warning("{}: {}", name, warning);
    }
    const std::lock_guard lock(mutex);
    controls = source->controls();
    health.warnings = std::move(warnings);
    if (std::exchange(was_open, true)) {
      ++health.reconnects;
      totals->reconnects.fetch_add(1, std::memory_order_relaxed);
    }
    health.progress_ns = steady_ns();  // opening may have taken long
    health.state = CameraState::kRunning;
    health.error.clear();
    return source;
  } catch (const std::exception& error) {
    lose(error.what());
  } catch (...) {
    lose("unknown error");
  }
  return nullptr;
}

/// Hands pictures over until the camera is lost, the recording has ended or stop() was called.
CaptureStatus CameraThread::Shared::serve(Source& source) {
  std::int64_t window_start_ns = steady_ns();
  int window_frames = 0, damaged_in_a_row = 0;
  const CameraHealth before = health_now();
  for (;;) {
    CapturedImage image;
    std::string problem;
    const CaptureStatus status = turn(source, image, problem);
    if (status == CaptureStatus::kImage) check_times(image.times);
    const ImageView view = image.image.view();
    const bool is_damaged = image.is_damaged;
    const CaptureTimes times = image.times;
    bool delivered = false;
    if (status == CaptureStatus::kImage) {
      image.times.arrived_ns = steady_ns();
      delivered = deliver(std::move(image));
      window_frames += delivered;
      delay = delays.first;
    } else if (status == CaptureStatus::kLost) {
      lose(problem);
    } else if (status == CaptureStatus::kIncomplete) {
      damages.add(problem);
    }
    damages.write_if_due();
    strange_times.write_if_due();
    damaged_in_a_row = status == CaptureStatus::kIncomplete ? damaged_in_a_row + 1 : 0;

    std::unique_lock lock(mutex);
    if (damaged_in_a_row > kStorm) changed.wait_for(lock, kStormPause, [&] { return stop_asked; });
    const std::int64_t now_ns = steady_ns();
    health.progress_ns = now_ns;
    if (delivered) {
      ++health.frames;
      health.width = view.width;
      health.height = view.height;
      health.format = view.format;
      health.times = times;
    }
    const bool is_incomplete = status == CaptureStatus::kIncomplete || is_damaged;
    health.incomplete += is_incomplete;
    totals->incomplete.fetch_add(is_incomplete, std::memory_order_relaxed);
    const std::uint64_t dropped = before.dropped + source.dropped();
    totals->dropped.fetch_add(dropped - health.dropped, std::memory_order_relaxed);
    health.dropped = dropped;
    if (const auto packets = source.packets()) {
      const PacketCounts earlier = before.packets.value_or(PacketCounts{});
      health.packets = {earlier.missing + packets->missing, earlier.resent + packets->resent};
    }
    if (now_ns - window_start_ns >= kSecondNs) {
      health.fps = window_frames * 1e9 / static_cast<double>(now_ns - window_start_ns);
      window_start_ns = now_ns;
      window_frames = 0;
    }
    if (status == CaptureStatus::kEnd) health.state = CameraState::kEnded;
    if (status == CaptureStatus::kEnd || status == CaptureStatus::kLost) health.fps = 0;
    if (status == CaptureStatus::kEnd || status == CaptureStatus::kLost || stop_asked) return status;
  }
}

CaptureStatus CameraThread::Shared::turn(Source& source, CapturedImage& image, std::string& problem) {
  try {
    const CaptureStatus status = source.next(image, problem, kTurn);
    if (status != CaptureStatus::kImage) return status;
    problem = find_fault(image.image.view());
    return problem.empty() ? status : CaptureStatus::kIncomplete;
  } catch (const std::exception& error) {
    problem = error.what();
  } catch (...) {
    problem = "unknown error";
  }
  return CaptureStatus::kLost;
}

void CameraThread::Shared::check_times(CaptureTimes& times) {
  const double given_s = times.t_capture_s, now_s = unix_time_s();
  if (!mend_times(times, now_s)) return;
  std::string problem = fmt::format("{:.3f} s, where the clock says {:.3f} s", given_s, now_s);
  strange_times.add(problem);
}

bool CameraThread::Shared::deliver(CapturedImage&& image) {
  const std::lock_guard lock(delivery);
  if (silenced) return false;
  on_image(std::move(image));
  return true;
}

void CameraThread::Shared::forget_controls() {
  const std::lock_guard lock(mutex);
  controls.reset();
}

void CameraThread::Shared::lose(const std::string& reason) {
  if (!stopping()) losses.lost(reason);
  const std::lock_guard lock(mutex);
  health.state = CameraState::kLost;
  health.error = reason;
}

void CameraThread::Shared::close_aside(std::unique_ptr<Source> source) {
  {
    const std::lock_guard lock(mutex);
    ++closing;
  }
  const auto closed = [](Shared& shared) {
    {
      const std::lock_guard lock(shared.mutex);
      --shared.closing;
    }
    shared.changed.notify_all();
  };
  try {
    std::thread([shared = shared_from_this(), dead = std::move(source), closed]() mutable {
      dead.reset();
      closed(*shared);
    }).detach();
  } catch (const std::system_error&) {  // no thread to be had: closed here, when the thread's state went
    closed(*this);
  }
}

CameraThread::CameraThread(std::string name, const ThreadSettings& settings, Open open, OnImage on_image,
                           RetryDelays delays, std::shared_ptr<CaptureTotals> totals)
    : shared_(std::make_shared<Shared>(std::move(name), settings, std::move(open), std::move(on_image),
                                       delays, std::move(totals))),
      thread_([shared = shared_] { shared->run(); }) {}

CameraThread::~CameraThread() {
  stop();
}

void CameraThread::ask_to_stop() {
  {
    const std::lock_guard lock(shared_->mutex);
    if (std::exchange(shared_->stop_asked, true)) return;
    shared_->stop_asked_at = std::chrono::steady_clock::now();
  }
  shared_->changed.notify_all();
}

void CameraThread::stop() {
  if (!thread_.joinable()) return;
  ask_to_stop();
  {
    const std::lock_guard lock(shared_->delivery);
    shared_->silenced = true;
  }
  std::unique_lock lock(shared_->mutex);
  const auto idle = [&] { return shared_->finished && shared_->closing == 0; };
  if (!shared_->changed.wait_until(lock, shared_->stop_asked_at + kStopPatience, idle)) {
    log::warning("{}: does not answer; it is left to close by itself", shared_->name);
  }
  const bool finished = shared_->finished;
  lock.unlock();
  finished ? thread_.join() : thread_.detach();
}

CameraHealth CameraThread::health() const {
  return shared_->health_now();
}

std::shared_ptr<Controls> CameraThread::controls() const {
  const std::lock_guard lock(shared_->mutex);
  return shared_->controls;
}

}  // namespace sslv
