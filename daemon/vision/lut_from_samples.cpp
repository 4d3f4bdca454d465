// SPDX-License-Identifier: Apache-2.0
#include "vision/lut_from_samples.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include <Eigen/Core>

namespace sslv {
namespace {

using Color = Eigen::Vector3f;  // red, green, blue; unlike Rgb it may lie outside the cube

constexpr float kToleranceShare = 0.07F, kToleranceGrey = 1.5F;
constexpr float kMinNoise = 4, kNoisePerSpread = 2;  // pixels are noisier than averaged samples
constexpr float kNoisePerPixelNoise = 0.67F;
constexpr float kLimit = 4;  // in tolerances
/// Range of light for surfaces and prints, relative to their samples.
constexpr float kSurfaceDarkest = 0.5F, kSurfaceBrightest = 1.45F, kColorBrightest = 1.6F;
// Most of an image is background, so background wins in doubt. The distance in tolerances is multiplied by
// the factor; the handicap is added to its square.
constexpr float kBackgroundFactor = 0.85F, kColorHandicap = 0.5F, kMoreLightHandicap = 0.75F,
                kGuessHandicap = 1, kEdgeHandicap = 0.2F;

/// Differences in chromaticity (shares of red, green and blue): kSamePrint between prints of one maker,
/// kShine between a ball and the highlight on it.
constexpr float kSamePrint = 0.02F, kShine = 0.06F;

float brightness(const Color& color) {
  return color.sum() / 3;
}

Color in_cube(const Color& color) {
  return color.cwiseMax(0).cwiseMin(255);
}

/// A colour in weak, medium and strong light.
struct Curve {
  static constexpr std::size_t kKnots = 3;
  std::array<Color, kKnots> knots;
};

std::vector<Color> colors_of(std::span<const ColorSample> samples, Label label) {
  std::vector<Color> colors;
  for (const ColorSample& sample : samples) {
    if (sample.label == label) colors.emplace_back(sample.color.r, sample.color.g, sample.color.b);
  }
  return colors;
}

/// The curve through one or more colours.
Curve curve_through(std::vector<Color> colors) {
  std::sort(colors.begin(), colors.end(),
            [](const Color& a, const Color& b) { return brightness(a) < brightness(b); });
  Curve curve;
  for (std::size_t k = 0; k < Curve::kKnots; ++k) {
    // Averages a third of the colours for each knot; if there are fewer than three, some count twice.
    const std::size_t n = colors.size(), begin = std::min(k * n / Curve::kKnots, n - 1);
    const std::size_t end = std::max((k + 1) * n / Curve::kKnots, begin + 1);
    Color sum = Color::Zero();
    for (std::size_t i = begin; i < end; ++i) sum += colors[i];
    curve.knots[k] = sum / static_cast<float>(end - begin);
  }
  return curve;
}

std::optional<Curve> curve_of(std::span<const ColorSample> samples, Label label) {
  const std::vector<Color> colors = colors_of(samples, label);
  if (colors.empty()) return {};
  return curve_through(colors);
}

/// Colour of a pixel that lies partly on `a` and partly on `b`. With a share above 1, the colour lies beyond
/// `b`.
Curve blend(const Curve& a, const Curve& b, float share_of_b) {
  Curve out;
  for (std::size_t k = 0; k < Curve::kKnots; ++k) {
    out.knots[k] = in_cube(a.knots[k] + share_of_b * (b.knots[k] - a.knots[k]));
  }
  return out;
}

float squared_distance(const Color& color, const Color& from, const Color& to) {
  const Color step = to - from;
  const float along = (color - from).dot(step) / std::max(step.squaredNorm(), 1e-6F);
  return (color - from - std::clamp(along, 0.0F, 1.0F) * step).squaredNorm();
}

/// Distance of the samples from their label's curve (rms of one component perpendicular to the curve). It
/// comprises the noise of a sample and the differences between prints of one label.
float spread_of(std::span<const ColorSample> samples) {
  float sum = 0, degrees_of_freedom = 0;
  for (std::size_t i = 0; i < label::kMaxCount; ++i) {
    const auto label = static_cast<Label>(i);
    const std::vector<Color> colors = colors_of(samples, label);
    if (label == label::kClear || colors.size() <= Curve::kKnots) continue;
    const auto knots = curve_through(colors).knots;
    for (const Color& color : colors) {
      float least = std::min(squared_distance(color, 0.5F * knots.front(), knots.front()),
                             squared_distance(color, knots.back(), 1.5F * knots.back()));
      for (std::size_t k = 1; k < Curve::kKnots; ++k) {
        least = std::min(least, squared_distance(color, knots[k - 1], knots[k]));
      }
      sum += least;
    }
    degrees_of_freedom += 2 * static_cast<float>(colors.size() - Curve::kKnots);
  }
  return degrees_of_freedom > 0 ? std::sqrt(sum / degrees_of_freedom) : 0;
}

/// A line segment of the colours that a label may have.
struct Piece {
  Color from, step;  // step: from one end to the other
  float tolerance_from, tolerance_step;
  float factor, handicap;  // factor of the distance in tolerances; addend to its square
  Label label;
};

class Pieces {
 public:
  explicit Pieces(float noise) : tolerance_grey_(kToleranceGrey + noise) {}

  void add_color(const Curve& curve, Label label) {
    for (std::size_t k = 1; k < Curve::kKnots; ++k)
      add(curve.knots[k - 1], curve.knots[k], {1, kColorHandicap, label});
  }
  /// Adds the piece from `low` to a colour of the samples. A clipped channel may have been brighter in
  /// reality, which changes the hue: pieces for such hues are added as guesses.
  void add_in_less_light(const Color& dark, const Color& low, const Color& color, Label label) {
    const Kind kind{1, kColorHandicap, label};
    add(low, color, kind);
    constexpr float kFull = 250, kMoreThanSeen[] = {1.15F, 1.3F};
    if (color.maxCoeff() < kFull) return;
    for (const float more : kMoreThanSeen) {
      const Color beyond = (color.array() < kFull).select(color, more * color);
      add(dark + 0.55F * (beyond / more - dark), beyond / more, {1, kGuessHandicap, label});
    }
  }
  /// Adds a colour in more light. Channels clip one after the other, which changes the hue.
  void add_in_more_light(const Color& color, float most, Label label) {
    constexpr float kStep = 1.15F;
    for (float light = 1; light < most; light *= kStep)
      add(in_cube(light * color), in_cube(std::min(kStep * light, most) * color),
          {1, kMoreLightHandicap, label});
  }
  void add_background(const Color& low, const Curve& curve, const Color& high, Label label) {
    add(low, curve, high, {kBackgroundFactor, 0, label});
  }
  void add_background(const Curve& curve, Label label) {
    add_background(kSurfaceDarkest * curve.knots.front(), curve,
                   in_cube(kSurfaceBrightest * curve.knots.back()), label);
  }
  void add_guess(const Curve& curve, Label label) {
    add(kSurfaceDarkest * curve.knots.front(), curve, in_cube(kSurfaceBrightest * curve.knots.back()),
        {1, kGuessHandicap, label});
  }
  void add_background(const Color& from, const Color& to, Label label) {
    add(from, to, {kBackgroundFactor, 0, label});
  }
  /// Adds the blends of two surfaces; the surfaces themselves have priority.
  void add_edge(const Color& from, const Color& to) {
    add(from, to, {kBackgroundFactor, kEdgeHandicap, label::kClear});
  }
  const std::vector<Piece>& list() const { return list_; }

 private:
  struct Kind {
    float factor, handicap;
    Label label;
  };
  float tolerance(const Color& color) const { return tolerance_grey_ + kToleranceShare * brightness(color); }
  void add(const Color& from, const Color& to, const Kind& kind) {
    const float from_tolerance = tolerance(from);
    list_.push_back({from, to - from, from_tolerance, tolerance(to) - from_tolerance, kind.factor,
                     kind.handicap, kind.label});
  }
  /// Adds the curve and a piece at each of its ends.
  void add(const Color& low, const Curve& curve, const Color& high, const Kind& kind) {
    add(low, curve.knots.front(), kind);
    for (std::size_t k = 1; k < Curve::kKnots; ++k) add(curve.knots[k - 1], curve.knots[k], kind);
    add(curve.knots.back(), high, kind);
  }

  float tolerance_grey_;
  std::vector<Piece> list_;
};

/// Distance between the chromaticities (shares of red, green and blue) of two colours.
float share_distance(const Color& a, const Color& b) {
  return (a / std::max(a.sum(), 1.0F) - b / std::max(b.sum(), 1.0F)).norm();
}

/// Ratio of the brightest to the darkest knot.
float light_range(const Curve& curve) {
  return brightness(curve.knots.back()) / std::max(brightness(curve.knots.front()), 1.0F);
}

Pieces pieces_of(std::span<const ColorSample> samples, BackgroundLabels background, double noise_grey) {
  const auto named = [&](Label label) {
    return background == BackgroundLabels::kNamed ? label : label::kClear;
  };
  const auto field = curve_of(samples, label::kField), white = curve_of(samples, label::kWhite),
             black = curve_of(samples, label::kBlack);
  const float field_range = field ? light_range(*field) : 1;
  Pieces out(std::max({kMinNoise, kNoisePerSpread * spread_of(samples),
                       kNoisePerPixelNoise * static_cast<float>(noise_grey)}));
  for (std::size_t i = 0; i < label::kMaxCount; ++i) {
    const auto label = static_cast<Label>(i);
    if (label == label::kField || label == label::kWhite || label == label::kBlack) continue;
    if (label == label::kClear) {
      // Samples of "clear" may be different objects, so no line connects them.
      for (const Color& color : colors_of(samples, label)) {
        out.add_background(kSurfaceDarkest * color, in_cube(kSurfaceBrightest * color), label);
      }
      continue;
    }
    const auto curve = curve_of(samples, label);
    if (!curve) continue;
    // The carpet was sampled in all light levels that occur, but a print perhaps only in the brightest or in
    // the darkest light.
    const float unseen = std::max(1.0F, field_range / light_range(*curve));
    const Color dark = black ? black->knots.front() : Color::Zero();
    out.add_color(*curve, label);
    const float brightest = std::max(kColorBrightest, unseen);
    const bool shines = share_distance(curve->knots[1], curve->knots.back()) > kShine;
    for (const Color& knot : curve->knots) {
      // Prints of one label differ between makers: each print has its own colour in less light and in more
      // light. The highlight on a ball is not its colour in more light.
      const bool is_darkest = &knot == &curve->knots.front(), is_brightest = &knot == &curve->knots.back();
      if (is_darkest || share_distance(knot, curve->knots.front()) > kSamePrint)
        out.add_in_less_light(dark, dark + 0.55F * (knot / unseen - dark), knot, label);
      if (is_brightest ? !shines : shines || share_distance(knot, curve->knots.back()) > kSamePrint)
        out.add_in_more_light(knot, brightest, label);
    }
  }

  if (field) out.add_background(*field, named(label::kField));
  if (white) out.add_background(*white, named(label::kWhite));
  if (black) {
    out.add_background(Color::Zero(), *black, kSurfaceBrightest * black->knots.back(), named(label::kBlack));
  }
  if (field && white) {
    for (const float share : {0.25F, 0.5F, 0.75F}) {
      out.add_background(blend(*field, *white, share), label::kClear);
    }
    // A sample from a line one or two pixels wide is a blend itself, so real white may lie beyond the sample.
    // This is a guess: sampled colours have priority.
    out.add_guess(blend(*field, *white, 1.5F), named(label::kWhite));
  }
  const auto add_edges = [&](const std::optional<Curve>& beside_black) {
    if (!beside_black || !black) return;
    for (std::size_t k = 0; k < Curve::kKnots; ++k) {
      const Color step = beside_black->knots[k] - black->knots[k];
      out.add_edge(black->knots[k] + 0.2F * step, black->knots[k] + 0.8F * step);
    }
  };
  add_edges(field);
  add_edges(white);
  return out;
}

/// The table's cells are processed in blocks of 4x4x4, so that only the pieces near a block are compared cell
/// by cell.
constexpr int kBlockSide = 4, kCellLevels = 256 >> Lut::kBits;
constexpr std::size_t kBlockCells = kBlockSide * kBlockSide * kBlockSide;

/// Differences between the colours of a block's cells and the colour of the block's middle.
struct Block {
  std::array<float, kBlockCells> r, g, b;
};

/// RGB of YUV without clamping: noise moves colours out of the cube.
Color rgb_of(float y, float u, float v) {
  u -= 128;
  v -= 128;
  return {y + 1.402F * v, y - 0.344136F * u - 0.714136F * v, y + 1.772F * u};
}

/// Middle level of the block or cell with index `i`, which is `levels` wide.
float middle(int i, int levels) {
  return static_cast<float>(i * levels) + static_cast<float>(levels - 1) / 2;
}

Block offsets_in_block() {
  Block out;
  constexpr int kLevels = kBlockSide * kCellLevels;
  const Color center = rgb_of(middle(0, kLevels), middle(0, kLevels), middle(0, kLevels));
  std::size_t i = 0;
  for (int u = 0; u < kBlockSide; ++u) {
    for (int v = 0; v < kBlockSide; ++v) {
      for (int y = 0; y < kBlockSide; ++y, ++i) {
        const Color offset =
            rgb_of(middle(y, kCellLevels), middle(u, kCellLevels), middle(v, kCellLevels)) - center;
        out.r[i] = offset.x();
        out.g[i] = offset.y();
        out.b[i] = offset.z();
      }
    }
  }
  return out;
}

struct Nearness {
  float distance, tolerance;
};

Nearness nearness(const Piece& piece, const Color& color) {
  const float length2 = std::max(piece.step.squaredNorm(), 1e-6F);
  const float along = std::clamp((color - piece.from).dot(piece.step) / length2, 0.0F, 1.0F);
  return {(color - piece.from - along * piece.step).norm(),
          piece.tolerance_from + along * piece.tolerance_step};
}

/// Updates the cells for which the piece is the nearest so far. The loop has a fixed length and no branches,
/// so that compilers use vector instructions.
void measure(const Piece& piece, const Color& center, const Block& offsets,
             std::array<float, kBlockCells>& best, std::array<std::int32_t, kBlockCells>& labels) {
  const Color start = center - piece.from;
  const float sr = start.x(), sg = start.y(), sb = start.z();
  const float dr = piece.step.x(), dg = piece.step.y(), db = piece.step.z();
  const float per_length2 = 1 / std::max(piece.step.squaredNorm(), 1e-6F);
  const float factor2 = piece.factor * piece.factor, handicap = piece.handicap;
  const float tolerance_from = piece.tolerance_from, tolerance_step = piece.tolerance_step;
  const std::int32_t label = piece.label;
  for (std::size_t i = 0; i < kBlockCells; ++i) {
    const float r = sr + offsets.r[i], g = sg + offsets.g[i], b = sb + offsets.b[i];
    float along = (r * dr + g * dg + b * db) * per_length2;
    along = along < 0 ? 0 : along;
    along = along > 1 ? 1 : along;
    const float er = r - along * dr, eg = g - along * dg, eb = b - along * db;
    const float unit = tolerance_from + along * tolerance_step;
    const float distance2 = (er * er + eg * eg + eb * eb) * factor2 / (unit * unit) + handicap;
    const bool nearer = distance2 < best[i];
    best[i] = nearer ? distance2 : best[i];
    labels[i] = nearer ? label : labels[i];
  }
}

}  // namespace

ColorTable table_from_samples(std::span<const ColorSample> samples, BackgroundLabels background,
                              double noise_grey) {
  const Pieces pieces = pieces_of(samples, background, noise_grey);
  const Block offsets = offsets_in_block();
  float radius = 0;
  for (std::size_t i = 0; i < kBlockCells; ++i) {
    radius = std::max(radius, Color(offsets.r[i], offsets.g[i], offsets.b[i]).norm());
  }
  // Within a block, the nearest point of a piece moves no further than the colour does, and its tolerance
  // changes by less than this.
  const float tolerance_change = kToleranceShare * radius;

  std::vector<Label> table(Lut::kEntries, label::kClear);
  std::vector<std::pair<float, const Piece*>> near;  // least squared distance that a cell may have; piece
  std::array<float, kBlockCells> best{};
  std::array<std::int32_t, kBlockCells> labels{};
  constexpr int kBlocks = (1 << Lut::kBits) / kBlockSide, kLevels = kBlockSide * kCellLevels;
  for (int u = 0; u < kBlocks; ++u) {
    for (int v = 0; v < kBlocks; ++v) {
      for (int y = 0; y < kBlocks; ++y) {
        const Color center = rgb_of(middle(y, kLevels), middle(u, kLevels), middle(v, kLevels));
        near.clear();
        float reach = kLimit * kLimit;  // no cell's nearest piece is further than this
        bool colored = false;
        for (const Piece& piece : pieces.list()) {
          const Nearness n = nearness(piece, center);
          const float low = std::max(0.0F, n.distance - radius) / (n.tolerance + tolerance_change);
          const float high = (n.distance + radius) / (n.tolerance - tolerance_change);
          const float factor2 = piece.factor * piece.factor;
          const float least = factor2 * low * low + piece.handicap;
          const float most = factor2 * high * high + piece.handicap;
          if (least >= reach) continue;
          reach = std::min(reach, most);
          near.emplace_back(least, &piece);
        }
        std::erase_if(near, [&](const auto& entry) { return entry.first > reach; });
        for (const auto& entry : near) colored = colored || entry.second->label != label::kClear;
        if (!colored) continue;

        best.fill(kLimit * kLimit);
        labels.fill(label::kClear);
        for (const auto& entry : near) measure(*entry.second, center, offsets, best, labels);
        std::size_t i = 0;
        for (int du = 0; du < kBlockSide; ++du) {
          for (int dv = 0; dv < kBlockSide; ++dv) {
            const auto level = [](int block, int cell) {
              return static_cast<std::uint8_t>((block * kBlockSide + cell) * kCellLevels);
            };
            const std::size_t at = Lut::index_yuv(level(y, 0), level(u, du), level(v, dv));
            for (int dy = 0; dy < kBlockSide; ++dy, ++i) {
              table[at + static_cast<std::size_t>(dy)] = static_cast<Label>(labels[i]);
            }
          }
        }
      }
    }
  }
  return {Lut::kBits, std::move(table)};
}

Lut lut_from_samples(std::span<const ColorSample> samples, BackgroundLabels background, double noise_grey) {
  return Lut(table_from_samples(samples, background, noise_grey));
}

}  // namespace sslv
