// SPDX-License-Identifier: Apache-2.0
#include "capture/camera_thread.h"

#include "base/clock.h"
#include "base/left_behind.h"
#include "base/log.h"
#include "base/seqlock.h"
#include "capture/picture_check.h"

#include <algorithm>
#include <condition_variable>
#include <memory>
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

constexpr milliseconds kPollTimeout{100};  // longest wait for an image, or until stop() is noticed
constexpr milliseconds kShortTurn{10};     // longest wait while buffers are held that the camera may need
/// After this many damaged images in a row, pause before the next one: a source that fails at once must not
/// use a whole processor.
constexpr int kStorm = 10;
constexpr milliseconds kStormPause{1};
constexpr std::int64_t kSecondNs = 1'000'000'000;
constexpr std::int64_t kRepeatedLossNs = 60 * kSecondNs;

/// Logs damaged images, or images with impossible times: one line a second, with their count.
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
    if (count_ == 1) log::warning("{}: image {}: {}", name_, what_, last_);
    if (count_ > 1) log::warning("{}: {} images {}, the last: {}", name_, count_, what_, last_);
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

/// Logs losses of the camera: a new reason immediately, a repeated reason every minute with its count.
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

/// Settings that the system refuses are only logged.
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

namespace {

/// The values that may change with every image, published together after each poll.
struct Figures {
  CameraState state = CameraState::kOpening;
  std::uint64_t frames = 0, incomplete = 0, dropped = 0, reconnects = 0;
  std::optional<PacketCounts> packets{};
  double fps = 0;
  int width = 0, height = 0;
  PixelFormat format = PixelFormat::kMono8;
  std::int64_t progress_ns = 0;
  CaptureTimes times{};
};

/// Calls that can be disabled permanently. Each side first sets its own flag and then reads the other's:
/// either pass() sees that calls are silenced, or silence() sees the call and waits.
class CallGate {
 public:
  /// Returns false without calling if silenced.
  template <class Call>
  bool pass(const Call& call) {
    calling_.store(1);
    const bool may_call = !silenced_.load();
    if (may_call) call();
    calling_.store(0);
    if (silenced_.load()) calling_.notify_all();
    return may_call;
  }

  /// Prevents further calls, and waits for a running one.
  void silence() {
    silenced_.store(true);
    while (calling_.load() != 0) calling_.wait(1);
  }

  /// Prevents further calls; returns whether silence() would return immediately.
  bool try_silence() {
    silenced_.store(true);
    return calling_.load() == 0;
  }

  /// Between these two calls, silence() also waits for a predecessor's calls.
  void begin_predecessor() { calling_.store(1); }
  void end_predecessor() {
    calling_.store(0);
    calling_.notify_all();
  }

 private:
  std::atomic<int> calling_{0};  // 1: a call may be running, here or in a predecessor
  std::atomic<bool> silenced_{false};
};

/// The camera's log messages.
struct CaptureLogs {
  explicit CaptureLogs(const std::string& name)
      : damages(name, "damaged"), strange_times(name, "with an impossible time"), losses(name) {}

  DamageLog damages, strange_times;
  LossLog losses;
};

/// The result of the last attempt to open the camera.
struct OpeningResult {
  std::string why_lost;  // empty if not lost
  std::vector<std::string> warnings;
  std::shared_ptr<Controls> controls;
};

}  // namespace

/// State of the threads. A thread that stop() detached keeps the state alive.
struct CameraThread::Shared : std::enable_shared_from_this<Shared> {
  /// The constructor's arguments.
  struct Parts {
    std::string name;
    ThreadSettings settings;
    Open open;
    OnImage on_image;
    OnIdle on_idle;
    CameraDelays delays;
    std::shared_ptr<CaptureTotals> totals;
  };
  /// Progress between start() and the thread's end.
  struct Lifecycle {
    std::unique_ptr<CameraThread> predecessor;
    std::chrono::steady_clock::time_point stop_asked_at{};
    bool started = false, finished = false;
    int closing = 0;  // number of sources being closed on other threads
  };

  explicit Shared(Parts given) : parts(std::move(given)) {}

  void run();
  bool wait_for_start();
  void keep_open();
  std::unique_ptr<Source> try_open();
  CaptureStatus serve(Source& source);
  CaptureStatus poll_once(Source& source, CapturedImage& image, std::string& problem, milliseconds patience);
  void check_times(CaptureTimes& times);
  bool buffers_are_out();
  void forget_controls();
  void mark_lost(const std::string& reason);
  void close_aside(std::unique_ptr<Source> source);
  void ask_to_stop();
  CameraState try_now();
  CameraHealth health_now() const;
  bool stopping() const { return stop_asked.load(std::memory_order_relaxed); }

  const Parts parts;

  // Used only by the camera's thread.
  CaptureLogs logs{parts.name};
  milliseconds delay = parts.delays.first;
  bool was_open = false;
  Figures now;

  // Accessed without a lock, for each image.
  Seqlock<Figures> figures;             // copy of `now` at the end of the last poll
  CallGate calls;                       // gate for calls of on_image and on_idle
  std::atomic<bool> stop_asked{false};  // set with the mutex held, so that waits on `changed` notice it

  // Locked when the camera is opened or lost, and by health().
  mutable std::mutex mutex;  // guards the following members and changes of the state
  std::condition_variable changed;
  OpeningResult opening;
  Lifecycle lifecycle;
  bool try_asked = false;  // try_now() requested an immediate attempt
};

CameraHealth CameraThread::Shared::health_now() const {
  CameraHealth out;
  const std::lock_guard lock(mutex);
  const Figures newest = figures.load();
  out.state = newest.state;
  out.error = opening.why_lost;
  out.frames = newest.frames;
  out.incomplete = newest.incomplete;
  out.dropped = newest.dropped;
  out.packets = newest.packets;
  out.reconnects = newest.reconnects;
  out.fps = newest.fps;
  out.width = newest.width;
  out.height = newest.height;
  out.format = newest.format;
  out.progress_ns = newest.progress_ns;
  out.times = newest.times;
  out.warnings = opening.warnings;
  return out;
}

void CameraThread::Shared::run() {
  if (wait_for_start()) {
    apply(parts.settings, parts.name);
    keep_open();
    logs.damages.write();
    logs.strange_times.write();
    const std::lock_guard lock(mutex);
    lifecycle.finished = true;
  }
  changed.notify_all();
}

/// Waits for start(). False if a stop was requested instead.
bool CameraThread::Shared::wait_for_start() {
  std::unique_ptr<CameraThread> before;
  {
    std::unique_lock lock(mutex);
    changed.wait(lock, [&] { return lifecycle.started || stopping(); });
    lifecycle.finished = !lifecycle.started;
    if (lifecycle.finished) return false;
    before = std::move(lifecycle.predecessor);
  }
  if (before) {
    before->ask_to_stop();
    before->shared_->calls.silence();
    calls.end_predecessor();
    before.reset();
  }
  return true;
}

void CameraThread::Shared::keep_open() {
  while (!stopping()) {
    const std::int64_t began_ns = steady_ns();
    milliseconds tried_for{0};
    if (std::unique_ptr<Source> source = try_open()) {
      const CaptureStatus end = serve(*source);
      buffers_are_out();
      forget_controls();
      close_aside(std::move(source));
      if (end == CaptureStatus::kEnd) return;
    } else {
      buffers_are_out();
      tried_for = milliseconds((steady_ns() - began_ns) / 1'000'000);
    }
    std::unique_lock lock(mutex);
    changed.wait_for(lock, std::max(parts.delays.first, delay - tried_for),
                     [&] { return stopping() || try_asked; });
    delay = std::exchange(try_asked, false) ? parts.delays.first : std::min(2 * delay, parts.delays.longest);
  }
}

std::unique_ptr<Source> CameraThread::Shared::try_open() {
  now.progress_ns = steady_ns();
  figures.store(now);
  try {
    std::unique_ptr<Source> source = parts.open();
    if (!source) throw CaptureError("the driver opened no source");
    std::vector<std::string> new_warnings = source->warnings();
    if (!stopping()) {
      logs.losses.opened();
      for (const std::string& warning : new_warnings) log::warning("{}: {}", parts.name, warning);
    }
    const std::lock_guard lock(mutex);
    opening.controls = source->controls();
    opening.warnings = std::move(new_warnings);
    opening.why_lost.clear();
    try_asked = false;
    if (std::exchange(was_open, true)) {
      ++now.reconnects;
      parts.totals->reconnects.fetch_add(1, std::memory_order_relaxed);
    }
    now.progress_ns = steady_ns();  // opening may have taken long
    now.state = CameraState::kRunning;
    figures.store(now);
    return source;
  } catch (const std::exception& caught) {
    mark_lost(caught.what());
  } catch (...) {
    mark_lost("unknown error");
  }
  return nullptr;
}

/// Delivers images until the camera is lost, the recording has ended or a stop was requested.
CaptureStatus CameraThread::Shared::serve(Source& source) {
  std::int64_t window_start_ns = steady_ns();
  int window_frames = 0, damaged_in_a_row = 0;
  milliseconds patience = kPollTimeout;
  const std::uint64_t dropped_before = now.dropped;
  const PacketCounts packets_before = now.packets.value_or(PacketCounts{});
  for (;;) {
    CapturedImage image;
    std::string problem;
    const CaptureStatus status = poll_once(source, image, problem, patience);
    if (status == CaptureStatus::kImage) check_times(image.times);
    const ImageView view = image.image.view();
    const bool is_damaged = image.is_damaged;
    const CaptureTimes times = image.times;
    bool delivered = false;
    patience = kPollTimeout;
    if (status == CaptureStatus::kImage) {
      image.times.arrived_ns = steady_ns();
      delivered = calls.pass([&] { parts.on_image(std::move(image)); });
      window_frames += delivered;
      delay = parts.delays.first;
    } else {
      if (status == CaptureStatus::kLost) mark_lost(problem);
      if (status == CaptureStatus::kIncomplete) logs.damages.add(problem);
      if (buffers_are_out()) patience = kShortTurn;
    }
    logs.damages.write_if_due();
    logs.strange_times.write_if_due();
    damaged_in_a_row = status == CaptureStatus::kIncomplete ? damaged_in_a_row + 1 : 0;
    if (damaged_in_a_row > kStorm) std::this_thread::sleep_for(kStormPause);

    const std::int64_t now_ns = steady_ns();
    now.progress_ns = now_ns;
    if (delivered) {
      ++now.frames;
      now.width = view.width;
      now.height = view.height;
      now.format = view.format;
      now.times = times;
    }
    const bool is_incomplete = status == CaptureStatus::kIncomplete || is_damaged;
    now.incomplete += is_incomplete;
    parts.totals->incomplete.fetch_add(is_incomplete, std::memory_order_relaxed);
    const std::uint64_t dropped = dropped_before + source.dropped();
    parts.totals->dropped.fetch_add(dropped - now.dropped, std::memory_order_relaxed);
    now.dropped = dropped;
    if (const auto packets = source.packets())
      now.packets = {packets_before.missing + packets->missing, packets_before.resent + packets->resent};
    if (now_ns - window_start_ns >= kSecondNs) {
      now.fps = window_frames * 1e9 / static_cast<double>(now_ns - window_start_ns);
      window_start_ns = now_ns;
      window_frames = 0;
    }
    if (status == CaptureStatus::kEnd) now.state = CameraState::kEnded;
    const bool is_over = status == CaptureStatus::kEnd || status == CaptureStatus::kLost;
    if (is_over) now.fps = 0;
    figures.store(now);
    if (is_over || stopping()) return status;
  }
}

CaptureStatus CameraThread::Shared::poll_once(Source& source, CapturedImage& image, std::string& problem,
                                              milliseconds patience) {
  try {
    const CaptureStatus status = source.next(image, problem, patience);
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
  if (!sanitize_times(times, now_s)) return;
  std::string problem = fmt::format("{:.3f} s, but the clock says {:.3f} s", given_s, now_s);
  logs.strange_times.add(problem);
}

/// Asks on_idle to release buffers; returns whether some are still held.
bool CameraThread::Shared::buffers_are_out() {
  bool some_are_out = false;
  if (parts.on_idle) calls.pass([&] { some_are_out = parts.on_idle(); });
  return some_are_out;
}

void CameraThread::Shared::forget_controls() {
  const std::lock_guard lock(mutex);
  opening.controls.reset();
}

void CameraThread::Shared::mark_lost(const std::string& reason) {
  if (!stopping()) logs.losses.lost(reason);
  const std::lock_guard lock(mutex);
  opening.why_lost = reason;
  now.state = CameraState::kLost;
  figures.store(now);
}

void CameraThread::Shared::ask_to_stop() {
  {
    const std::lock_guard lock(mutex);
    if (stop_asked.exchange(true)) return;
    lifecycle.stop_asked_at = std::chrono::steady_clock::now();
  }
  changed.notify_all();
}

CameraState CameraThread::Shared::try_now() {
  CameraState state;
  {
    const std::lock_guard lock(mutex);
    state = figures.load().state;
    try_asked = try_asked || state == CameraState::kLost;
  }
  changed.notify_all();
  return state;
}

void CameraThread::Shared::close_aside(std::unique_ptr<Source> source) {
  {
    const std::lock_guard lock(mutex);
    ++lifecycle.closing;
  }
  const auto closed = [](Shared& shared) {
    {
      const std::lock_guard lock(shared.mutex);
      --shared.lifecycle.closing;
    }
    shared.changed.notify_all();
  };
  try {
    std::thread([shared = shared_from_this(), dead = std::move(source), closed,
                 left = std::make_unique<LeftBehind>()]() mutable {
      dead.reset();
      closed(*shared);
    }).detach();
  } catch (const std::system_error&) {  // no thread: the lambda's destructor has closed the source
    closed(*this);
  }
}

CameraThread::CameraThread(std::string name, const ThreadSettings& settings, Open open, OnImage on_image,
                           CameraDelays delays, std::shared_ptr<CaptureTotals> totals, OnIdle on_idle)
    : shared_(std::make_shared<Shared>(Shared::Parts{std::move(name), settings, std::move(open),
                                                     std::move(on_image), std::move(on_idle), delays,
                                                     std::move(totals)})),
      thread_([shared = shared_, may_stay = std::make_unique<LeftBehind>()] { shared->run(); }) {}

CameraThread::~CameraThread() {
  stop();
}

void CameraThread::start(std::unique_ptr<CameraThread> predecessor) noexcept {
  {
    const std::lock_guard lock(shared_->mutex);
    if (shared_->lifecycle.started || shared_->lifecycle.finished)
      return;  // the destructor of the argument stops the predecessor
    shared_->lifecycle.started = true;
    shared_->lifecycle.predecessor = std::move(predecessor);
    if (shared_->lifecycle.predecessor) shared_->calls.begin_predecessor();
  }
  shared_->changed.notify_all();
}

void CameraThread::ask_to_stop() {
  shared_->ask_to_stop();
}

void CameraThread::stop() {
  if (!thread_.joinable()) return;
  ask_to_stop();
  shared_->calls.silence();
  std::unique_lock lock(shared_->mutex);
  const auto idle = [&] { return shared_->lifecycle.finished && shared_->lifecycle.closing == 0; };
  if (!shared_->changed.wait_until(lock, shared_->lifecycle.stop_asked_at + shared_->parts.delays.stop,
                                   idle)) {
    log::warning("{}: does not answer; it closes in the background", shared_->parts.name);
  }
  const bool finished = shared_->lifecycle.finished;
  lock.unlock();
  finished ? thread_.join() : thread_.detach();
}

bool CameraThread::try_stop() {
  if (!thread_.joinable()) return true;
  {
    const std::lock_guard lock(shared_->mutex);
    const bool has_ended = shared_->lifecycle.finished && shared_->lifecycle.closing == 0;
    const auto left_behind_at = shared_->lifecycle.stop_asked_at + shared_->parts.delays.stop;
    if (!has_ended && (!shared_->stopping() || std::chrono::steady_clock::now() < left_behind_at))
      return false;
  }
  if (!shared_->calls.try_silence()) return false;
  stop();
  return true;
}

CameraState CameraThread::try_now() {
  return shared_->try_now();
}

CameraHealth CameraThread::health() const {
  return shared_->health_now();
}

std::shared_ptr<Controls> CameraThread::controls() const {
  const std::lock_guard lock(shared_->mutex);
  return shared_->opening.controls;
}

}  // namespace sslv
