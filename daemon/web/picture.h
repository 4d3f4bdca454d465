// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/params.h"
#include "image/jpeg.h"
#include "web/host.h"

#include <array>
#include <cstdint>
#include <string_view>
#include <vector>

namespace sslv {

/// What a viewer sees of a frame: the camera's own picture or the labelled one.
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

/// The picture of a view that is wished for, or the camera's where nothing is labelled. A labelled one is
/// drawn into `buffer`.
inline Picture picture_of(const View& view, PictureKind wished, std::vector<std::uint8_t>& buffer) {
  if (wished == PictureKind::kLabels && view.draw_labels)
    return {wished, view.draw_labels(buffer), Chroma::kFull};
  return {PictureKind::kCamera, view.image, Chroma::kHalved};
}

}  // namespace sslv
