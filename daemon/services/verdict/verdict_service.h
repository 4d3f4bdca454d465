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

/// Whether this field can play, by what is seen on it: robots, painted lines, how well cameras agree, what
/// none of them looks at.
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
  /// Since when a match runs; none does: nothing.
  struct MatchSince {
    double unix_s = 0, steady_s = 0;
  };

  Snapshot<std::optional<MatchSince>> match_since_{std::optional<MatchSince>()};
  std::mutex devices_mutex_;
  std::map<int, std::string> devices_;  // by camera id: see device_of()
  Snapshot<Coverage> coverage_{Coverage{}};
  /// What a camera's part of it was computed of.
  struct CoveredBy {
    int id = 0;
    std::shared_ptr<const Scene> scene;
    std::shared_ptr<const Mask> mask, stage_mask;
    bool is_running = false;
    int width_px = 0, height_px = 0;
    bool operator==(const CoveredBy&) const = default;
  };
  std::vector<CoveredBy> covered_by_;  // of the thread of each_second()
  FieldWatch watch_;                   // last: it asks the cameras
};

}  // namespace sslv
