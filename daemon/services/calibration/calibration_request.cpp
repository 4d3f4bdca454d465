// SPDX-License-Identifier: Apache-2.0
#include "services/calibration/calibration_request.h"

#include <fmt/format.h>

namespace sslv {

bool force_of(const Request& request) {
  return params_from_json<ForceOption>(body_json(request), "").force;
}

bool take_force(Json& body) {
  if (!body.is_object() || !body.contains("force")) return false;
  const bool force = params_from_json<ForceOption>(Json{{"force", body["force"]}}, "").force;
  body.erase("force");
  return force;
}

void refuse_acceptance(MatchLock& match_lock, bool is_good, const std::vector<std::string>& problems,
                       const std::string& what) {
  match_lock.refuse_if_locked(kOrForce);
  if (is_good) return;
  throw HttpError(409, fmt::format("{} not good enough: {} You can accept it anyway (force).", what,
                                   problems.empty() ? "see the figures." : problems.front()));
}

}  // namespace sslv
