// SPDX-License-Identifier: Apache-2.0
#include "colors/table_in_light.h"

#include "image/color.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>

namespace sslv {
namespace {

constexpr int kSide = 1 << Lut::kBits, kCellLevels = 256 >> Lut::kBits;
/// With noise, a clipped channel may read this low.
constexpr float kClipped = 248;
/// No camera delivers colours further outside the RGB cube than this.
constexpr float kFarOut = 24;
/// Factor between the light levels in which colours are looked up: tables tolerate a larger factor.
constexpr double kAreaStep = 1.2;
/// kNoiseCells: spread of a label's colours due to noise, in cells in each direction. If light becomes weaker
/// by some share, the label's cells lose this share of the spread. grow() restores it, up to kMaxGrowth
/// cells.
constexpr double kNoiseCells = 3, kMaxGrowth = 2;

using Color = std::array<float, 3>;  // red, green, blue

bool is_color(Label label) {
  return label != label::kClear && label != label::kField && label != label::kWhite && label != label::kBlack;
}

/// The labels of all cells of one chroma, by luma.
using Column = std::array<Label, kSide>;

/// The level at a cell's middle.
float middle(int cell) {
  return static_cast<float>(cell * kCellLevels) + static_cast<float>(kCellLevels - 1) / 2;
}

inline std::uint8_t byte(float value) {
  return static_cast<std::uint8_t>(static_cast<int>(std::min(std::max(value + 0.5F, 0.0F), 255.0F)));
}

constexpr float kPerBlue = 0.564334F, kPerRed = 0.713267F;  // BT.601, as in image/color.h
inline float luma_of(float red, float green, float blue) {
  return 0.299F * red + 0.587F * green + 0.114F * blue;
}

/// Looks up colours in the light in which the table was accepted.
class Past {
 public:
  Past(const Lut& accepted, const std::array<double, 3>& gain) : lut_(accepted) {
    for (std::size_t c = 0; c < 3; ++c) per_gain_[c] = static_cast<float>(1 / gain[c]);
  }

  /// The labels of the current colours of one chroma.
  void look(float u, float v, Column& out) const {
    u -= 128;
    v -= 128;
    const Color chroma{1.402F * v, -0.344136F * u - 0.714136F * v, 1.772F * u};
    // Loops of fixed length without branches, so that compilers use vector instructions.
    std::array<float, kSide> lumas;
    std::array<std::array<float, kSide>, 3> then;
    for (std::size_t i = 0; i < kSide; ++i) lumas[i] = middle(static_cast<int>(i));
    for (std::size_t c = 0; c < 3; ++c) {
      const float offset = chroma[c], per_gain = per_gain_[c];
      for (std::size_t i = 0; i < kSide; ++i) then[c][i] = scaled(lumas[i] + offset, per_gain);
    }
    const auto& [red, green, blue] = then;
    for (std::size_t i = 0; i < kSide; ++i) lumas[i] = luma_of(red[i], green[i], blue[i]);
    Bytes ys, us, vs;
    for (std::size_t i = 0; i < kSide; ++i) ys[i] = byte(lumas[i]);
    for (std::size_t i = 0; i < kSide; ++i) us[i] = byte(kPerBlue * (blue[i] - lumas[i]) + 128);
    for (std::size_t i = 0; i < kSide; ++i) vs[i] = byte(kPerRed * (red[i] - lumas[i]) + 128);
    if (is_clear(us, vs)) {
      out.fill(label::kClear);
    } else {
      for (std::size_t i = 0; i < kSide; ++i) out[i] = lut_.of_yuv(ys[i], us[i], vs[i]);
    }
    for (int i = kSide - 1; i >= 0; --i) {
      const float luma = middle(i);
      const Color current{luma + chroma[0], luma + chroma[1], luma + chroma[2]};
      const auto [least, brightest] = std::minmax({current[0], current[1], current[2]});
      if (brightest < kClipped) break;
      if (brightest < 255 + kFarOut && least > -kFarOut)
        out[static_cast<std::size_t>(i)] = label_of_full(current);
    }
  }

 private:
  using Bytes = std::array<std::uint8_t, kSide>;

  /// Whether the table is clear at every luma for all chromas in the range of `us` and `vs`.
  bool is_clear(const Bytes& us, const Bytes& vs) const {
    constexpr int kShift = 8 - LutTable::kChromaBits;
    std::uint8_t min_u = 255, max_u = 0, min_v = 255, max_v = 0;
    for (std::size_t i = 0; i < kSide; ++i) {
      min_u = std::min(min_u, us[i]);
      max_u = std::max(max_u, us[i]);
      min_v = std::min(min_v, vs[i]);
      max_v = std::max(max_v, vs[i]);
    }
    for (int u = min_u >> kShift; u <= max_u >> kShift; ++u) {
      for (int v = min_v >> kShift; v <= max_v >> kShift; ++v) {
        const auto at = static_cast<std::size_t>(u << LutTable::kChromaBits | v);
        if (lut_.yuv().chroma[at] != label::kClear) return false;
      }
    }
    return true;
  }

  static float scaled(float current, float per_gain) {
    return std::min(current * per_gain, std::max(current, 255.0F));
  }

  /// The label of a colour with clipped channels, by a vote of all colours that it may have been without
  /// clipping. One vote is enough for a print's label if "clear" leads among the other labels. If field,
  /// white or black leads, or if all three channels are clipped, as in white, the print's label needs more
  /// votes than the leader.
  Label label_of_full(const Color& current) const {
    constexpr std::array<std::size_t, 4> kSteps{1, 6, 5, 4};  // by the number of clipped channels
    Color then;
    std::array<bool, 3> full;
    std::size_t count = 0;
    for (std::size_t c = 0; c < 3; ++c) {
      then[c] = scaled(current[c], per_gain_[c]);
      full[c] = current[c] >= kClipped && per_gain_[c] < 1;
      count += full[c] ? 1 : 0;
    }
    const std::size_t steps = kSteps[count];
    struct Best {
      Label label = label::kClear;
      int votes = 0;
    };
    Best color, other;
    std::array<std::uint8_t, 256> votes{};
    for (std::size_t r = 0; r < (full[0] ? steps : 1); ++r) {
      for (std::size_t g = 0; g < (full[1] ? steps : 1); ++g) {
        for (std::size_t b = 0; b < (full[2] ? steps : 1); ++b) {
          Color maybe = then;
          const std::array<std::size_t, 3> step{r, g, b};
          for (std::size_t c = 0; c < 3; ++c) {
            if (full[c])
              maybe[c] += (255 - then[c]) * static_cast<float>(step[c]) / static_cast<float>(steps - 1);
          }
          const float luma = luma_of(maybe[0], maybe[1], maybe[2]);
          const Label label = lut_.of_yuv(byte(luma), byte(kPerBlue * (maybe[2] - luma) + 128),
                                          byte(kPerRed * (maybe[0] - luma) + 128));
          Best& best = is_color(label) ? color : other;
          if (++votes[label] > best.votes) best = {label, votes[label]};
        }
      }
    }
    const bool one_will_do = count < 3 && other.label == label::kClear;
    return color.votes > (one_will_do ? 0 : other.votes) ? color.label : other.label;
  }

  const Lut& lut_;
  Color per_gain_;
};

/// The light levels in which colours are looked up: the level of the whole image first, then increasingly
/// different levels.
std::vector<Past> lights_of(const Lut& accepted, const LightChange& change) {
  std::vector<double> factors{1};
  for (double f = kAreaStep; f < change.brightest_area * std::sqrt(kAreaStep); f *= kAreaStep)
    factors.push_back(f);
  for (double f = 1 / kAreaStep; f > change.darkest_area / std::sqrt(kAreaStep); f /= kAreaStep)
    factors.push_back(f);
  std::sort(factors.begin(), factors.end(),
            [](double a, double b) { return std::abs(std::log(a)) < std::abs(std::log(b)); });
  std::vector<Past> out;
  for (const double factor : factors) {
    auto gain = change.gain;
    for (double& one : gain) one *= factor;
    out.emplace_back(accepted, gain);
  }
  return out;
}

/// Gives clear cells next to a cell with a print's label the same label.
void grow(std::vector<Label>& labels) {
  constexpr std::size_t kSteps[3] = {kSide * kSide, kSide, 1};
  std::vector<std::pair<std::size_t, Label>> grown;
  for (std::size_t i = 0; i < labels.size(); ++i) {
    if (!is_color(labels[i])) continue;
    for (const std::size_t step : kSteps) {
      const std::size_t at = i / step % kSide;
      if (at > 0 && labels[i - step] == label::kClear) grown.emplace_back(i - step, labels[i]);
      if (at + 1 < kSide && labels[i + step] == label::kClear) grown.emplace_back(i + step, labels[i]);
    }
  }
  for (const auto& [cell, label] : grown) {
    if (labels[cell] == label::kClear) labels[cell] = label;
  }
}

PrintColor in_light(const PrintColor& print, const std::array<double, 3>& gain) {
  std::array<double, 3> chromaticity{};
  double sum = 0;
  for (std::size_t c = 0; c < 3; ++c) sum += chromaticity[c] = print.chromaticity[c] * gain[c];
  PrintColor out = print;
  if (!(sum > 0)) return out;
  for (std::size_t c = 0; c < 3; ++c)
    out.chromaticity[c] = static_cast<std::uint16_t>(std::lround(PrintColor::kUnit * chromaticity[c] / sum));
  return out;
}

}  // namespace

ColorTable table_in_light(const Lut& accepted, const LightChange& change) {
  const std::vector<Past> lights = lights_of(accepted, change);
  ColorTable out(Lut::kBits);
  out.prints = accepted.prints();
  for (auto& print : out.prints) {
    if (print) print = in_light(*print, change.gain);
  }
  Column column, other;
  auto next = out.labels.begin();
  for (int u = 0; u < kSide; ++u) {
    for (int v = 0; v < kSide; ++v) {
      lights.front().look(middle(u), middle(v), column);
      for (std::size_t k = 1; k < lights.size(); ++k) {
        lights[k].look(middle(u), middle(v), other);
        for (std::size_t y = 0; y < kSide; ++y) {
          if (column[y] == label::kClear && is_color(other[y])) column[y] = other[y];
        }
      }
      next = std::copy(column.begin(), column.end(), next);
    }
  }
  const double scale = *std::min_element(change.gain.begin(), change.gain.end()) * change.darkest_area;
  const auto growth = static_cast<int>(std::clamp(kNoiseCells * (1 - scale), 0.0, kMaxGrowth));
  for (int k = 0; k < growth; ++k) grow(out.labels);
  return out;
}

}  // namespace sslv
