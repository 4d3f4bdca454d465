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

/// The content of a clip, as JSON and for a terminal.
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

/// Result of the replay of one camera.
struct ReplayedCamera {
  std::uint32_t camera_id = 0;
  std::uint64_t frames = 0, exact = 0;  // exact: frames with ClipReplay::Result::is_exact
  std::uint64_t processed = 0;          // including frames before the span
  double clip_s = 0;                    // time from the first replayed frame to the last
  double took_s = 0;                    // duration of the replay, including reading
  std::vector<std::string> doubts{};
  std::optional<ClipComparison> comparison{};
  bool differs = false;
};

/// Replays one camera after the other. Without other settings, compares the live packets with the replay's
/// packets: a camera differs if any byte differs. With other settings, compares a replay with the clip's own
/// settings with a replay with the other settings: a camera differs if robots or balls differ by more than
/// the limits. Throws ClipError and SettingsError.
std::vector<ReplayedCamera> replay_cameras(ClipReader& clip, const ReplayCommand& command);

Json replayed_json(const std::vector<ReplayedCamera>& cameras);
std::string replayed_text(const std::vector<ReplayedCamera>& cameras, bool with_other_settings);

std::string exported_text(const std::vector<ExportedCamera>& cameras);

}  // namespace sslv
