// SPDX-License-Identifier: Apache-2.0
#include "health/metrics_text.h"

#include <cmath>

#include <fmt/format.h>

namespace sslv {
namespace {

std::string escaped(std::string_view text, bool is_label) {
  std::string out;
  for (const char c : text) {
    if (c == '\n') {
      out += "\\n";
    } else {
      if (c == '\\' || (is_label && c == '"')) out += '\\';
      out += c;
    }
  }
  return out;
}

std::string number_text(double value) {
  if (std::isnan(value)) return "NaN";
  if (std::isinf(value)) return value > 0 ? "+Inf" : "-Inf";
  return fmt::format("{}", value);
}

}  // namespace

void MetricsText::begin(std::string_view name, std::string_view type, std::string_view help) {
  name_ = name;
  head_ = fmt::format("# HELP {0} {1}\n# TYPE {0} {2}\n", name, escaped(help, false), type);
}

void MetricsText::add(Labels labels, std::uint64_t value) {
  sample("", labels, "", std::to_string(value));
}

void MetricsText::add(Labels labels, double value) {
  sample("", labels, "", number_text(value));
}

void MetricsText::add(Labels labels, const DurationTotals::Reading& durations) {
  std::uint64_t count = 0;
  for (std::size_t i = 0; i < durations.counts.size(); ++i) {
    count += durations.counts[i];
    const auto& ends = DurationTotals::kEnds_ns;
    // Division instead of multiplication gives the double nearest to the decimal number, which has the
    // shortest text.
    const std::string le = i < ends.size() ? number_text(static_cast<double>(ends[i]) / 1e9) : "+Inf";
    sample("_bucket", labels, le, std::to_string(count));
  }
  sample("_sum", labels, "", number_text(static_cast<double>(durations.sum_ns) / 1e9));
  sample("_count", labels, "", std::to_string(count));
}

void MetricsText::sample(std::string_view suffix, Labels labels, std::string_view le,
                         std::string_view value) {
  text_ += std::exchange(head_, {});
  text_ += name_;
  text_ += suffix;
  char before = '{';
  const auto add_label = [&](std::string_view name, std::string_view text) {
    text_ += fmt::format("{}{}=\"{}\"", std::exchange(before, ','), name, escaped(text, true));
  };
  for (const Label& label : labels) add_label(label.name, label.value);
  if (!le.empty()) add_label("le", le);
  if (before == ',') text_ += '}';
  text_ += fmt::format(" {}\n", value);
}

}  // namespace sslv
