// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/snapshot.h"
#include "net/referee_listener.h"
#include "services/service.h"
#include "services/verdict/coverage.h"
#include "services/verdict/field_watch.h"

#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace sslv {

/// Judges from the cameras' images whether the field is ready to play: robots, painted lines, agreement of
/// the cameras, coverage.
class VerdictService final : public Service, public CameraObserver {
 public:
  /// All must outlive this.
  VerdictService(const Snapshot<Config>& config, Cameras& cameras, const RefereeListener& referee);

  void ask_to_stop() override { watch_.ask_to_stop(); }
  void cameras_changed(const std::set<int>& camera_ids) noexcept override;

  void report(HealthReport& report) const override;
  void each_second() override;

 private:
  void expect_nothing_of_replaced_cameras();

  const Snapshot<Config>& config_;
  Cameras& cameras_;
  const RefereeListener& referee_;
  /// Start of the running match.
  struct MatchSince {
    double unix_s = 0, steady_s = 0;
  };

  Snapshot<std::optional<MatchSince>> match_since_{std::optional<MatchSince>()};
  std::mutex devices_mutex_;
  std::map<int, std::string> devices_;  // by camera id: see device_of()
  Snapshot<Coverage> coverage_{Coverage{}};
  /// Inputs from which a camera's part of the coverage was computed.
  struct CoveredBy {
    int id = 0;
    std::shared_ptr<const Scene> scene;
    std::shared_ptr<const Mask> mask, stage_mask;
    bool is_running = false;
    int width_px = 0, height_px = 0;
    bool operator==(const CoveredBy&) const = default;
  };
  std::vector<CoveredBy> covered_by_;  // used by the thread of each_second() only
  FieldWatch watch_;                   // last: its thread uses the cameras
};

}  // namespace sslv
