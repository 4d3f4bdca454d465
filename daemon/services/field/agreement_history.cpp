// SPDX-License-Identifier: Apache-2.0
#include "services/field/agreement_history.h"

#include <algorithm>

namespace sslv {
namespace {

constexpr double kMinute_s = 60, kUnknown_s = 600, kKept_s = 7200;

/// Returns the difference before it rose above kDriftMm: about two minutes ago, or the oldest known value if
/// that is newer. Returns nothing if it is unknown or was already above kDriftMm.
std::optional<double> before(const AgreementHistory::Pair& pair, double now_s) {
  constexpr double kGrows_s = 120;
  const AgreementHistory::Minute* out = nullptr;
  for (const AgreementHistory::Minute& minute : pair.minutes) {
    if (!out || minute.t_s < now_s - kGrows_s) out = &minute;
  }
  if (!out || out->off_mm > kDriftMm) return {};
  return out->off_mm;
}

}  // namespace

void AgreementHistory::add(const std::vector<CameraPairNow>& pairs, double now_s) {
  for (const CameraPairNow& now : pairs) {
    Pair& pair = pairs_[std::minmax(now.camera, now.other)];
    // Start over if the clock was set back.
    if (now_s < pair.t_s) pair = {};
    if (!pair.since_s && now.off_mm > kDriftMm) {
      pair.since_s = now_s;
      pair.before_mm = before(pair, now_s);
    } else if (now.off_mm < kAgreeMm) {
      pair.since_s.reset();
    }
    pair.t_s = now_s;
    pair.off_mm = now.off_mm;
    if (!pair.minutes.empty() && now_s - pair.minutes.back().t_s < kMinute_s) continue;
    pair.minutes.push_back({now_s, now.off_mm});
  }
  for (auto& [cameras, pair] : pairs_) {
    while (!pair.minutes.empty() && now_s - pair.minutes.front().t_s > kKept_s) pair.minutes.pop_front();
    // Too old: the cameras may have been calibrated since.
    if (now_s - pair.t_s > kUnknown_s) pair.since_s.reset();
  }
  std::erase_if(pairs_, [&](const auto& one) { return now_s - one.second.t_s > kKept_s; });
}

const AgreementHistory::Pair* AgreementHistory::of(int camera, int other) const {
  const auto found = pairs_.find(std::minmax(camera, other));
  return found == pairs_.end() ? nullptr : &found->second;
}

Json AgreementHistory::to_json() const {
  Json out = Json::array();
  for (const auto& [cameras, pair] : pairs_) {
    Json minutes = Json::array();
    for (const Minute& minute : pair.minutes)
      minutes.push_back({{"time", minute.t_s}, {"off_mm", to_hundredths(minute.off_mm)}});
    out.push_back(
        {{"cameras", {cameras.first, cameras.second}},
         {"time", pair.t_s},
         {"off_mm", to_hundredths(pair.off_mm)},
         {"since", pair.since_s ? Json(*pair.since_s) : Json()},
         {"before_mm", pair.since_s && pair.before_mm ? Json(to_hundredths(*pair.before_mm)) : Json()},
         {"minutes", std::move(minutes)}});
  }
  return out;
}

}  // namespace sslv
