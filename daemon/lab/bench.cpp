// SPDX-License-Identifier: Apache-2.0
#include "lab/bench.h"

#include "base/params_json.h"
#include "capture/simulator/simulator.h"
#include "capture/simulator/simulator_camera.h"
#include "config/backends.h"
#include "lab/no_sink.h"
#include "pipeline/pipeline.h"

#include <algorithm>
#include <array>

#include <fmt/format.h>

namespace sslv {
namespace {

constexpr double kFirstS = 1000;  // first drawn frame; then one each second: all runs draw the same frames

StageTiming summary_of(std::string stage, std::vector<double> us) {
  std::sort(us.begin(), us.end());
  return {std::move(stage), us.front(), us[us.size() / 2], us[std::min(us.size() - 1, us.size() * 99 / 100)]};
}

BenchResult time_stack(const CameraSettings& camera, const std::string& path, const CameraContext& context,
                       const Recording& recording, int rounds) {
  Pipeline pipeline(stage_table(), camera.stack, path + "/stack");
  const auto parameters = pipeline.make_parameters(camera.stages, path + "/stages");
  NoSink sink;
  Frame frame;
  std::vector<std::vector<double>> us(camera.stack.size() + 1);
  for (int round = -1; round < rounds; ++round) {  // the first round only warms up
    for (const ImageView& view : recording.views) {
      frame.image = Image(view, nullptr, nullptr, nullptr);
      pipeline.run({frame, context, sink}, parameters);
      if (round < 0) continue;
      double total = 0;
      for (std::size_t i = 0; i < frame.stage_ns.size(); ++i) {
        us[i].push_back(static_cast<double>(frame.stage_ns[i]) * 1e-3);
        total += us[i].back();
      }
      us.back().push_back(total);
    }
  }
  const ImageView& view = recording.views.front();
  BenchResult result{std::string(name_of(view.format)), view.width, view.height, frame.robots.robots.size(),
                     frame.balls.balls.size(),          {}};
  for (std::size_t i = 0; i < camera.stack.size(); ++i)
    result.stages.push_back(summary_of(camera.stack[i], us[i]));
  result.stages.push_back(summary_of("total", us.back()));
  return result;
}

/// The same camera with a sensor of another size that sees the same part of the field.
CameraCalibration scaled(CameraCalibration calibration, int width, int height) {
  const double scale = std::min(static_cast<double>(width) / calibration.pixel_image_width,
                                static_cast<double>(height) / calibration.pixel_image_height);
  calibration.focal_length *= scale;
  calibration.principal_point_x = (calibration.principal_point_x + 0.5) * scale - 0.5;
  calibration.principal_point_y = (calibration.principal_point_y + 0.5) * scale - 0.5;
  calibration.pixel_image_width = width;
  calibration.pixel_image_height = height;
  return calibration;
}

}  // namespace

Recording record(Source& source, int count) {
  Recording recording;
  while (count == 0 || static_cast<int>(recording.views.size()) < count) {
    CapturedImage captured;
    std::string problem;
    const CaptureStatus status = source.next(captured, problem, std::chrono::seconds(10));
    if (status == CaptureStatus::kEnd) break;
    if (status == CaptureStatus::kLost) throw CaptureError(problem);
    if (status != CaptureStatus::kImage) continue;
    ImageView view = captured.image.view();
    const auto row_bytes =
        static_cast<std::size_t>(view.width) * static_cast<std::size_t>(bytes_per_pixel(view.format));
    auto& buffer = recording.buffers.emplace_back(row_bytes * static_cast<std::size_t>(view.height));
    for (int y = 0; y < view.height; ++y) {
      std::copy_n(view.row(y), row_bytes, buffer.data() + static_cast<std::size_t>(y) * row_bytes);
    }
    view.data = buffer.data();
    view.stride_bytes = static_cast<std::ptrdiff_t>(row_bytes);
    recording.views.push_back(view);
  }
  if (recording.views.empty()) throw CaptureError("the input holds no frame to time");
  return recording;
}

Scene scene_of(const Config& config, std::size_t camera_index, int width, int height) {
  const CameraSettings& camera = config.cameras.at(camera_index);
  Scene scene = *make_context(config, camera_index, std::make_shared<Lut>()).scene;
  const std::string path = "/cameras/" + std::to_string(camera_index);
  if (camera.calibration) scene.camera.emplace(scaled(*camera.calibration, width, height), path);
  return scene;
}

Recording draw_frames(const Config& config, std::size_t camera_index, PixelFormat format, int width,
                      int height, int frames, const Json& options) {
  const std::string path = "/cameras/" + std::to_string(camera_index);
  const CameraSettings& camera = config.cameras.at(camera_index);
  Json all = camera.source["backend"] == "simulator" ? camera.source : Json::object();
  all.erase("backend");
  all.update(options);
  all.update(
      Json{{"width", width}, {"height", height}, {"pixel_format", name_of(format)}, {"frame_rate_hz", 0}});
  SimulatedCamera drawn(
      simulator_options(all, path + "/source"),
      {static_cast<std::uint32_t>(camera.id), scene_of(config, camera_index, width, height)},
      league_patterns());
  Recording recording;
  for (int i = 0; i < frames; ++i) {
    recording.buffers.emplace_back(drawn.picture_bytes());
    drawn.draw(kFirstS + i, recording.buffers.back().data());
    ImageView& view = recording.views.emplace_back(drawn.layout());
    view.data = recording.buffers.back().data();
  }
  return recording;
}

std::vector<BenchResult> bench_simulated(const Config& config, std::size_t camera_index, int frames,
                                         int rounds) {
  constexpr std::array<std::array<int, 2>, 3> kSizes{{{780, 580}, {1280, 1024}, {2448, 2048}}};
  const std::string path = "/cameras/" + std::to_string(camera_index);
  const CameraSettings& camera = config.cameras.at(camera_index);
  if (!camera.calibration)
    throw SettingsError(path + "/calibration: is missing; the simulator needs it to draw frames");
  CameraContext context = make_context(config, camera_index);
  std::vector<BenchResult> results;
  for (const auto& [width, height] : kSizes) {
    auto scene = std::make_shared<Scene>(*context.scene);
    scene->camera.emplace(scaled(*camera.calibration, width, height), path + "/calibration");
    context.scene = scene;
    for (const PixelFormat format : {PixelFormat::kUyvy, PixelFormat::kRgb24, PixelFormat::kBayerRg8}) {
      const Recording recording = draw_frames(config, camera_index, format, width, height, frames);
      results.push_back(time_stack(camera, path, context, recording, rounds));
    }
  }
  return results;
}

BenchResult bench_recorded(const Config& config, std::size_t camera_index, const std::string& input,
                           const std::string& pixel_format, int width, int height, int rounds) {
  const std::string path = "/cameras/" + std::to_string(camera_index);
  const CameraSettings& camera = config.cameras.at(camera_index);
  const Backend& files = find_backend("files", "--input");
  Json options{{"path", input}, {"frame_rate_hz", 0}, {"loop", false}};
  if (!pixel_format.empty())
    options.update(Json{{"pixel_format", pixel_format}, {"width", width}, {"height", height}});
  const CameraContext context = make_context(config, camera_index);
  const auto source =
      files.open(files.complete(options, "--input"), {static_cast<std::uint32_t>(camera.id), *context.scene});
  return time_stack(camera, path, context, record(*source, 0), rounds);
}

Json bench_json(const std::vector<BenchResult>& results) {
  Json out = Json::array();
  for (const BenchResult& result : results) {
    Json stages = Json::array();
    for (const StageTiming& stage : result.stages) {
      stages.push_back({{"stage", stage.stage},
                        {"min_us", stage.min_us},
                        {"median_us", stage.median_us},
                        {"p99_us", stage.p99_us}});
    }
    out.push_back({{"pixel_format", result.pixel_format},
                   {"width", result.width},
                   {"height", result.height},
                   {"robots", result.robots},
                   {"balls", result.balls},
                   {"stages", stages}});
  }
  return out;
}

std::string bench_text(const std::vector<BenchResult>& results) {
  std::string out;
  for (const BenchResult& result : results) {
    out += fmt::format("{}x{} {}: {} robots, {} balls in the last frame\n  {:<16}{:>12}{:>12}{:>12}\n",
                       result.width, result.height, result.pixel_format, result.robots, result.balls, "stage",
                       "min us", "median us", "p99 us");
    for (const StageTiming& stage : result.stages) {
      out += fmt::format("  {:<16}{:>12.1f}{:>12.1f}{:>12.1f}\n", stage.stage, stage.min_us, stage.median_us,
                         stage.p99_us);
    }
  }
  return out;
}

}  // namespace sslv
