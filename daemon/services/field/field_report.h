// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "config/config.h"
#include "net/heard_cameras.h"
#include "services/field/agreement_history.h"
#include "services/field/agreement_now.h"
#include "services/health_report.h"
#include "services/stage_report.h"
#include "tracking/gather.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace sslv {

/// Input of report_field().
struct FieldFacts {
  std::shared_ptr<const Config> config;
  AgreementNow agreement;
  const AgreementHistory* history = nullptr;  // null: no history
  LeftOut left_out;
  std::uint64_t images_off_time_lately = 0;  // in the last ten seconds
  double now_s = 0;                          // Unix time
  std::string sending_error;  // why tracks cannot be sent; empty: they are sent, or sending is off
  bool some_leave = false;    // see MulticastStatus
  std::vector<HeardCameras::Conflict> conflicts;
  std::vector<HeardCameras::Uncalibrated> uncalibrated{};
  StackFacts stack{};          // the field's stack
  std::optional<Hang> hang{};  // hang of the field's thread
  std::int64_t now_ns = 0;     // time of steady_ns()
};

void report_field(const FieldFacts& facts, HealthReport& report);

}  // namespace sslv
