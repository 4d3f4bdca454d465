// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "capture/source.h"
#include "config/config.h"
#include "geometry/scene.h"
#include "image/image.h"

#include <string>
#include <vector>

namespace sslv {

/// Time one stage took over many frames of one kind.
struct StageTiming {
  std::string stage;
  double min_us, median_us, p99_us;
};
struct BenchResult {
  std::string pixel_format;
  int width, height;
  std::size_t robots,
      balls;  // found in the last frame: a pipeline that finds nothing would be fast, too
  std::vector<StageTiming> stages;  // the last one is "total"
};

/// Images that own their bytes.
struct Recording {
  std::vector<std::vector<std::uint8_t>> buffers;
  std::vector<ImageView> views;
};

/// Copies a source's first `count` images; 0: all. Throws CaptureError if there is none.
Recording record(Source& source, int count);

/// The scene of the settings' camera with a sensor of this size that sees the same part of the field.
Scene scene_of(const Config& config, std::size_t camera_index, int width, int height);

/// Draws simulated frames for a camera with a sensor of this size and format; its calibration is scaled with
/// the image. `options` override the options of the camera's source. The frames are the same in every run.
Recording draw_frames(const Config& config, std::size_t camera_index, PixelFormat format, int width,
                      int height, int frames, const Json& options = Json::object());

/// Runs the camera's stack over simulated frames of several formats and sizes, in one thread. The calibration
/// is scaled with the image. For each kind, `frames` frames are drawn and run `rounds` times.
std::vector<BenchResult> bench_simulated(const Config& config, std::size_t camera_index, int frames,
                                         int rounds);

/// The same over recorded frames (images or raw frames, as for `process`), read into memory first.
BenchResult bench_recorded(const Config& config, std::size_t camera_index, const std::string& input,
                           const std::string& pixel_format, int width, int height, int rounds);

/// A list of the results' members by their names.
Json bench_json(const std::vector<BenchResult>& results);
/// Human-readable tables.
std::string bench_text(const std::vector<BenchResult>& results);

}  // namespace sslv
