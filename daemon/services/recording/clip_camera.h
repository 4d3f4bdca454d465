// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "clips/clip.h"
#include "clips/clip_writer.h"

#include <cstdint>
#include <functional>
#include <map>
#include <optional>

namespace sslv {

/// One camera's part of a clip that is written: where it begins, which setups its frames need, and what is
/// missing.
class ClipCamera {
 public:
  /// What frames with that number were processed with; none: nobody knows any more.
  using SetupOf = std::function<std::optional<ClipSetup>(std::uint32_t number)>;
  /// `every_nth`: which frames are kept on purpose.
  ClipCamera(int id, int every_nth, SetupOf setup_of)
      : id_(id), every_nth_(static_cast<std::uint32_t>(every_nth)), setup_of_(std::move(setup_of)) {}

  /// The next frame. False: it is not for the clip, because nothing it needs is there. Throws StorageError.
  bool write(ClipWriter& writer, const ClipFrame& frame);
  /// The frame before the next one was lost: parts need a whole image again.
  void lack_one() { lacks_whole_ = true; }
  /// Throws StorageError.
  void note_missing(ClipWriter& writer, std::uint64_t frames);

  bool has_begun() const { return has_begun_; }
  std::uint64_t missing() const { return missing_; }

 private:
  const int id_;
  const std::uint32_t every_nth_;
  const SetupOf setup_of_;
  std::map<std::uint32_t, std::uint32_t> setups_;  // its number -> place in the clip
  std::optional<std::uint32_t> last_number_;       // of the frame before
  bool has_begun_ = false;
  bool lacks_whole_ = true;  // the image that parts are of
  ImageView whole_;          // its size and format
  std::uint64_t missing_ = 0;
};

}  // namespace sslv
