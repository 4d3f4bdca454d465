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

/// What the field's alerts are made of.
struct FieldFacts {
  std::shared_ptr<const Config> config;
  AgreementNow agreement;
  const AgreementHistory* history = nullptr;  // null: nothing is known of the time before
  LeftOut left_out;
  std::uint64_t images_off_time_lately = 0;  // in the last ten seconds
  double now_s = 0;                          // Unix time
  std::string sending_error;                 // why tracks do not leave; empty: they do, or are not to
  bool some_leave = false;                   // as MulticastStatus says
  std::vector<HeardCameras::Conflict> conflicts;
  StackFacts stack{};          // of the field
  std::optional<Hang> hang{};  // of its thread
  std::int64_t now_ns = 0;     // of steady_ns()
};

void report_field(const FieldFacts& facts, HealthReport& report);

}  // namespace sslv
