// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "rival.h"
#include "world.h"

#include <map>
#include <string>
#include <vector>

namespace sslv::worlds {

/// Errors of one kind. Root mean squares alone would hide that something was far off for a short time.
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

/// What came out of some worlds.
struct Score {
  std::map<std::string, Errors> errors;
  std::map<std::string, double> counts;
  double scored_s = 0;  // time that was scored

  void append(const Score& other);
  double a_minute(const std::string& count) const;
};

/// What is off of robots and of the ball as they are known so much later.
Score score_later(const World& world, double lag_s);

/// Shows a world's images to a rival, and compares what it says when its packet leaves.
Score score(const World& world, Rival& rival);

}  // namespace sslv::worlds
