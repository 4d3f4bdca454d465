// SPDX-License-Identifier: Apache-2.0
#include "lab/simulate.h"

#include "capture/simulator/simulator.h"
#include "capture/simulator/simulator_camera.h"

#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <system_error>
#include <vector>

#include <fmt/format.h>

namespace sslv {
namespace {

void write_file(const std::filesystem::path& file, std::string_view head, std::string_view body) {
  std::ofstream out(file, std::ios::binary);
  out << head << body << std::flush;
  if (!out) throw std::system_error(errno, std::generic_category(), "cannot write " + file.string());
}

}  // namespace

void simulate(const SimulateOptions& options) {
  constexpr double kDefaultRateHz = 60;
  SimulatorOptions source = simulator_options(options.source, "/source");
  if (!options.raw) {
    source.pixel_format = PixelFormat::kRgb24;
    source.bits = 8;
  }
  const double rate_hz = source.frame_rate_hz > 0 ? source.frame_rate_hz : kDefaultRateHz;
  SimulatedCamera camera(source, options.context, league_patterns());

  const std::filesystem::path folder(options.folder);
  std::filesystem::create_directories(folder);
  std::vector<std::uint8_t> picture(camera.picture_bytes());
  const std::string_view bytes(reinterpret_cast<const char*>(picture.data()), picture.size());
  const std::string head = options.raw ? "" : fmt::format("P6\n{} {}\n255\n", source.width, source.height);
  Json index{{"pixel_format", name_of(source.pixel_format)},
             {"width", source.width},
             {"height", source.height},
             {"camera", options.context.camera_id},
             {"frames", Json::array()}};
  std::string truth;
  for (int i = 0; i < options.frames; ++i) {
    const double t_s = options.start_s + i / rate_hz;
    const std::string stem = fmt::format("frame_{:06}", i);
    const std::string file = stem + (options.raw ? ".raw" : ".ppm");
    camera.draw(t_s, picture.data());
    write_file(folder / file, head, bytes);
    truth += json_text(camera.truth(stem, t_s)) + "\n";
    index["frames"].push_back({{"file", file}, {"t", t_s}});
  }
  write_file(folder / "truth.jsonl", "", truth);
  write_file(folder / "frames.json", json_text(index, 1), "\n");
}

}  // namespace sslv
