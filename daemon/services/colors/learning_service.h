// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "services/cameras/pictures.h"
#include "services/colors/color_learning.h"
#include "services/colors/color_service.h"
#include "services/service.h"

#include <memory>
#include <set>
#include <vector>

namespace sslv {

/// Learns colours from frames, shows the result, and accepts or rejects it.
class LearningService final : public Service, public CameraObserver {
 public:
  /// All must outlive this.
  LearningService(Cameras& cameras, Pictures& pictures, ColorTables& tables, ColorService& colors);

  void ask_to_stop() override { jobs_.ask_to_stop(); }
  void cameras_changed(const std::set<int>& camera_ids) noexcept override;
  std::vector<Route> routes() override;

  /// The camera's learnt table that is not accepted yet; null: there is none.
  std::shared_ptr<const Lut> learnt_table(int camera_id) const;

 private:
  Json state_json(int camera_id) const;
  /// Report of a finished job. Throws HttpError 409 when there is none.
  std::shared_ptr<const LearningReport> report_of(int camera_id) const;
  Response start(const Request& request);
  Response cancel(const Request& request);
  Response accept(const Request& request);
  Response reject(const Request& request);
  Response get_picture(const Request& request);

  Cameras& cameras_;
  Pictures& pictures_;
  ColorTables& tables_;
  ColorService& colors_;
  ColorLearning jobs_;  // last: its threads use the members above
};

}  // namespace sslv
