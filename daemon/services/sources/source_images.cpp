// SPDX-License-Identifier: Apache-2.0
#include "services/sources/source_images.h"

#include "base/background.h"
#include "base/clock.h"
#include "config/backends.h"
#include "image/jpeg.h"

#include <chrono>
#include <memory>
#include <optional>
#include <span>

#include <fmt/format.h>

namespace sslv {
namespace {

constexpr std::chrono::seconds kPatience(10), kPatienceWithOthers(1);
constexpr double kFirstImageWithin_s = 6;
/// Time for the exposure to settle: a webcam's first images are dark.
constexpr double kSettles_s = 0.5;
constexpr int kQuality = 80;

/// Returns the image that a camera shows soon after it was opened.
CapturedImage wait_image(Source& camera) {
  const double opened_s = steady_s();
  std::optional<double> first_s;
  CapturedImage newest;
  std::string problem;
  for (;;) {
    const double now_s = steady_s();
    if (first_s && now_s - *first_s > kSettles_s) return newest;
    if (!first_s && now_s - opened_s > kFirstImageWithin_s) {
      throw CaptureError(fmt::format("it was opened, but no image arrived within {:g} s{}{}",
                                     kFirstImageWithin_s, problem.empty() ? "" : ": ", problem));
    }
    CapturedImage image;
    switch (camera.next(image, problem, std::chrono::milliseconds(100))) {
      case CaptureStatus::kImage:
        newest = std::move(image);
        if (!first_s) first_s = steady_s();
        break;
      case CaptureStatus::kTimeout:
      case CaptureStatus::kIncomplete: break;
      case CaptureStatus::kEnd:
        if (first_s) return newest;
        throw CaptureError("it has no image");
      case CaptureStatus::kLost:
        if (first_s) return newest;
        throw CaptureError(problem);
    }
  }
}

Json jpeg_of(const Json& source, const Scene& scene, int width_px) {
  become_background_thread("source image");
  const std::unique_ptr<Source> camera = open_source(source, {0, scene});
  const CapturedImage image = wait_image(*camera);
  JpegEncoder encoder;
  const std::span<const std::uint8_t> jpeg = encoder.encode(image.image.view(), width_px, kQuality);
  return Json::binary({jpeg.begin(), jpeg.end()});
}

}  // namespace

SourceImages::SourceImages() {
  for (const Backend& backend : backend_table())
    calls_.emplace(std::string(backend.name), DriverCalls(kPatience, kPatienceWithOthers));
}

std::vector<std::uint8_t> SourceImages::take(const Json& source, const Scene& scene, int width_px) const {
  const DriverCalls& calls = calls_.at(source.at("backend").get<std::string>());
  return calls.run([source, scene, width_px] { return jpeg_of(source, scene, width_px); }).get_binary();
}

}  // namespace sslv
