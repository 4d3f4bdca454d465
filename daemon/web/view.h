// SPDX-License-Identifier: Apache-2.0
#pragma once

// Data for viewers: frames of numbered cameras, each with its detections.

#include "base/json.h"
#include "base/params.h"
#include "image/image.h"
#include "image/jpeg.h"

#include <array>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string_view>
#include <vector>

namespace sslv {

/// A processed frame for viewers. It occupies a slot of the camera's ring: release it soon.
struct View {
  std::uint64_t version = 0;         // see ViewSource::wait_view
  std::shared_ptr<const void> hold;  // keeps the image's bytes valid
  ImageView image;
  std::uint32_t camera_id = 0;
  std::uint32_t frame_number = 0;
  double t_capture_s = 0;
  Json detections;  // {"robots": [...], "balls": [...]} as in docs/openapi.json
  Json misses;      // things that resemble robots, as in PreviewHeader

  /// PreviewRegions of docs/openapi.json; not set if the camera's stack makes no runs.
  std::function<Json()> regions;

  /// Draws the labelled image into the buffer; the returned view refers to it. Not set if the camera's stack
  /// makes no runs.
  std::function<ImageView(std::vector<std::uint8_t>& buffer)> draw_labels;
};

/// Source of views. Thread-safe.
class ViewSource {
 public:
  virtual ~ViewSource() = default;

  /// Must not block: it is called from the thread that serves all sockets.
  virtual std::vector<std::uint32_t> camera_ids() const = 0;

  /// Returns the camera's newest view once its version is newer than the given one (0: any); nothing on
  /// timeout, while there is no image, or if there is no such camera. Versions of a camera id start at 1 and
  /// only grow, also across reconnections.
  virtual std::optional<View> wait_view(std::uint32_t camera_id, std::uint64_t newer_than_version,
                                        std::chrono::milliseconds timeout) = 0;
};

/// The kind of image that a viewer gets: the camera's own or the labelled one.
enum class PictureKind : std::uint8_t { kCamera, kLabels };

inline constexpr std::array kPictureChoices{Choice<PictureKind>{"camera", PictureKind::kCamera},
                                            Choice<PictureKind>{"labels", PictureKind::kLabels}};

constexpr std::string_view name_of(PictureKind kind) {
  for (const auto& choice : kPictureChoices) {
    if (choice.value == kind) return choice.name;
  }
  return "";
}

struct Picture {
  PictureKind kind;
  ImageView image;
  Chroma chroma;  // for encoding
};

/// Returns the requested image of a view, or the camera's image if there is no labelled image. A labelled
/// image is drawn into `buffer`.
inline Picture picture_of(const View& view, PictureKind wished, std::vector<std::uint8_t>& buffer) {
  if (wished == PictureKind::kLabels && view.draw_labels)
    return {wished, view.draw_labels(buffer), Chroma::kFull};
  return {PictureKind::kCamera, view.image, Chroma::kHalved};
}

/// A viewer's request for one camera's images.
struct PreviewWish {
  int width = 640;   // px, maximum
  int quality = 70;  // JPEG quality, 1..100
  double fps = 30;   // maximum
  PictureKind picture = PictureKind::kCamera;
  bool regions = false;  // include the regions in the header
};
inline constexpr double kMinFps = 0.01, kMaxFps = 1000;

/// A requested stream of one camera's images.
struct StreamWish {
  std::uint32_t camera_id;
  PreviewWish preview;
};

inline constexpr const char* kStreamType = "multipart/x-mixed-replace; boundary=ssl-visiond-picture";

}  // namespace sslv
