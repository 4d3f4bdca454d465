// SPDX-License-Identifier: Apache-2.0
#pragma once

// What viewers see: numbered cameras' frames, each with what was found in it.

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

/// A processed frame as viewers see it. It holds a slot of the camera's ring: let go soon.
struct View {
  std::uint64_t version = 0;         // see ViewSource::wait_view
  std::shared_ptr<const void> hold;  // keeps the image's bytes where they are
  ImageView image;
  std::uint32_t camera_id = 0;
  std::uint32_t frame_number = 0;
  double t_capture_s = 0;
  Json detections;  // {"robots": [...], "balls": [...]} as docs/openapi.json has them

  /// As docs/openapi.json's PreviewRegions; not set when the camera's stack makes no runs.
  std::function<Json()> regions;

  /// Draws the labelled image into the buffer, where it then lies; not set when the camera's stack makes no
  /// runs.
  std::function<ImageView(std::vector<std::uint8_t>& buffer)> draw_labels;
};

/// Where views come from. May be asked from any thread.
class ViewSource {
 public:
  virtual ~ViewSource() = default;

  /// Must not block: it is called from the thread that serves all sockets.
  virtual std::vector<std::uint32_t> camera_ids() const = 0;

  /// The newest view of a camera once its version is newer than the given one (0: any); nothing after the
  /// timeout, without an image yet, or when there is no such camera. Versions of a camera id start at 1 and
  /// only grow, also across a reconnection.
  virtual std::optional<View> wait_view(std::uint32_t camera_id, std::uint64_t newer_than_version,
                                        std::chrono::milliseconds timeout) = 0;
};

/// What a viewer sees of a frame: the camera's own image or the labelled one.
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
  Chroma chroma;  // to be encoded with
};

/// The image of a view that is wished for, or the camera's where nothing is labelled. A labelled one is
/// drawn into `buffer`.
inline Picture picture_of(const View& view, PictureKind wished, std::vector<std::uint8_t>& buffer) {
  if (wished == PictureKind::kLabels && view.draw_labels)
    return {wished, view.draw_labels(buffer), Chroma::kFull};
  return {PictureKind::kCamera, view.image, Chroma::kHalved};
}

/// What a viewer wants to see of a camera.
struct PreviewWish {
  int width = 640;   // px, at most
  int quality = 70;  // of the JPEG, 1..100
  double fps = 30;   // at most
  PictureKind picture = PictureKind::kCamera;
  bool regions = false;  // also those, in the header
};
inline constexpr double kMinFps = 0.01, kMaxFps = 1000;

/// A stream of one camera's images.
struct StreamWish {
  std::uint32_t camera_id;
  PreviewWish preview;
};

inline constexpr const char* kStreamType = "multipart/x-mixed-replace; boundary=ssl-visiond-picture";

}  // namespace sslv
