// SPDX-License-Identifier: Apache-2.0
#include "gpu/gpu_worker.h"

#include "base/background.h"
#include "base/futex.h"
#include "gpu/gpu_context.h"
#include "gpu/rows_there.h"
#include "gpu/threshold_shaders.h"

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstring>
#include <exception>
#include <limits>
#include <utility>
#include <vector>

#include <pthread.h>
#include <time.h>

namespace sslv {
namespace {

using WorkerClock = GpuWorker::Clock;

/// State of the request. Only the camera's thread may access the request in kIdle and kDone, and only the
/// worker's thread in the other states.
enum class Turn : std::uint8_t {
  kClosed,   // no GPU is open
  kIdle,     // waits for a request
  kPrepare,  // preparation requested
  kAsked,    // labels requested
  kLate,     // labels requested, but the camera's thread no longer waits for them
  kDone,     // labels ready
};

/// The device's problem as a text that is never empty.
std::string problem_of(const ThresholdDevice& device) {
  return device.problem().empty() ? "there are no labels" : device.problem();
}

std::chrono::nanoseconds this_threads_cpu_time() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return std::chrono::seconds(time.tv_sec) + std::chrono::nanoseconds(time.tv_nsec);
}

void copy_rows_to(std::uint8_t* out, std::ptrdiff_t out_stride, const ImageView& image, RowsThere& there) {
  const std::size_t row_bytes =
      static_cast<std::size_t>(image.width) * static_cast<std::size_t>(bytes_per_pixel(image.format));
  // A band is large enough to keep the other thread busy, and small enough that the other thread does not
  // wait.
  constexpr std::ptrdiff_t kBandBytes = 64 << 10;
  const int band = static_cast<int>(std::max<std::ptrdiff_t>(1, kBandBytes / out_stride));
  for (int begin = 0; begin < image.height; begin += band) {
    const int end = std::min(image.height, begin + band);
    for (int y = begin; y < end; ++y, out += out_stride) std::memcpy(out, image.row(y), row_bytes);
    there.set(end);
  }
}

}  // namespace

/// State shared by both threads, freed by the last thread.
struct GpuWorker::Shared {
  Shared(OpenDevice open_device, const Limits& its_limits)
      : open(std::move(open_device)), limits(its_limits) {}

  const OpenDevice open;
  const Limits limits;
  Handover<Status> status{Status{}};
  std::atomic<Turn> turn{Turn::kClosed};
  std::atomic<bool> is_ending{false}, has_ended{false};
  Bell to_worker, to_camera;

  /// `turn` selects the thread that may access the request.
  struct Request {
    Work work;                          // prepared work, or work to prepare
    Work unfit;                         // work that could not be prepared
    std::vector<std::uint8_t> image{};  // rows in the GPU's layout
    std::ptrdiff_t stride_bytes = 0;
    RowsThere rows{};  // available rows of the image
    std::vector<Label> table{};
    TableView table_view{};
    LabelImage labels{};
    std::chrono::nanoseconds cpu_time{};
  } request;

  void serve() noexcept;

 private:
  std::unique_ptr<ThresholdDevice> open_beside() const;
  std::string work_with(ThresholdDevice& device);
  std::string prepare(ThresholdDevice& device);
  std::string make_labels(ThresholdDevice& device);
  void tell(Status next) noexcept;
  void sleep(std::chrono::nanoseconds wait) const noexcept;

  ImageView copy_of_image() const {
    return {request.image.data(), request.work.width, request.work.height, request.stride_bytes,
            request.work.format};
  }

  int told_ = 0;
};

// ---- the worker's thread

void GpuWorker::Shared::serve() noexcept {
  pthread_setname_np(pthread_self(), "gpu threshold");
  Status gone;  // status of the GPU opened last
  for (auto wait = limits.shortest_wait; !is_ending; wait = std::min(2 * wait, limits.longest_wait)) {
    const auto tell_why = [&](std::string problem) {
      turn = Turn::kClosed;
      gone.kind = gone.name.empty() ? Status::Kind::kNoGpu : Status::Kind::kLost;
      gone.problem = std::move(problem);
      gone.wait = wait;
      tell(gone);
    };
    try {
      const auto device = open_beside();
      const auto begun = WorkerClock::now();
      gone.name = device->name();
      gone.is_software = device->is_software();
      std::string problem = work_with(*device);
      if (is_ending) return;
      if (WorkerClock::now() - begun >= limits.sound_after) wait = limits.shortest_wait;
      // Report before closing the device, which may take long or hang.
      tell_why(std::move(problem));
    } catch (const std::exception& error) {
      tell_why(error.what());
    }
    sleep(wait);
  }
}

/// Opens the device in a thread of normal priority, because the driver's own threads inherit the priority and
/// must not compete with the camera's thread.
std::unique_ptr<ThresholdDevice> GpuWorker::Shared::open_beside() const {
  std::unique_ptr<ThresholdDevice> device;
  std::exception_ptr problem;
  std::thread([&] {
    become_background_thread("gpu open", 0);
    try {
      device = open();
    } catch (...) {
      problem = std::current_exception();
    }
  }).join();
  if (problem) std::rethrow_exception(problem);
  return device;
}

/// Serves requests until the worker ends or the device fails. Returns why the device failed; empty if the
/// worker ends.
std::string GpuWorker::Shared::work_with(ThresholdDevice& device) {
  request.work = request.unfit = Work{};
  turn = Turn::kIdle;
  while (!is_ending) {
    const std::uint32_t mark = to_worker.mark();
    std::string problem;
    switch (turn.load()) {
      case Turn::kPrepare: problem = prepare(device); break;
      case Turn::kAsked: problem = make_labels(device); break;
      case Turn::kLate: turn = Turn::kIdle; break;  // given up before it was started
      default:
        if (!is_ending) to_worker.wait(mark, WorkerClock::now() + std::chrono::hours(1));
    }
    if (!problem.empty()) return problem;
  }
  return {};
}

/// Allocates memory, builds the shader, and triggers everything that a driver defers to the first image.
/// Returns why the device failed; otherwise empty. Work that the device does not support is reported in the
/// status.
std::string GpuWorker::Shared::prepare(ThresholdDevice& device) {
  const Work& work = request.work;
  const int cell_px = is_bayer(work.format) ? 2 : 1;
  const int groups = (work.width / cell_px + kCellsAGroup - 1) / kCellsAGroup;
  request.stride_bytes = std::ptrdiff_t{groups} * texels_a_group(work.format) * kTexelBytes;
  request.image.assign(static_cast<std::size_t>(request.stride_bytes) * static_cast<std::size_t>(work.height),
                       0);
  request.table.assign(std::size_t{1} << (3 * work.table_bits), label::kClear);
  request.table_view = {
      .lut_id = std::numeric_limits<std::uint64_t>::max() - static_cast<std::uint64_t>(work.table_bits),
      .is_rgb = false,
      .bits = work.table_bits,
      .labels = request.table};
  request.rows.set(work.height);
  // By the second call, everything is prepared.
  bool is_made = true;
  for (int i = 0; i < 2 && is_made; ++i)
    is_made = device.process(request.table_view, copy_of_image(), request.rows, request.labels);
  if (!is_made && device.is_lost()) return problem_of(device);
  Status now;
  now.kind = is_made ? Status::Kind::kOpen : Status::Kind::kUnfit;
  now.name = device.name();
  now.is_software = device.is_software();
  if (!is_made) {
    now.problem = problem_of(device);
    request.unfit = std::exchange(request.work, Work{});
  }
  tell(std::move(now));
  turn = Turn::kIdle;
  return {};
}

/// Returns why the device failed; otherwise empty.
std::string GpuWorker::Shared::make_labels(ThresholdDevice& device) {
  const auto begun = WorkerClock::now();
  const auto cpu_begun = this_threads_cpu_time();
  const bool is_made = device.process(request.table_view, copy_of_image(), request.rows, request.labels);
  request.cpu_time = this_threads_cpu_time() - cpu_begun;
  Turn now = Turn::kAsked;
  const bool in_time = turn.compare_exchange_strong(now, is_made ? Turn::kDone : Turn::kClosed);
  to_camera.ring();
  if (!is_made) return problem_of(device);
  if (in_time) return {};
  const std::chrono::duration<double> took = WorkerClock::now() - begun;
  if (took > limits.hangs_after)
    return "it did not answer for " + std::to_string(took.count()).substr(0, 4) + " s";
  turn = Turn::kIdle;
  return {};
}

void GpuWorker::Shared::tell(Status next) noexcept {
  next.number = ++told_;
  status.store(std::move(next));
}

void GpuWorker::Shared::sleep(std::chrono::nanoseconds wait) const noexcept {
  const auto until = WorkerClock::now() + wait;
  for (std::uint32_t mark = to_worker.mark(); !is_ending && WorkerClock::now() < until;
       mark = to_worker.mark()) {
    if (!is_ending) to_worker.wait(mark, until);
  }
}

// ---- the camera's thread

GpuWorker::Work GpuWorker::work_for(const Lut& lut, const ImageView& image) {
  return {image.format, image.width, image.height, lut.yuv().bits};
}

GpuWorker::GpuWorker(OpenDevice open, const Limits& limits)
    : shared_(std::make_shared<Shared>(std::move(open), limits)), thread_([shared = shared_] {
        shared->serve();
        shared->has_ended = true;
        shared->to_camera.ring();
      }) {}

GpuWorker::~GpuWorker() {
  shared_->is_ending = true;
  shared_->to_worker.ring();
  const auto until = Clock::now() + shared_->limits.longest_end;
  for (std::uint32_t mark = shared_->to_camera.mark(); !shared_->has_ended && Clock::now() < until;
       mark = shared_->to_camera.mark()) {
    if (!shared_->has_ended) shared_->to_camera.wait(mark, until);
  }
  if (shared_->has_ended)
    thread_.join();
  else
    thread_.detach();
}

bool GpuWorker::takes(const Work& work) noexcept {
  Shared& shared = *shared_;
  if (shared.turn.load() != Turn::kIdle) return false;
  if (shared.request.work == work) return true;
  if (shared.request.unfit == work) return false;
  shared.request.work = work;
  shared.turn = Turn::kPrepare;
  shared.to_worker.ring();
  return false;
}

GpuWorker::Answer GpuWorker::label(const Lut& lut, const ImageView& image, LabelImage& labels,
                                   Clock::time_point until) noexcept {
  Shared& shared = *shared_;
  Shared::Request& request = shared.request;
  const TableView table = table_for(lut, image.format);
  if (request.table_view.lut_id != table.lut_id || request.table_view.is_rgb != table.is_rgb) {
    std::copy(table.labels.begin(), table.labels.end(), request.table.begin());
    request.table_view = table;
    request.table_view.labels = request.table;
  }
  // The worker wakes up and copies the available rows while this thread is still copying.
  request.rows.set(0);
  shared.turn = Turn::kAsked;
  shared.to_worker.ring();
  copy_rows_to(request.image.data(), request.stride_bytes, image, request.rows);
  for (;;) {
    const std::uint32_t mark = shared.to_camera.mark();
    Turn now = shared.turn.load();
    if (now == Turn::kAsked && Clock::now() >= until &&
        shared.turn.compare_exchange_strong(now, Turn::kLate)) {
      late_since_ = Clock::now();
      return Answer::kLate;
    }
    if (now == Turn::kDone) break;
    if (now != Turn::kAsked) return Answer::kNone;
    shared.to_camera.wait(mark, until);
  }
  std::swap(labels, request.labels);
  cpu_time_ = request.cpu_time;
  shared.turn = Turn::kIdle;
  return Answer::kLabels;
}

bool GpuWorker::hangs() const noexcept {
  return shared_->turn.load() == Turn::kLate && Clock::now() - late_since_ > shared_->limits.hangs_after;
}

Handover<GpuWorker::Status>::Use GpuWorker::status() noexcept {
  return shared_->status.use();
}

}  // namespace sslv
