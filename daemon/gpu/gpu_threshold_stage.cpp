// SPDX-License-Identifier: Apache-2.0
#include "gpu/gpu_threshold_stage.h"

#include <algorithm>
#include <exception>
#include <string_view>
#include <utility>

#include <fmt/format.h>
#include <time.h>

namespace sslv {
namespace {

using StageClock = std::chrono::steady_clock;
using Milliseconds = std::chrono::duration<double, std::milli>;

/// Elapsed time and the calling thread's processor time since construction.
class Stopwatch {
 public:
  LabelCost cost() const { return {StageClock::now() - begun_, cpu_now() - cpu_begun_}; }
  StageClock::time_point begun() const { return begun_; }

 private:
  static std::chrono::nanoseconds cpu_now() {
    timespec time{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
    return std::chrono::seconds(time.tv_sec) + std::chrono::nanoseconds(time.tv_nsec);
  }
  StageClock::time_point begun_ = StageClock::now();
  std::chrono::nanoseconds cpu_begun_ = cpu_now();
};

/// A note's text, formatted without allocating.
class NoteText {
 public:
  template <class... Args>
  explicit NoteText(fmt::format_string<Args...> format, Args&&... args) {
    end_ = fmt::format_to_n(text_.data(), text_.size(), format, std::forward<Args>(args)...).out;
  }
  operator std::string_view() const { return {text_.data(), static_cast<std::size_t>(end_ - text_.data())}; }

 private:
  std::array<char, StageNotes::kMaxText> text_;
  char* end_ = nullptr;
};

}  // namespace

GpuThresholdStage::GpuThresholdStage(OpenDevice open, const Limits& limits)
    : open_(std::move(open)), limits_(limits) {}

void GpuThresholdStage::process(const Params& params, const Lut& lut, const Mask& mask, const Image& image,
                                LabelImage& labels, StageNotes& notes) noexcept {
  const Stopwatch watch;
  was_on_gpu_ = false;
  const ImageView& view = image.view();
  if (!start(params.use) || view.width == 0 || view.height == 0) {
    cpu_.process({}, lut, mask, image, labels);
    tell({worker_ == nullptr && params.use != Use::kNever ? Told::Kind::kNoThread : Told::Kind::kNever,
          params.use, 0},
         {}, notes);
    return;
  }
  const bool is_ready = worker_->takes(GpuWorker::work_for(lut, view));
  // If is_ready, this is the open GPU's status, which the worker does not change while it waits for a
  // request.
  const auto status = worker_->status();
  if (is_ready && std::exchange(measured_status_, status->number) != status->number) choice_.begin();
  const bool may_use = is_ready && (params.use == Use::kAlways || !status->is_software);
  const bool by_gpu = may_use && choice_.gpu_is_next(params.use == Use::kAlways);
  if (by_gpu) was_on_gpu_ = label_on_gpu(lut, mask, view, labels);
  if (!was_on_gpu_) cpu_.process({}, lut, mask, image, labels);
  if (may_use) {
    LabelCost cost = watch.cost();
    if (was_on_gpu_) cost.cpu_time += worker_->cpu_time();
    choice_.took(by_gpu, cost, watch.begun());
  }
  tell(hangs(*status, is_ready, watch.begun()) ? Told{Told::Kind::kHangs, params.use, status->number}
                                               : told_now(params.use, *status, is_ready),
       *status, notes);
}

/// Whether a worker exists; creates it if needed.
bool GpuThresholdStage::start(Use use) {
  if (use == Use::kNever) return false;
  if (worker_ != nullptr || has_no_thread_) return worker_ != nullptr;
  try {
    worker_ = std::make_unique<GpuWorker>(open_, limits_.worker);
  } catch (const std::exception&) {  // the system provides no more threads
    has_no_thread_ = true;
  }
  return worker_ != nullptr;
}

/// False if the labels were not ready in time.
bool GpuThresholdStage::label_on_gpu(const Lut& lut, const Mask& mask, const ImageView& image,
                                     LabelImage& labels) {
  const auto deadline = std::max(limits_.shortest_deadline, 2 * choice_.cpu_time_so_far());
  if (worker_->label(lut, image, labels, StageClock::now() + deadline) != GpuWorker::Answer::kLabels)
    return false;
  clear_masked(mask, labels);
  return true;
}

/// Whether the worker hangs, with an image or while opening.
bool GpuThresholdStage::hangs(const GpuWorker::Status& status, bool is_ready, StageClock::time_point now) {
  using Kind = GpuWorker::Status::Kind;
  const bool is_opening = !is_ready && (status.kind == Kind::kOpening || status.kind == Kind::kOpen);
  if (!is_opening)
    opening_since_ = {};
  else if (opening_since_ == StageClock::time_point())
    opening_since_ = now;
  return worker_->hangs() || (is_opening && now - opening_since_ > limits_.longest_opening);
}

GpuThresholdStage::Told GpuThresholdStage::told_now(Use use, const GpuWorker::Status& status,
                                                    bool is_ready) const {
  if (is_ready && status.is_software && use == Use::kWhenFaster)
    return {Told::Kind::kSoftware, use, status.number};
  if (is_ready && choice_.measured()) return {Told::Kind::kMeasured, use, choice_.number()};
  if (is_ready) return {Told::Kind::kMeasuring, use, status.number};
  // The GPU is preparing for other images or is late with an image. Keep the note: a long delay will be
  // reported.
  if (status.kind == GpuWorker::Status::Kind::kOpen) return told_;
  return {Told::Kind::kStatus, use, status.number};
}

void GpuThresholdStage::tell(const Told& now, const GpuWorker::Status& status, StageNotes& notes) {
  if (std::exchange(told_, now) == now) return;
  const bool is_wanted = now.use == Use::kAlways;
  const auto say = [&notes](bool is_warning, std::string_view text) {
    is_warning ? notes.warn(text) : notes.say(text);
  };
  switch (now.kind) {
    case Told::Kind::kNothing: break;
    case Told::Kind::kNever: say(false, "The CPU labels all images, as configured."); break;
    case Told::Kind::kNoThread: say(true, "No thread for the GPU is available: the CPU labels."); break;
    case Told::Kind::kHangs:
      say(true, NoteText("GPU ({}) does not answer: the CPU labels until it does.",
                         status.name.empty() ? "being opened" : status.name));
      break;
    case Told::Kind::kSoftware:
      say(false, NoteText("GPU ({}) is a software renderer: it is not used.", status.name));
      break;
    case Told::Kind::kMeasuring: say(false, NoteText("GPU ({}): it is being measured.", status.name)); break;
    case Told::Kind::kMeasured: {
      const auto& [gpu, cpu] = *choice_.measured();
      const auto ms = [](std::chrono::nanoseconds time) { return Milliseconds(time).count(); };
      const bool uses_gpu = is_wanted || choice_.measured()->gpu_is_faster();
      say(false, NoteText("GPU ({}): {:.2f} ms an image ({:.2f} ms of processor time); CPU: {:.2f} ms: the "
                          "{} is used{}.",
                          status.name, ms(gpu.time), ms(gpu.cpu_time), ms(cpu.time), uses_gpu ? "GPU" : "CPU",
                          is_wanted ? ", as configured" : ""));
      break;
    }
    case Told::Kind::kStatus: say_status(status, is_wanted, notes); break;
  }
}

void GpuThresholdStage::say_status(const GpuWorker::Status& status, bool is_wanted, StageNotes& notes) {
  const double wait_s = std::chrono::duration<double>(status.wait).count();
  switch (status.kind) {
    case GpuWorker::Status::Kind::kOpening:
      notes.say("The GPU is being opened: the CPU labels until then.");
      break;
    case GpuWorker::Status::Kind::kOpen: break;
    case GpuWorker::Status::Kind::kNoGpu: {
      // Warn only if the admin requires a GPU.
      const NoteText text("Labelling on the CPU: {:.160}; next try in {:.0f} s.", status.problem, wait_s);
      is_wanted ? notes.warn(text) : notes.say(text);
      break;
    }
    case GpuWorker::Status::Kind::kUnfit: {
      const NoteText text("GPU ({:.60}) is not used: {:.120}.", status.name, status.problem);
      is_wanted ? notes.warn(text) : notes.say(text);
      break;
    }
    case GpuWorker::Status::Kind::kLost:
      notes.warn(NoteText("GPU ({:.60}) is lost: {:.100}; labelling on the CPU, next try in {:.0f} s.",
                          status.name, status.problem, wait_s));
      break;
  }
}

}  // namespace sslv
