// SPDX-License-Identifier: Apache-2.0
#include "colors/name_dots.h"

#include "base/statistics.h"
#include "vision/color_name.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <numeric>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace sslv {
namespace {

/// Two groups are the same if their chromaticities are nearer than this, or nearer than this multiple of
/// their spread.
constexpr double kMinApart = 0.15, kMinApartPerSpread = 3.2;
/// Smallest cosine between the differences of seen colours and the differences of prints.
constexpr double kMinAlike = 0.4;
/// For name_some(): largest distance to the nearest print, over the distance to the second nearest print.
constexpr double kClearlyNearest = 0.6;
const Color3 kPrintedBlack(26, 26, 29);

struct Groups {
  std::vector<Color3> means;
  std::vector<std::size_t> of;  // index of each colour's group
  double spread = 0;
};

double distance(const SeenDot& dot, const Color3& chromaticity) {
  return (chromaticity_of(unclipped_contrast(dot, chromaticity)) - chromaticity).norm();
}

std::size_t nearest(const std::vector<Color3>& means, const SeenDot& dot) {
  std::size_t best = 0;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < means.size(); ++k) {
    const double away = distance(dot, means[k]);
    if (away >= least) continue;
    least = away;
    best = k;
  }
  return best;
}

/// Median chromaticity of the unclipped dots or, if fewer than a third of the dots are unclipped, of the
/// dimmest third, which is clipped least.
Color3 typical_shares(std::vector<const SeenDot*> dots) {
  const auto is_clipped = [](const SeenDot* dot) { return dot->color.maxCoeff() >= kClippedGrey; };
  const auto clipped = std::stable_partition(dots.begin(), dots.end(), std::not_fn(is_clipped));
  const auto whole = static_cast<std::size_t>(clipped - dots.begin()), third = (dots.size() + 2) / 3;
  if (whole < third) {
    std::sort(dots.begin(), dots.end(),
              [](const SeenDot* a, const SeenDot* b) { return a->contrast.sum() < b->contrast.sum(); });
  }
  dots.resize(std::max(whole, third));
  Color3 out;
  for (Eigen::Index c = 0; c < 3; ++c) {
    std::vector<double> values;
    for (const SeenDot* dot : dots) values.push_back(chromaticity_of(dot->contrast)[c]);
    out[c] = median(std::move(values));
  }
  return out;
}

/// One run of k-means, with medians, from `starts`. Returns the sum of all distances.
double group_from(std::span<const SeenDot> colors, std::vector<Color3> starts, Groups& out) {
  const std::size_t count = starts.size();
  out.means = std::move(starts);
  out.of.assign(colors.size(), 0);
  constexpr int kRounds = 10;
  for (int round = 0; round < kRounds; ++round) {
    for (std::size_t i = 0; i < colors.size(); ++i) out.of[i] = nearest(out.means, colors[i]);
    for (std::size_t k = 0; k < count; ++k) {
      std::vector<const SeenDot*> members;
      for (std::size_t i = 0; i < colors.size(); ++i) {
        if (out.of[i] == k) members.push_back(&colors[i]);
      }
      if (!members.empty()) out.means[k] = typical_shares(std::move(members));
    }
  }
  std::vector<double> off;
  for (std::size_t i = 0; i < colors.size(); ++i) off.push_back(distance(colors[i], out.means[out.of[i]]));
  const double sum = std::accumulate(off.begin(), off.end(), 0.0);
  out.spread = median(std::move(off));
  return sum;
}

/// Best result of several runs, so that one odd colour does not form a group. Deterministic.
Groups group(std::span<const SeenDot> colors, std::size_t count) {
  constexpr int kRuns = 24;
  Groups best;
  double least = std::numeric_limits<double>::infinity();
  std::uint32_t random = 1;
  for (int run = 0; run < kRuns; ++run) {
    std::vector<Color3> starts;
    for (std::size_t k = 0; k < count; ++k) {
      random = random * 1664525 + 1013904223;
      starts.push_back(chromaticity_of(colors[(random >> 8) % colors.size()].contrast));
    }
    Groups one;
    const double sum = group_from(colors, std::move(starts), one);
    if (sum >= least) continue;
    least = sum;
    best = std::move(one);
  }
  return best;
}

/// Forms the largest number of distinct groups, at most `most`.
Groups distinct_groups(std::span<const SeenDot> colors, std::size_t most) {
  for (std::size_t count = std::min(most, colors.size()); count > 1; --count) {
    Groups out = group(colors, count);
    double apart = std::numeric_limits<double>::infinity();
    for (std::size_t a = 0; a < count; ++a) {
      for (std::size_t b = 0; b < a; ++b) apart = std::min(apart, (out.means[a] - out.means[b]).norm());
    }
    if (apart > std::max(kMinApart, kMinApartPerSpread * out.spread)) return out;
  }
  return group(colors, 1);
}

Color3 printed_contrast(Label label) {
  return (print_color(label) - kPrintedBlack).cwiseMax(1);
}

/// Expected chromaticity of a label: from the samples that the user pointed at, or else from the label's
/// print and the light's gains.
Color3 expected_shares(Label label, const Color3& gains, std::span<const ColorSample> guide,
                       const Color3& black) {
  Color3 sum = Color3::Zero();
  for (const ColorSample& sample : guide) {
    if (sample.label == label) sum += Color3(sample.color.r, sample.color.g, sample.color.b) - black;
  }
  if (sum.sum() > 0) return chromaticity_of(sum);
  return chromaticity_of(printed_contrast(label).cwiseProduct(gains));
}

/// For as many groups as labels: names the groups by their differences, which a colour cast hardly changes.
/// Empty if the differences do not match the labels' differences.
std::vector<Label> name_all(const std::vector<Color3>& means, std::span<const Label> labels,
                            std::span<const Color3> expected) {
  const std::size_t count = means.size();
  Color3 seen_middle = Color3::Zero(), expected_middle = Color3::Zero();
  for (std::size_t i = 0; i < count; ++i) {
    seen_middle += means[i] / static_cast<double>(count);
    expected_middle += expected[i] / static_cast<double>(count);
  }
  std::vector<std::size_t> order(count), best_order;
  std::iota(order.begin(), order.end(), 0);
  double best = 0, seen2 = 0, expected2 = 0;
  for (std::size_t i = 0; i < count; ++i) {
    seen2 += (means[i] - seen_middle).squaredNorm();
    expected2 += (expected[i] - expected_middle).squaredNorm();
  }
  do {
    double alike = 0;
    for (std::size_t i = 0; i < count; ++i)
      alike += (means[i] - seen_middle).dot(expected[order[i]] - expected_middle);
    if (alike > best) {
      best = alike;
      best_order = order;
    }
  } while (std::next_permutation(order.begin(), order.end()));
  if (best < kMinAlike * std::sqrt(seen2 * expected2)) return {};
  std::vector<Label> out;
  for (const std::size_t at : best_order) out.push_back(labels[at]);
  return out;
}

/// For fewer groups than labels: names each group by its nearest label. Empty if a label is not clearly the
/// nearest, or is the nearest of two groups.
std::vector<Label> name_some(const std::vector<Color3>& means, std::span<const Label> labels,
                             std::span<const Color3> expected) {
  std::vector<Label> out;
  for (const Color3& mean : means) {
    double best = std::numeric_limits<double>::infinity(), second = best;
    Label name = label::kClear;
    for (std::size_t i = 0; i < labels.size(); ++i) {
      const double away = (mean - expected[i]).norm();
      if (away < best) {
        second = best;
        best = away;
        name = labels[i];
      } else {
        second = std::min(second, away);
      }
    }
    const bool taken = std::find(out.begin(), out.end(), name) != out.end();
    if (taken || best > kClearlyNearest * second) return {};
    out.push_back(name);
  }
  return out;
}

/// Gains of the light from dots of known labels: ratios of seen to printed chromaticities, weighted by the
/// printed chromaticities.
Color3 gains_from(const std::map<Label, Color3>& chromaticities) {
  Color3 sum = Color3::Zero(), weights = Color3::Zero();
  for (const auto& [label, seen] : chromaticities) {
    const Color3 printed = chromaticity_of(printed_contrast(label));
    Color3 logs;
    for (int c = 0; c < 3; ++c) logs[c] = std::log(std::max(seen[c], 0.02) / std::max(printed[c], 0.02));
    logs.array() -= logs.dot(printed);
    sum += printed.cwiseProduct(logs);
    weights += printed;
  }
  Color3 out = Color3::Ones();
  for (int c = 0; c < 3; ++c) {
    if (weights[c] > 0) out[c] = std::exp(sum[c] / weights[c]);
  }
  return out / out.mean();
}

std::string names_of(std::span<const Label> labels) {
  std::vector<std::string_view> names;
  for (const Label label : labels) names.push_back(label::kNames[label]);
  return fmt::format("{}", fmt::join(names, ", "));
}

}  // namespace

Color3 print_color(Label label) {
  switch (label) {
    case label::kField: return {30, 110, 40};
    case label::kOrange: return {235, 105, 25};
    case label::kYellow: return {225, 190, 30};
    case label::kBlue: return {28, 62, 185};
    case label::kPink: return {225, 70, 160};
    case label::kCyan: return {60, 190, 215};
    case label::kGreen: return {70, 215, 95};
    case label::kWhite: return {205, 208, 200};
    default: return kPrintedBlack;
  }
}

Color3 chromaticity_of(const Color3& contrast) {
  const Color3 positive = contrast.cwiseMax(0);
  const double sum = positive.sum();
  return sum > 1e-6 ? Color3(positive / sum) : Color3::Constant(1.0 / 3);
}

Color3 unclipped_contrast(const SeenDot& dot, const Color3& chromaticity) {
  const auto array = [](const Color3& color) { return std::array{color[0], color[1], color[2]}; };
  const auto out = unclipped(array(dot.contrast), array(dot.color), array(chromaticity));
  return {out[0], out[1], out[2]};
}

NamedDots name_dots(std::span<const SeenRobot> robots, const PatternTable& patterns,
                    std::span<const ColorSample> guide) {
  NamedDots out;
  Color3 black = Color3::Zero();
  std::vector<SeenDot> centers, sides;
  for (const SeenRobot& robot : robots) {
    black += robot.black / static_cast<double>(robots.size());
    for (std::size_t i = 0; i < robot.dots.size(); ++i) (i == 0 ? centers : sides).push_back(robot.dots[i]);
  }
  struct Kind {
    const char* what;
    std::span<const SeenDot> colors;
    std::span<const Label> labels;
    Groups groups;
    std::vector<Label> names;
  };
  std::array<Kind, 2> kinds{Kind{"side dots", sides, patterns.side_colors, {}, {}},
                            Kind{"centre dots", centers, patterns.team_colors, {}, {}}};
  const auto expected_of = [&](const Kind& kind) {
    std::vector<Color3> expected;
    for (const Label label : kind.labels) expected.push_back(expected_shares(label, out.gains, guide, black));
    return expected;
  };
  std::map<Label, Color3> seen;
  const auto note_names = [&](const Kind& kind) {
    for (std::size_t i = 0; i < kind.names.size(); ++i) seen[kind.names[i]] = kind.groups.means[i];
    out.gains = gains_from(seen);
  };
  // First names the kinds of dots whose colours are all present, because these provide the gains needed to
  // name a single group.
  for (Kind& kind : kinds) {
    kind.groups = distinct_groups(kind.colors, kind.labels.size());
    if (kind.groups.means.size() < kind.labels.size() || kind.labels.size() < 2) continue;
    kind.names = name_all(kind.groups.means, kind.labels, expected_of(kind));
    if (kind.names.empty()) {
      out.problem = fmt::format(
          "the {} have {} colours, but these do not differ like {}: does the pattern table match the robots? "
          "Point at one of each colour",
          kind.what, kind.labels.size(), names_of(kind.labels));
      return out;
    }
    note_names(kind);
  }
  for (Kind& kind : kinds) {
    if (!kind.names.empty()) continue;
    kind.names = name_some(kind.groups.means, kind.labels, expected_of(kind));
    if (kind.names.empty()) {
      out.problem = fmt::format(
          "only {1} of the {2} colours of the {0} ({3}) can be distinguished, and their names are unclear: "
          "put robots of both teams with different ids on the field, in even light, or point at the colours",
          kind.what, kind.groups.means.size(), kind.labels.size(), names_of(kind.labels));
      return out;
    }
    note_names(kind);
  }
  std::size_t next_side = 0, next_center = 0;
  for (const SeenRobot& robot : robots) {
    std::vector<Label> labels{kinds[1].names[kinds[1].groups.of[next_center++]]};
    for (std::size_t i = 1; i < robot.dots.size(); ++i)
      labels.push_back(kinds[0].names[kinds[0].groups.of[next_side++]]);
    out.labels.push_back(std::move(labels));
  }
  for (const Kind& kind : kinds) {
    for (const Label label : kind.labels) {
      if (const auto chromaticity = seen.find(label); chromaticity != seen.end())
        out.chromaticities[label] = chromaticity->second;
      if (seen.contains(label) || std::find(out.unseen.begin(), out.unseen.end(), label) != out.unseen.end())
        continue;
      out.unseen.push_back(label);
    }
  }
  return out;
}

}  // namespace sslv
