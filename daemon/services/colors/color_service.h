// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/snapshot.h"
#include "net/referee_listener.h"
#include "services/cameras/pictures.h"
#include "services/colors/color_margins.h"
#include "services/colors/color_tables.h"
#include "services/colors/follow_light.h"
#include "services/service.h"

#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace sslv {

/// Shows, edits, imports and exports colour tables, adapts them to the light, and reports their margins to
/// carpet and floor.
class ColorService final : public Service, public CameraObserver {
 public:
  /// All must outlive this.
  ColorService(Cameras& cameras, Pictures& pictures, ColorTables& tables, SavedTables& saved,
               const RefereeListener& referee);

  /// Colors in docs/openapi.json. Throws HttpError 404.
  Json state_json(int camera_id);

  void ask_to_stop() override {
    follow_light_.ask_to_stop();
    margins_.ask_to_stop();
  }
  void cameras_changed(const std::set<int>& camera_ids) noexcept override;
  std::vector<Route> routes() override;
  std::vector<SupportFile> support_files() const override;
  Plan plan(const SettingsChange& change) const override;
  void report(HealthReport& report) const override;
  void each_second() override;

 private:
  /// Faults of a camera's accepted table; see ColorFacts.
  struct TableFaults {
    std::shared_ptr<const Lut> lut;
    std::vector<std::string> missing, swapped;
  };
  static TableFaults faults_of(const std::shared_ptr<const Lut>& lut, const LabelSet& labels);

  Json state_json(const ColorTables::AtDesk& at);
  TableEdit read_command(const ColorTables::AtDesk& at, const Json& json, const std::string& path);
  TableEdit read_pick(const ColorTables::AtDesk& at, const Json& json, const std::string& path);
  Response edit(const Request& request);
  Response undo_or_redo(const Request& request, bool undo);
  Response reset(const Request& request);
  Response copy(const Request& request);
  Response import(const Request& request);
  Response export_table(const Request& request);
  Response revert_light(const Request& request);
  Response keep_light(const Request& request);

  Cameras& cameras_;
  Pictures& pictures_;
  ColorTables& tables_;
  SavedTables& saved_;
  Snapshot<std::map<int, TableFaults>> faults_{std::map<int, TableFaults>{}};  // by camera id
  FollowLight follow_light_;  // this and the next are last: their threads use the members above
  ColorMargins margins_;
};

}  // namespace sslv
