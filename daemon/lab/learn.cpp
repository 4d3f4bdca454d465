// SPDX-License-Identifier: Apache-2.0
#include "lab/learn.h"

#include "config/backends.h"
#include "ctl/colors.h"

#include <chrono>
#include <list>
#include <map>
#include <ostream>
#include <vector>

#include <fmt/format.h>

namespace sslv {

LearntColors learn_from_recording(const Config& config, std::size_t camera_index, const LearnInput& input,
                                  std::ostream& problems) {
  // An empty table, so that the camera's colour table, which is not needed, is not read.
  const CameraContext context = make_context(config, camera_index, std::make_shared<const Lut>());
  const Backend& files = find_backend("files", "--input");
  Json source{{"path", input.path}, {"frame_rate_hz", 0}, {"loop", false}};
  if (!input.pixel_format.empty()) {
    source.update(
        Json{{"pixel_format", input.pixel_format}, {"width", input.width}, {"height", input.height}});
  }
  const auto id = static_cast<std::uint32_t>(config.cameras.at(camera_index).id);
  const auto recording = files.open(files.complete(source, "--input"), {id, *context.scene});
  LearnTask task{{}, *context.scene, *context.patterns, context.mask.get()};
  std::list<std::vector<std::uint8_t>> buffers;
  bool ended = false;
  for (int seen = 0; !ended && static_cast<int>(task.frames.size()) < input.frames;) {
    CapturedImage captured;
    std::string problem;
    switch (recording->next(captured, problem, std::chrono::seconds(10))) {
      case CaptureStatus::kImage: {
        if (seen++ % input.every != 0) break;
        ImageView view = captured.image.view();
        const auto stride = static_cast<std::size_t>(view.width * bytes_per_pixel(view.format));
        auto& bytes = buffers.emplace_back();
        bytes.reserve(stride * static_cast<std::size_t>(view.height));
        for (int y = 0; y < view.height; ++y) bytes.insert(bytes.end(), view.row(y), view.row(y) + stride);
        view.data = bytes.data();
        view.stride_bytes = static_cast<std::ptrdiff_t>(stride);
        task.frames.push_back(view);
        break;
      }
      case CaptureStatus::kIncomplete: problems << problem << '\n'; break;
      case CaptureStatus::kTimeout: break;
      case CaptureStatus::kEnd: ended = true; break;
      case CaptureStatus::kLost: throw CaptureError(problem);
    }
  }
  if (task.frames.empty()) throw CaptureError(input.path + ": holds no image that can be used");
  return learn_colors(task);
}

std::string learnt_colors_text(const Json& learnt) {
  std::string out = learnt.at("learnt") == true ? "Learnt.\n" : "NOT learnt.\n";
  std::map<std::string, int> robots;
  for (const Json& robot : learnt.at("robots")) ++robots[robot.at("team").get<std::string>()];
  if (learnt.at("robots").size() > 0) {
    out += fmt::format("  seen: {} yellow and {} blue robots, {} balls; {:.2f} mm a pixel, noise {:.1f}\n",
                       robots["yellow"], robots["blue"], learnt.at("balls").size(),
                       learnt.at("mm_per_px").get<double>(), learnt.at("noise_grey").get<double>());
  }
  for (const Json& label : learnt.at("labels")) {
    const int seen = label.at("seen").get<int>();
    out += fmt::format("  {:<7} {}  spread {:3.0f}  {}\n", label.at("label").get<std::string>(),
                       label.at("mean").get<std::string>(), label.at("spread").get<double>(),
                       seen > 0 ? fmt::format("{} seen", seen) : "predicted");
  }
  if (learnt.at("learnt") == true) out += margins_text(learnt.at("margins"));
  for (const Json& note : learnt.at("notes")) out += "note: " + note.get<std::string>() + "\n";
  if (learnt.at("problem") != "") out += "problem: " + learnt.at("problem").get<std::string>() + "\n";
  return out;
}

}  // namespace sslv
