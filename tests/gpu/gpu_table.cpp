// SPDX-License-Identifier: Apache-2.0
// Colour thresholding on this computer's GPU against one core of its CPU, in turns, on drawn halls: a
// Markdown table. Exit code 1 when a label differs, 77 when there is no GPU.
//   gpu_table [--runs 50]

#include "camera_bytes.h"
#include "draw.h"
#include "gpu/gpu_context.h"
#include "gpu/gpu_threshold.h"
#include "hall.h"
#include "play.h"
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

namespace sslv::halls {
namespace {

using Clock = std::chrono::steady_clock;
using Path = GpuThreshold::Path;

struct Shown {
  int width, height;
  Size hall;  // a usual hall, whose camera is scaled to that size
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
  hall.sensor.hot_pixels.clear();  // which were placed for the other size
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

/// Times of one path, and whether it said what the CPU says.
struct Timed {
  explicit Timed(GpuContext& context, Path path) : gpu(context, path) {}
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
    // What is left of this run must not pass for the next one's labels.
    std::fill(labels_.labels.begin(), labels_.labels.end(), Label{255});
  }
  Mask mask_;
  LabelImage labels_;
};

/// False: a label differs, or there are none.
bool row(GpuContext& context, const Lut& lut, const Exposed& exposed, PixelFormat format, int runs) {
  constexpr int kWarmUp = 5;
  const std::vector<std::uint8_t> bytes =
      camera_bytes(exposed.light, exposed.sensor, format, Chance(1, "noise", 1));
  const int width = exposed.light.width, height = exposed.light.height;
  const Image image(ImageView{bytes.data(), width, height, width * bytes_per_pixel(format), format}, nullptr,
                    nullptr, nullptr);
  std::vector<std::unique_ptr<Timed>> paths;
  if (context.has_compute()) paths.push_back(std::make_unique<Timed>(context, Path::kCompute));
  paths.push_back(std::make_unique<Timed>(context, Path::kFragment));

  Threshold cpu;
  const Mask mask;
  LabelImage wanted;
  std::vector<double> cpu_ms;
  for (int i = -kWarmUp; i < runs; ++i) {
    const auto before = Clock::now();
    cpu.process({}, lut, mask, image, wanted);
    const double took = ms(Clock::now() - before);
    if (i >= 0) cpu_ms.push_back(took);
    for (const auto& path : paths) path->run(lut, image, wanted, i >= 0);
  }
  bool is_good = true;
  for (const auto& path : paths) {
    is_good = is_good && path->problem.empty();
    fmt::print("| {}x{} | {} | {} | {:.2f} | {:.2f} | {:.2f} | {:.2f} | {:.2f} | {} |\n", width, height,
               name_of(format), path->gpu.path() == Path::kCompute ? "compute" : "fragment",
               median(path->upload_ms), median(path->shader_ms), median(path->read_back_ms),
               median(path->all_ms), median(cpu_ms), path->problem.empty() ? "identical" : path->problem);
  }
  return is_good;
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
      "| size | format | shader | upload (ms) | shader (ms) | read back (ms) | in all (ms) | CPU, one "
      "core (ms) | labels |\n|---|---|---|---:|---:|---:|---:|---:|---|\n");
  const auto lut = league_lut();
  bool is_good = true;
  for (const Shown& shown : kShown) {
    const Exposed exposed = expose(shown);
    for (const PixelFormat format : kFormats) is_good = row(context, *lut, exposed, format, runs) && is_good;
  }
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
