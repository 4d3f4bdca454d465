// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

namespace sslv {

/// Weighted root mean square; 0 without values.
class Rms {
 public:
  void add(double value, double weight = 1) {
    squares_ += weight * value * value;
    weights_ += weight;
  }
  double value() const { return weights_ > 0 ? std::sqrt(squares_ / weights_) : 0; }

 private:
  double squares_ = 0, weights_ = 0;
};

inline double rms(std::span<const double> values) {
  Rms out;
  for (const double value : values) out.add(value);
  return out.value();
}

/// For an even number of values, the upper of the middle two; 0 without values.
inline double median(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace sslv
