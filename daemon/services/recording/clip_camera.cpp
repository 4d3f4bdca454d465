// SPDX-License-Identifier: Apache-2.0
#include "services/recording/clip_camera.h"

namespace sslv {

bool ClipCamera::write(ClipWriter& writer, const ClipFrame& frame) {
  // Parts need the whole image that they are parts of.
  if (!has_begun_ && (frame.memory.empty() || frame.tile_px != 0)) return false;
  const bool fits = frame.image.width == whole_.width && frame.image.height == whole_.height &&
                    frame.image.format == whole_.format;
  if (frame.tile_px != 0 && (lacks_whole_ || !fits)) return false;
  lacks_whole_ = true;  // until it is written
  auto place = setups_.find(frame.setup);
  if (place == setups_.end()) {
    const auto setup = setup_of_(frame.setup);
    if (!setup) return false;
    place = setups_.emplace(frame.setup, writer.add(*setup)).first;
  }
  has_begun_ = true;
  lacks_whole_ = false;
  whole_ = frame.image;
  whole_.data = nullptr;
  ClipFrame out = frame;
  out.setup = place->second;
  writer.add(out);
  // What is left out on purpose is not missing.
  const std::uint32_t step = last_number_ ? out.info.number - *last_number_ : 1;
  if (step > every_nth_) note_missing(writer, (step - 1) / every_nth_);
  last_number_ = out.info.number;
  return true;
}

void ClipCamera::note_missing(ClipWriter& writer, std::uint64_t frames) {
  if (frames == 0) return;
  writer.note_missing(static_cast<std::uint32_t>(id_), frames);
  missing_ += frames;
}

}  // namespace sslv
