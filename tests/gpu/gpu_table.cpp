// SPDX-License-Identifier: Apache-2.0
// Colour thresholding on this computer's GPU compared with one core of its CPU, alternating, on drawn halls;
// and the total cost of the stage that does it. Prints two Markdown tables. Exit code 1: a label differs; 77:
// no GPU.
//   gpu_table [--runs 50]

#include "camera_bytes.h"
#include "draw.h"
#include "gpu/gpu_context.h"
#include "gpu/gpu_threshold.h"
#include "gpu/gpu_threshold_stage.h"
#include "gpu/gpu_worker.h"
#include "hall.h"
#include "play.h"
#include "vision/find_regions.h"
#include "vision/find_runs.h"
#include "vision/segment.h"
#include "vision/threshold.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdlib>
#include <memory>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include <fmt/format.h>
#include <time.h>

namespace sslv::halls {
namespace {

using Clock = std::chrono::steady_clock;

struct Shown {
  int width, height;
  Size hall;  // a usual hall with its camera scaled to that size
};
constexpr std::array kShown{Shown{640, 480, Size::kA}, Shown{780, 580, Size::kA}, Shown{1280, 1024, Size::kB},
                            Shown{2448, 2048, Size::kC}};
constexpr std::array kFormats{PixelFormat::kUyvy, PixelFormat::kRgb24, PixelFormat::kBayerRg8};

/// Hues of the league's colours, as in config/demo.json.
std::shared_ptr<const Lut> league_lut() {
  ColorSettings colors;
  colors.classes = {{"orange", {60, 255}, {108, 147}, {34, 1000}},
                    {"yellow", {80, 255}, {148, 185}, {26, 1000}},
                    {"blue", {40, 255}, {308, 350}, {42, 1000}},
                    {"pink", {60, 255}, {40, 107}, {30, 1000}},
                    {"green", {80, 255}, {190, 230}, {28, 1000}}};
  return make_lut(colors, "");
}

/// The light on the sensor, and the sensor.
struct Exposed {
  Picture light;
  Sensor sensor;
};

Exposed expose(const Shown& shown) {
  HallOptions options;
  options.size = shown.hall;
  Hall hall = make_hall(options);
  CameraCalibration& camera = hall.calibration;
  const double scale = std::min(static_cast<double>(shown.width) / camera.pixel_image_width,
                                static_cast<double>(shown.height) / camera.pixel_image_height);
  camera.focal_length *= scale;
  camera.principal_point_x *= scale;
  camera.principal_point_y *= scale;
  camera.pixel_image_width = shown.width;
  camera.pixel_image_height = shown.height;
  hall.sensor.hot_pixels.clear();  // their positions are for the other size
  const CameraModel model(camera);
  Painter painter(hall, model);
  const Obstacles obstacles(model, painter.obstacles());
  const Game game(hall, model, obstacles, {});
  return {painter.frame(game.at(1), 1, 1), hall.sensor};
}

double ms(Clock::duration duration) {
  return std::chrono::duration<double, std::milli>(duration).count();
}

double median(std::vector<double>& all) {
  const auto middle = all.begin() + static_cast<std::ptrdiff_t>(all.size() / 2);
  std::nth_element(all.begin(), middle, all.end());
  return *middle;
}

double cpu_ms(clockid_t clock) {
  timespec time{};
  clock_gettime(clock, &time);
  return 1e3 * static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_nsec);
}

/// Durations and CPU times of a repeated operation, in ms.
struct Times {
  std::vector<double> time{}, this_thread{}, all_threads{};
  template <class Do>
  void add(const Do& act) {
    const auto before = Clock::now();
    const double thread = cpu_ms(CLOCK_THREAD_CPUTIME_ID), process = cpu_ms(CLOCK_PROCESS_CPUTIME_ID);
    act();
    time.push_back(ms(Clock::now() - before));
    this_thread.push_back(cpu_ms(CLOCK_THREAD_CPUTIME_ID) - thread);
    all_threads.push_back(cpu_ms(CLOCK_PROCESS_CPUTIME_ID) - process);
  }
};

/// Times of the GPU, and whether its labels equal the CPU's.
struct Timed {
  explicit Timed(GpuContext& context) : gpu(context) {}
  GpuThreshold gpu;
  std::vector<double> upload_ms{}, shader_ms{}, read_back_ms{}, all_ms{};
  std::string problem{};

  void run(const Lut& lut, const Image& image, const LabelImage& wanted, bool counts) {
    LabelImage& labels = labels_;
    const auto before = Clock::now();
    const bool is_made = gpu.process(lut, mask_, image, labels);
    const double took = ms(Clock::now() - before);
    check(is_made, wanted);
    GpuThreshold::Steps steps{};
    check(gpu.process(lut, mask_, image, labels, &steps), wanted);
    if (!counts) return;
    all_ms.push_back(took);
    upload_ms.push_back(ms(steps.upload));
    shader_ms.push_back(ms(steps.shader));
    read_back_ms.push_back(ms(steps.read_back));
  }

 private:
  void check(bool is_made, const LabelImage& wanted) {
    if (!is_made) problem = gpu.problem();
    if (is_made && labels_.labels != wanted.labels) problem = "labels differ";
    // Overwrites the labels, so that they cannot count as those of the next run.
    std::fill(labels_.labels.begin(), labels_.labels.end(), Label{255});
  }
  Mask mask_;
  LabelImage labels_;
};

std::vector<std::uint8_t> bytes_of(const Exposed& exposed, PixelFormat format) {
  return camera_bytes(exposed.light, exposed.sensor, format, Chance(1, "noise", 1));
}

Image image_of(const std::vector<std::uint8_t>& bytes, const Exposed& exposed, PixelFormat format) {
  const int width = exposed.light.width, height = exposed.light.height;
  return {ImageView{bytes.data(), width, height, width * bytes_per_pixel(format), format}, nullptr, nullptr,
          nullptr};
}

/// Compares the stage, always on the GPU, and the stages after it with the CPU's stages. Returns false if a
/// label differs or the GPU did not make them.
bool stage_row(const Lut& lut, const Exposed& exposed, PixelFormat format, int runs, std::string& note) {
  const std::vector<std::uint8_t> bytes = bytes_of(exposed, format);
  const Image image = image_of(bytes, exposed, format);
  const Mask mask;
  GpuThresholdStage::Limits patient;  // a table should include slow GPUs
  patient.shortest_deadline = std::chrono::seconds(1);
  GpuThresholdStage stage(&open_gpu, patient);
  StageNotes notes;
  LabelImage labels, wanted;
  RunList gpu_runs, cpu_runs, segment_runs;
  RegionList regions;
  Threshold threshold;
  FindRuns find_runs;
  FindRegions find_regions;
  Segment segment;
  const auto label_on_gpu = [&] {
    stage.process({.use = GpuThresholdStage::Use::kAlways}, lut, mask, image, labels, notes);
  };
  constexpr int kMaxToBegin = 100'000;
  for (int i = 0; i < kMaxToBegin && notes.read().text.find(" ms an image") == std::string::npos; ++i)
    label_on_gpu();
  note = notes.read().text;

  Times gpu, follow, cpu, whole;
  bool is_good = true;
  for (int i = 0; i < runs; ++i) {
    gpu.add(label_on_gpu);
    is_good = is_good && stage.was_on_gpu();
    follow.add([&] {
      find_runs.process({}, labels, gpu_runs);
      find_regions.process({}, gpu_runs, regions);
    });
    cpu.add([&] { threshold.process({}, lut, mask, image, wanted); });
    is_good = is_good && labels.labels == wanted.labels;
    whole.add([&] { segment.process({}, lut, mask, image, segment_runs, regions); });
  }
  fmt::print("| {}x{} | {} | {:.2f} | {:.2f} | {:.2f} | {:.2f} | {:.2f} | {:.2f} | {} |\n",
             image.view().width, image.view().height, name_of(format), median(gpu.time),
             median(gpu.this_thread), median(gpu.all_threads), median(cpu.time), median(follow.time),
             median(whole.time), is_good ? "identical" : "differ, or not the GPU's");
  return is_good;
}

/// A GPU that needs no time.
class NoWork final : public ThresholdDevice {
 public:
  const std::string& name() const override { return name_; }
  bool is_software() const override { return false; }
  bool process(const TableView&, const ImageView&, const RowsThere&, LabelImage&) noexcept override {
    return true;
  }
  const std::string& problem() const override { return name_; }
  bool is_lost() const override { return false; }

 private:
  const std::string name_ = "none";
};

/// Time in ms to hand work to another thread and wait for it, with `pause` between the repetitions.
double hand_over_ms(const Lut& lut, int times, std::chrono::microseconds pause) {
  GpuWorker worker([] { return std::make_unique<NoWork>(); });
  const std::array<std::uint8_t, 32> grey{};
  const ImageView image{grey.data(), 16, 2, 16, PixelFormat::kMono8};
  LabelImage labels;
  while (!worker.takes(GpuWorker::work_for(lut, image))) std::this_thread::yield();
  worker.label(lut, image, labels, Clock::now() + std::chrono::minutes(1));  // transfers the table
  Times all;
  for (int i = 0; i < times; ++i) {
    if (pause.count() > 0) std::this_thread::sleep_for(pause);
    all.add([&] { worker.label(lut, image, labels, Clock::now() + std::chrono::minutes(1)); });
  }
  return median(all.time);
}

bool stage_table(const Lut& lut, int runs) {
  fmt::print(
      "\nThe stage `gpu_threshold`, always on the GPU: *time* until the labels are there, of processors by "
      "the camera's thread, and by all threads of the program (with the driver's). *CPU*: `threshold`. "
      "*Follow*: `find_runs` and `find_regions`, that both need. *segment*: what does all three at once.\n\n"
      "| size | format | time (ms) | camera's thread (ms) | all threads (ms) | CPU (ms) | follow (ms) | "
      "segment (ms) | labels |\n|---|---|---:|---:|---:|---:|---:|---:|---|\n");
  bool is_good = true;
  std::string notes, note;
  for (const Shown& shown : kShown) {
    const Exposed exposed = expose(shown);
    for (const PixelFormat format : kFormats) {
      is_good = stage_row(lut, exposed, format, runs, note) && is_good;
      notes += fmt::format("- {}x{} {}: {}\n", shown.width, shown.height, name_of(format), note);
    }
  }
  using std::chrono::microseconds;
  fmt::print("\nTo the stage's thread and back, without work: {:.3f} ms; {:.3f} ms after a pause of 5 ms.\n",
             hand_over_ms(lut, 5000, microseconds(0)), hand_over_ms(lut, 200, microseconds(5000)));
  fmt::print("\nWhat it says:\n{}", notes);
  return is_good;
}

/// Returns false if a label differs or there are none.
bool row(GpuContext& context, const Lut& lut, const Exposed& exposed, PixelFormat format, int runs) {
  constexpr int kWarmUp = 5;
  const std::vector<std::uint8_t> bytes = bytes_of(exposed, format);
  const Image image = image_of(bytes, exposed, format);
  Timed gpu(context);
  Threshold cpu;
  const Mask mask;
  LabelImage wanted;
  std::vector<double> on_cpu_ms;
  for (int i = -kWarmUp; i < runs; ++i) {
    const auto before = Clock::now();
    cpu.process({}, lut, mask, image, wanted);
    const double took = ms(Clock::now() - before);
    if (i >= 0) on_cpu_ms.push_back(took);
    gpu.run(lut, image, wanted, i >= 0);
  }
  fmt::print("| {}x{} | {} | {:.2f} | {:.2f} | {:.2f} | {:.2f} | {:.2f} | {} |\n", image.view().width,
             image.view().height, name_of(format), median(gpu.upload_ms), median(gpu.shader_ms),
             median(gpu.read_back_ms), median(gpu.all_ms), median(on_cpu_ms),
             gpu.problem.empty() ? "identical" : gpu.problem);
  return gpu.problem.empty();
}

int table(int runs) {
  GpuContext context;
  fmt::print("GPU: {}\n\n", context.renderer());
  fmt::print(
      "Usual halls of the second renderer (tests/halls, seed 1), the colour classes of config/demo.json, no "
      "mask; medians of {} runs, CPU and GPU in turns; {} processors. *In all* is one call without waits "
      "between its steps.\n\n",
      runs, std::thread::hardware_concurrency());
  fmt::print(
      "| size | format | upload (ms) | shader (ms) | read back (ms) | in all (ms) | CPU, one "
      "core (ms) | labels |\n|---|---|---:|---:|---:|---:|---:|---|\n");
  const auto lut = league_lut();
  bool is_good = true;
  for (const Shown& shown : kShown) {
    const Exposed exposed = expose(shown);
    for (const PixelFormat format : kFormats) is_good = row(context, *lut, exposed, format, runs) && is_good;
  }
  is_good = stage_table(*lut, runs) && is_good;
  return is_good ? 0 : 1;
}

}  // namespace
}  // namespace sslv::halls

int main(int argc, char** argv) {
  int runs = 50;
  if (argc == 3 && std::string_view(argv[1]) == "--runs") runs = std::atoi(argv[2]);
  if ((argc != 1 && argc != 3) || runs < 1) {
    fmt::print(stderr, "usage: gpu_table [--runs 50]\n");
    return 64;
  }
  try {
    return sslv::halls::table(runs);
  } catch (const sslv::GpuError& none) {
    fmt::print(stderr, "gpu_table: {}\n", none.what());
    return 77;
  }
}
