// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/duration_totals.h"

#include <cstdint>
#include <initializer_list>
#include <string>
#include <string_view>
#include <utility>

namespace sslv {

/// Writes the text format of Prometheus, 0.0.4. Call begin() for a family, then add() for its samples.
class MetricsText {
 public:
  struct Label {
    std::string_view name, value;
  };
  using Labels = std::initializer_list<Label>;

  /// Starts a family. `type`: "counter", "gauge" or "histogram". A family without samples is left out.
  void begin(std::string_view name, std::string_view type, std::string_view help);
  void add(Labels labels, std::uint64_t value);
  void add(Labels labels, double value);
  /// Adds all buckets, the sum and the count. Durations are in seconds.
  void add(Labels labels, const DurationTotals::Reading& durations);

  std::string take() { return std::move(text_); }

 private:
  void sample(std::string_view suffix, Labels labels, std::string_view le, std::string_view value);

  std::string text_, name_;
  std::string head_;  // the family's HELP and TYPE, until its first sample
};

}  // namespace sslv
