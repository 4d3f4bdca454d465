// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "capture/simulator/simulator.h"
#include "capture/simulator/simulator_camera.h"
#include "clips/clip_writer.h"
#include "config/config.h"
#include "net/packets.h"
#include "pipeline/camera_pipeline.h"
#include "replay/clip_setup.h"
#include "support/paths.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace sslv {

/// The demo's two cameras with a quarter of the pixels at the same scale, noise, and changing light.
inline Json live_settings(const char* pixel_format = "uyvy") {
  std::ifstream in(source_path("/config/demo.json"));
  Json settings = Json::parse(in);
  for (Json& camera : settings["cameras"]) {
    camera["source"].update(Json{{"width", 390},
                                 {"height", 290},
                                 {"pixel_format", pixel_format},
                                 {"robots_yellow", 11},
                                 {"robots_blue", 11},
                                 {"balls", 3},
                                 {"distractors", 4},
                                 {"noise_sigma", 4},
                                 {"light_swing", {{0, 1}, {1.5, 0.75}, {3, 1}}}});
    Json& calibration = camera["calibration"];
    for (const char* key : {"principal_point_x", "principal_point_y"})
      calibration[key] = calibration[key].get<double>() / 2;
    calibration.update(Json{{"pixel_image_width", 390}, {"pixel_image_height", 290}});
  }
  return settings;
}

/// Cameras whose images are drawn and processed like in the service, one after the other in this thread, and
/// written to a clip.
class LiveRun {
 public:
  static constexpr double kBeginS = 1000;

  explicit LiveRun(const Json& settings, double rate_hz = 60)
      : rate_hz_(rate_hz), config_(read_config(settings)) {
    for (std::size_t i = 0; i < config_.cameras.size(); ++i)
      cameras_.push_back(std::make_unique<Camera>(config_, i));
  }

  /// Begins with the next frame; the memory of the stages is written with it.
  void begin_clip(const std::filesystem::path& file, bool with_memory = true) {
    writer_.emplace(file, ClipAbout{.site = config_.site, .version = "0", .why = "a test"});
    for (auto& camera : cameras_) {
      camera->setup.reset();
      camera->begins = with_memory;
    }
  }
  void end_clip() {
    writer_->finish();
    writer_.reset();
  }

  void run(double seconds) {
    const auto frames = static_cast<std::int64_t>(seconds * rate_hz_ + 0.5);
    for (std::int64_t i = 0; i < frames; ++i, ++frame_) {
      // Cameras are never exactly synchronous.
      const double t_s = kBeginS + static_cast<double>(frame_) / rate_hz_;
      for (std::size_t c = 0; c < cameras_.size(); ++c) take(c, t_s + 0.001 * static_cast<double>(c));
    }
  }
  /// A frame that is processed but not written to the clip.
  void skip_frame() {
    const bool was_skipping = std::exchange(skips_, true);
    run(1 / rate_hz_);
    skips_ = was_skipping;
  }

  /// Like the service: keeps the pipeline if the stack is the same.
  void change_settings(const Json& settings) {
    config_ = read_config(settings);
    for (std::size_t i = 0; i < cameras_.size(); ++i) {
      const CameraSettings& camera = config_.cameras[i];
      CameraSetup setup;
      setup.pipeline = cameras_[i]->pipeline.setup()->pipeline;
      if (setup.pipeline->stack() != camera.running.stages)
        setup.pipeline = std::make_shared<Pipeline>(stage_table(), camera.running.stages, "/stack");
      setup.parameters = setup.pipeline->parameters_of(camera.stage_params);
      setup.context = make_context(config_, i);
      change(i, std::move(setup));
    }
  }
  void change_table(std::shared_ptr<const Lut> adapted) {
    for (std::size_t i = 0; i < cameras_.size(); ++i) {
      CameraSetup setup = *cameras_[i]->pipeline.setup();
      setup.context.adapted_lut = adapted;
      change(i, std::move(setup));
    }
  }
  void change_heights(const std::array<double, 2>& robot_height_mm) {
    for (std::size_t i = 0; i < cameras_.size(); ++i) {
      CameraSetup setup = *cameras_[i]->pipeline.setup();
      Scene scene = *setup.context.scene;
      scene.robot_height_mm = robot_height_mm;
      setup.context.scene = std::make_shared<const Scene>(std::move(scene));
      change(i, std::move(setup));
    }
  }

  std::shared_ptr<const CameraSetup> setup(std::size_t camera) const {
    return cameras_[camera]->pipeline.setup();
  }
  std::uint64_t robots() const { return robots_; }
  std::uint64_t balls() const { return balls_; }

 private:
  struct Sink : DetectionSink {
    void publish(const FrameInfo& info, const Scene&, const RobotList& robots,
                 const BallList& balls) noexcept override {
      write_detection(info, robots, balls, info.times.t_capture_s + 0.004, message);
      packet = serialize(message, buffer);
    }
    SSL_WrapperPacket message;
    std::vector<std::byte> buffer;
    std::span<const std::byte> packet;
  };
  struct Camera {
    Camera(const Config& config, std::size_t i)
        : id(static_cast<std::uint32_t>(config.cameras[i].id)),
          drawn(options_of(config.cameras[i]), {id, *make_context(config, i).scene}, league_patterns()),
          picture(drawn.picture_bytes()),
          pipeline(id, sink, first_setup(config, i)) {}
    static SimulatorOptions options_of(const CameraSettings& camera) {
      Json source = camera.source;
      source.erase("backend");
      return simulator_options(source, "/source");
    }
    static CameraSetup first_setup(const Config& config, std::size_t i) {
      const CameraSettings& camera = config.cameras[i];
      CameraSetup setup;
      setup.pipeline = std::make_shared<Pipeline>(stage_table(), camera.running.stages, "/stack");
      setup.parameters = setup.pipeline->parameters_of(camera.stage_params);
      setup.context = make_context(config, i);
      return setup;
    }

    const std::uint32_t id;
    SimulatedCamera drawn;
    std::vector<std::uint8_t> picture;
    Sink sink;
    CameraPipeline pipeline;
    std::optional<std::uint32_t> setup{};  // index in the clip
    bool begins = false;
  };

  void change(std::size_t i, CameraSetup setup) {
    cameras_[i]->pipeline.change(std::move(setup));
    cameras_[i]->setup.reset();
  }

  void take(std::size_t c, double t_s) {
    Camera& camera = *cameras_[c];
    const auto setup = camera.pipeline.setup();
    camera.drawn.draw(t_s, camera.picture.data());
    ImageView view = camera.drawn.layout();
    view.data = camera.picture.data();
    std::vector<std::byte> memory(std::size_t{1} << 20);
    memory.resize(camera.begins ? setup->pipeline->save(memory) : 0);
    CaptureTimes times{.t_capture_s = t_s, .t_capture_camera_s = t_s - 900, .arrived_ns = 12345};
    const Frame& frame = camera.pipeline.process(Image(view, nullptr, nullptr, nullptr), times);
    robots_ += frame.robots.robots.size();
    balls_ += frame.balls.balls.size();
    if (!writer_ || skips_) return;
    camera.begins = false;
    if (!camera.setup) camera.setup = writer_->add(clip_setup(config_, c, *setup));
    writer_->add(ClipFrame{.info = frame.info,
                           .setup = *camera.setup,
                           .image = view,
                           .packet = camera.sink.packet,
                           .memory = memory});
  }

  const double rate_hz_;
  Config config_;
  std::vector<std::unique_ptr<Camera>> cameras_;
  std::optional<ClipWriter> writer_;
  std::int64_t frame_ = 0;
  bool skips_ = false;
  std::uint64_t robots_ = 0, balls_ = 0;
};

}  // namespace sslv
