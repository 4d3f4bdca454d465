// SPDX-License-Identifier: Apache-2.0
#include "lab/accuracy.h"

#include <algorithm>
#include <string_view>
#include <utility>

#include <fmt/format.h>

namespace sslv {
namespace {

using TextRows = std::vector<std::vector<std::string>>;  // the first row is the header

/// Columns before `numbers_from` hold text.
std::string rows_text(const TextRows& table, std::size_t numbers_from, bool markdown) {
  std::vector<std::size_t> widths(table.front().size());
  for (const auto& row : table) {
    for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], row[i].size());
  }
  std::string out;
  for (const auto& row : table) {
    for (std::size_t i = 0; i < row.size(); ++i) {
      const bool is_number = i >= numbers_from;
      if (markdown) {
        out += (i == 0 ? "| " : " | ") + row[i];
      } else {
        if (i > 0) out += "  ";
        out +=
            is_number ? fmt::format("{:>{}}", row[i], widths[i]) : fmt::format("{:<{}}", row[i], widths[i]);
      }
    }
    if (!markdown) out.erase(out.find_last_not_of(' ') + 1);
    out += markdown ? " |\n" : "\n";
    if (markdown && &row == &table.front()) {
      for (std::size_t i = 0; i < row.size(); ++i) out += i >= numbers_from ? "|---:" : "|---";
      out += "|\n";
    }
  }
  return out;
}

std::string name_of(AccuracyColors colors) {
  const auto found = std::find_if(kAccuracyColorsChoices.begin(), kAccuracyColorsChoices.end(),
                                  [&](const auto& choice) { return choice.value == colors; });
  return std::string(found->name);
}

std::string number_or_dash(std::size_t count, double value, int digits) {
  return count == 0 ? "-" : fmt::format("{:.{}f}", value, digits);
}

Json json_of(const std::array<Reliability::Bin, Reliability::kBins>& bins) {
  Json out = Json::array();
  for (const Reliability::Bin& bin : bins) out.push_back({{"count", bin.count}, {"right", bin.right}});
  return out;
}

/// Results over the course of films.
TextRows film_table(const AccuracyReport& report) {
  TextRows table{{"condition", "format", "second", "robots", "recall", "wrong id", "false", "balls",
                  "ball recall", "red", "green", "blue", "darkest", "brightest"}};
  for (const AccuracyRow& row : report.rows) {
    for (const AccuracyRow::Stretch& part : row.film) {
      const auto [r, g, b] = part.change.gain;
      table.push_back({row.condition, row.pixel_format, fmt::format("{:g}", part.begin_s),
                       std::to_string(part.robots.expected),
                       number_or_dash(part.robots.expected, part.robots.recall(), 4),
                       std::to_string(part.robots.wrong_id), std::to_string(part.robots.invented),
                       std::to_string(part.balls.expected),
                       number_or_dash(part.balls.expected, part.balls.recall(), 4), fmt::format("{:.2f}", r),
                       fmt::format("{:.2f}", g), fmt::format("{:.2f}", b),
                       fmt::format("{:.2f}", part.change.darkest_area),
                       fmt::format("{:.2f}", part.change.brightest_area)});
    }
  }
  return table;
}

}  // namespace

std::string accuracy_text(const AccuracyReport& report, bool markdown) {
  TextRows table{{"condition", "format", "table", "px/mm", "robots", "recall", "wrong id", "false",
                  "robot mm", "degrees", "mm / bound", "degrees / bound", "balls", "ball recall", "precision",
                  "ball mm", "false balls in 100", ""}};
  std::string failures;
  const auto ratio = [](const std::optional<double>& value) {
    return value ? fmt::format("{:.2f}", *value) : "-";
  };
  for (const AccuracyRow& row : report.rows) {
    const Score& s = row.score;
    table.push_back(
        {row.condition, row.pixel_format, name_of(row.colors), fmt::format("{:.3f}", row.px_per_mm),
         std::to_string(s.robots.expected), number_or_dash(s.robots.expected, s.robots.recall(), 4),
         std::to_string(s.robots.wrong_id), std::to_string(s.robots.invented),
         number_or_dash(s.robot_position_mm.count, s.robot_position_mm.rms, 3),
         number_or_dash(s.robot_orientation_deg.count, s.robot_orientation_deg.rms, 3),
         ratio(row.position_over_bound()), ratio(row.orientation_over_bound()),
         std::to_string(s.balls.expected), number_or_dash(s.balls.expected, s.balls.recall(), 4),
         number_or_dash(s.balls.found + s.balls.wrong_id + s.balls.invented, s.balls.precision(), 4),
         number_or_dash(s.ball_position_mm.count, s.ball_position_mm.rms, 3),
         number_or_dash(s.frames_compared, false_balls_in_100(s), 1), row.failures.empty() ? "" : "FAILED"});
    for (const std::string& failure : row.failures) {
      failures += fmt::format("{}{}, {}, {}: {}\n", markdown ? "- " : "", row.condition, row.pixel_format,
                              name_of(row.colors), failure);
    }
  }
  std::string out = rows_text(table, 3, markdown);
  if (!failures.empty()) out += "\n" + failures;

  const auto film = film_table(report);
  if (film.size() > 1) out += "\n" + rows_text(film, 2, markdown);

  TextRows reliability{{"confidence", "robots", "right", "balls", "right"}};
  for (std::size_t i = 0; i < Reliability::kBins; ++i) {
    const auto& robots = report.reliability.robots[i];
    const auto& balls = report.reliability.balls[i];
    const auto share = [](const Reliability::Bin& bin) {
      return number_or_dash(bin.count, static_cast<double>(bin.right) / static_cast<double>(bin.count), 3);
    };
    reliability.push_back({fmt::format("{:.1f} - {:.1f}", static_cast<double>(i) / Reliability::kBins,
                                       static_cast<double>(i + 1) / Reliability::kBins),
                           std::to_string(robots.count), share(robots), std::to_string(balls.count),
                           share(balls)});
  }
  return out + "\n" + rows_text(reliability, 1, markdown);
}

Json accuracy_json(const AccuracyReport& report) {
  Json rows = Json::array();
  for (const AccuracyRow& row : report.rows) {
    Json one{{"condition", row.condition},
             {"pixel_format", row.pixel_format},
             {"colors", name_of(row.colors)},
             {"px_per_mm", row.px_per_mm},
             {"false_balls_in_100", false_balls_in_100(row.score)},
             {"position_over_bound", nullptr},
             {"orientation_over_bound", nullptr},
             {"failures", row.failures}};
    if (const auto value = row.position_over_bound()) one["position_over_bound"] = *value;
    if (const auto value = row.orientation_over_bound()) one["orientation_over_bound"] = *value;
    one.update(score_json(row.score));
    rows.push_back(std::move(one));
  }
  return {{"passed", report.passed()},
          {"rows", rows},
          {"reliability",
           {{"robots", json_of(report.reliability.robots)}, {"balls", json_of(report.reliability.balls)}}}};
}

}  // namespace sslv
