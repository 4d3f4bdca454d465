// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "rival.h"
#include "world.h"

#include <map>
#include <string>
#include <vector>

namespace sslv::worlds {

/// Errors of one kind. An rms alone would hide large errors of short duration.
class Errors {
 public:
  void add(double error);
  double rms() const;
  /// 0 <= share <= 1.
  double quantile(double share) const;
  std::size_t count() const { return values_.size(); }
  void append(const Errors& other);

 private:
  std::vector<float> values_;
  double squares_ = 0;
};

/// Results over some worlds.
struct Score {
  std::map<std::string, Errors> errors;
  std::map<std::string, double> counts;
  double scored_s = 0;  // scored time

  void append(const Score& other);
  double a_minute(const std::string& count) const;
};

/// Errors of robots and ball as estimated with a delay of `lag_s`.
Score score_later(const World& world, double lag_s);

/// Runs a tracker on a world's images and scores its estimates at the times when its packets leave.
Score score(const World& world, Rival& rival);

}  // namespace sslv::worlds
