// SPDX-License-Identifier: Apache-2.0
#pragma once

// Requests and JSON common to the calibration of one camera and of several.

#include "base/background_jobs.h"
#include "base/params_json.h"
#include "services/access/match_lock.h"
#include "web/route.h"

#include <string>
#include <tuple>
#include <vector>

namespace sslv {

struct ForceOption {
  bool force = false;
  static constexpr auto fields() {
    return std::tuple{flag("force", &ForceOption::force, "do it even if it would otherwise be refused")};
  }
};

/// Reads `force` from a body without other keys.
bool force_of(const Request& request);
/// Removes `force` from a body with other keys and returns it.
bool take_force(Json& body);

/// Throws HttpError: 423 while the game runs, 409 for a report that is not good enough. `what`: subject and
/// verb of the message.
void refuse_acceptance(MatchLock& match_lock, bool is_good, const std::vector<std::string>& problems,
                       const std::string& what);

inline constexpr const char* kOrForce = ", or do it anyway (force)";

/// The part of the newest job's JSON that all kinds of calibration have in common.
template <class Job>
Json job_json(const Job& job) {
  return {{"state", name_of(job.state)},
          {"frames_taken", job.frames},
          {"problem", job.problem},
          {"started", job.order ? Json(job.order->time_s) : Json(nullptr)},
          {"who", job.order ? job.order->who : ""},
          {"request", job.order ? params_to_json(job.order->request) : Json(nullptr)},
          {"report", job.report ? report_json(*job.report) : Json(nullptr)}};
}

}  // namespace sslv
