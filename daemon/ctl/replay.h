// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"
#include "replay/compare_clip.h"
#include "replay/export_clip.h"
#include "replay/replay_clip.h"

#include <cstdint>
#include <filesystem>
#include <iosfwd>
#include <optional>
#include <string>
#include <vector>

namespace sslv {

/// What a clip holds, as JSON and for a terminal.
Json clip_info_json(const std::filesystem::path& file, const ClipReader& clip);
std::string clip_info_text(const Json& info);

struct ReplayCommand {
  std::optional<std::uint32_t> camera_id{};  // none: every camera of the clip
  ClipSpan span{};
  std::optional<OtherSetup> other{};
  bool compares = false;
  CompareLimits limits{};
  std::ostream* found = nullptr;  // a JSON line for each frame, as `process` writes them
};

/// What a replay of one camera came to.
struct ReplayedCamera {
  std::uint32_t camera_id = 0;
  std::uint64_t frames = 0, exact = 0;
  std::uint64_t processed = 0;  // also those before the span
  double clip_s = 0;            // from the first frame that was processed to the last
  double took_s = 0;            // reading them and all
  std::vector<std::string> doubts{};
  std::optional<ClipComparison> comparison{};
  bool differs = false;
};

/// One camera after the other. What is compared: the packets that were sent live with those of the replay;
/// or, with other settings, those of a replay with the clip's own settings. Live packets differ when one byte
/// does, others when things do by more than the limits. Throws ClipError and SettingsError.
std::vector<ReplayedCamera> replay_cameras(ClipReader& clip, const ReplayCommand& command);

Json replayed_json(const std::vector<ReplayedCamera>& cameras);
std::string replayed_text(const std::vector<ReplayedCamera>& cameras, bool with_other_settings);

std::string exported_text(const std::vector<ExportedCamera>& cameras);

}  // namespace sslv
