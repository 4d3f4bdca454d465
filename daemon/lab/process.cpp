// SPDX-License-Identifier: Apache-2.0
#include "lab/process.h"

#include "base/plain_text.h"
#include "config/backends.h"
#include "lab/no_sink.h"
#include "pipeline/camera_pipeline.h"
#include "vision/detections_json.h"

#include <chrono>
#include <ostream>
#include <vector>

namespace sslv {
namespace {

/// Writes the stages' last notes.
void write_notes(const Pipeline& pipeline, std::ostream& out) {
  for (std::size_t i = 0; i < pipeline.stack().size(); ++i) {
    const StageNotes::Note note = pipeline.note(i);
    if (note.kind != StageNotes::Kind::kNone)
      out << pipeline.stack()[i] << ": " << escaped_text(note.text) << '\n';
  }
}

/// Rate of frames that have no times of their own. Frames in a folder may be from any times; with a short
/// interval, things at another place are rarely mistaken for a ball that has moved.
double rate_hz(const CameraSettings& camera) {
  constexpr double kFast_hz = 250;
  const auto given = camera.source.find("frame_rate_hz");
  const bool is_given = given != camera.source.end() && given->is_number() && given->get<double>() > 0;
  return is_given ? given->get<double>() : kFast_hz;
}

}  // namespace

int process_recording(const Config& config, std::size_t camera_index, const ProcessOptions& options,
                      const std::function<void(const std::string& name, const Frame&)>& use,
                      std::ostream& problems) {
  const CameraSettings& camera = config.cameras.at(camera_index);
  const std::string path = "/cameras/" + std::to_string(camera_index);
  CameraSetup setup;
  setup.pipeline = std::make_shared<Pipeline>(stage_table(), camera.stack, path + "/stack");
  setup.parameters = setup.pipeline->make_parameters(camera.stages, path + "/stages");
  setup.context = make_context(config, camera_index);

  const Backend& files = find_backend("files", "--input");
  Json source{{"path", options.input}, {"frame_rate_hz", 0}, {"loop", false}};
  if (!options.pixel_format.empty()) {
    source.update(
        Json{{"pixel_format", options.pixel_format}, {"width", options.width}, {"height", options.height}});
  }
  const auto id = static_cast<std::uint32_t>(camera.id);
  const auto input = files.open(files.complete(source, "--input"), {id, *setup.context.scene});

  NoSink sink;
  CameraPipeline pipeline(id, sink, setup);
  const double interval_s = 1 / rate_hz(camera);
  double next_s = 1;
  int unreadable = 0;
  for (;;) {
    CapturedImage captured;
    std::string problem;
    switch (input->next(captured, problem, std::chrono::seconds(10))) {
      case CaptureStatus::kImage: {
        const std::string name = captured.name;
        // The recording's own time, or else a reproducible time: the stages' state depends on it.
        CaptureTimes& times = captured.times;
        times.t_capture_s = times.t_capture_camera_s.value_or(next_s);
        next_s = times.t_capture_s + interval_s;
        use(name, pipeline.process(std::move(captured.image), captured.times));
        break;
      }
      case CaptureStatus::kIncomplete:
        problems << problem << '\n';
        ++unreadable;
        break;
      case CaptureStatus::kTimeout: break;
      case CaptureStatus::kEnd: write_notes(*setup.pipeline, problems); return unreadable;
      case CaptureStatus::kLost: throw CaptureError(problem);
    }
  }
}

int process_recording(const Config& config, std::size_t camera_index, const ProcessOptions& options,
                      std::ostream& out, std::ostream& problems) {
  const std::vector<std::string>& stack = config.cameras.at(camera_index).stack;
  const auto write = [&](const std::string& name, const Frame& frame) {
    Json line{{"frame", name}};
    line.update(detections_json(frame.robots, frame.balls));
    line["timing_us"] = Json::object();
    for (std::size_t i = 0; i < frame.stage_ns.size(); ++i)
      line["timing_us"][stack[i]] = static_cast<double>(frame.stage_ns[i]) * 1e-3;
    out << json_text(line) << '\n';
  };
  return process_recording(config, camera_index, options, write, problems);
}

}  // namespace sslv
