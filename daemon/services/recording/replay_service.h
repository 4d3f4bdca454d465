// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "clips/clip_reader.h"
#include "image/jpeg.h"
#include "recording/match_moment.h"
#include "replay/compare_clip.h"
#include "services/cameras/cameras.h"
#include "services/recording/recording_files.h"
#include "services/service.h"

#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

namespace sslv {

/// Serves recordings to the panel frame by frame: clients select the frame and keep track of the time. Also
/// compares detections made with other settings in a clip's frames with the live detections, in a thread of
/// low priority.
class ReplayService final : public Service {
 public:
  /// The camera's learnt colour table that is not accepted yet; null: there is none.
  using LearntTable = std::function<std::shared_ptr<const Lut>(int camera_id)>;

  /// All must outlive this.
  ReplayService(const Snapshot<Config>& config, const RecordingFiles& files, Cameras& cameras,
                LearntTable learnt_table);

  // Service
  void ask_to_stop() override { thread_.request_stop(); }
  std::vector<Route> routes() override;

 private:
  /// A recording in use by clients, kept open for a while.
  template <class Reader>
  struct Open {
    std::mutex mutex;  // one client at a time opens and reads; guards `reader`
    std::unique_ptr<Reader> reader{};
  };
  template <class Reader>
  struct OpenOne {
    std::string name;
    // Size and time show whether the file was replaced.
    std::uint64_t bytes = 0;
    std::filesystem::file_time_type written{};
    double used_s = 0;  // on the steady clock
    std::shared_ptr<Open<Reader>> open{};
  };
  static constexpr std::size_t kMaxOpen = 4;
  template <class Reader>
  std::shared_ptr<Open<Reader>> opened(std::vector<OpenOne<Reader>>& list, const RecordingFile& file);
  template <class Reader>
  void close_unused(std::vector<OpenOne<Reader>>& list);
  void close_unused();
  /// Returns use(reader); opens the reader first if necessary. Throws HttpError if the clip cannot be read.
  template <class Use>
  Response with_clip(const RecordingFile& file, const std::stop_token& stop, const Use& use);

  enum class With { kRecordedSettings, kSettingsNow, kLearntColors };
  struct Comparison {
    enum class State { kIdle, kRunning, kDone, kFailed };
    State state = State::kIdle;
    std::string clip{};
    int camera_id = 0;
    With with = With::kRecordedSettings;
    std::shared_ptr<const Lut> table{};
    std::uint64_t done = 0, frames = 0;
    std::string error{};
    Json result = nullptr;
  };
  void compare(const std::stop_token& stop);
  Json compared(const Comparison& order, const std::stop_token& stop);

  RecordingFile find(const Request& request, RecordingFile::Kind kind) const;
  Response get_frames(const Request& request);
  Response get_frame(const Request& request);
  Response get_picture(const Request& request);
  Response get_moment(const Request& request);
  Response start_comparison(const Request& request);
  Json comparison_state() const;

  const Snapshot<Config>& config_;
  const RecordingFiles& files_;
  Cameras& cameras_;
  const LearntTable learnt_table_;
  std::mutex open_mutex_;  // guards the next two
  std::vector<OpenOne<ClipReader>> clips_;
  std::vector<OpenOne<MatchMoments>> logs_;
  mutable std::mutex mutex_;  // guards comparison_
  Comparison comparison_;
  std::condition_variable_any ordered_;
  double looked_s_ = 0;  // when unused recordings were last closed, on the steady clock; used by the thread
  std::jthread thread_;  // last: the thread uses the members above
};

}  // namespace sslv
