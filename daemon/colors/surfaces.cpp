// SPDX-License-Identifier: Apache-2.0
#include "colors/surfaces.h"

#include "colors/name_dots.h"
#include "colors/pixel_figures.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <deque>
#include <memory>
#include <numbers>
#include <utility>

namespace sslv {
namespace {

constexpr double kFloorAlike = 0.06;     // distance of chromaticities
constexpr double kMinFloorShare = 0.02;  // share of all places
constexpr std::size_t kPlacesPerFrame = 120'000;

/// Whether the two colours may be one colour in different light.
bool goes_on(const Color3& here, const Color3& there) {
  const double length2 = there.squaredNorm();
  if (length2 < 1) return here.norm() < 12;
  const double factor = here.dot(there) / length2;
  constexpr double kMin = 0.6, kMax = 1 / kMin;
  if (factor < kMin || factor > kMax) return (here - there).norm() < 10;
  return (here - factor * there).norm() < 5 + 0.08 * here.norm();
}

/// A place on a large surface.
struct Place {
  std::size_t frame;
  int cell_x, cell_y;  // cell of the SmallPicture
  Color3 color;
  std::unique_ptr<std::array<Color3, 2>> beside{};  // chromaticities on both sides; only for narrow places

  Color3 chromaticity() const { return chromaticity_of(color); }
};

/// A deque, because a growing vector would temporarily need three times the memory.
using Places = std::deque<Place>;

/// Most common chromaticity, found in bins of 1/50, of the places that `counts` accepts.
std::optional<Color3> commonest(const Places& places, const std::function<bool(const Place&)>& counts) {
  constexpr int kBins = 50;
  std::vector<std::size_t> bins(std::size_t{kBins} * kBins);
  const auto bin_of = [](const Color3& chromaticity) {
    const auto bin = [](double share) { return std::clamp(static_cast<int>(share * kBins), 0, kBins - 1); };
    return static_cast<std::size_t>(bin(chromaticity[0]) * kBins + bin(chromaticity[1]));
  };
  for (const Place& place : places) {
    if (counts(place)) ++bins[bin_of(place.chromaticity())];
  }
  // Sums three by three bins, so that no border splits a cluster.
  std::size_t most = 0;
  int best = 0;
  for (int i = 1; i + 1 < kBins; ++i) {
    for (int j = 1; j + 1 < kBins; ++j) {
      std::size_t sum = 0;
      for (int k = 0; k < 9; ++k)
        sum += bins[static_cast<std::size_t>((i + k / 3 - 1) * kBins + j + k % 3 - 1)];
      if (sum <= most) continue;
      most = sum;
      best = i * kBins + j;
    }
  }
  if (most == 0) return {};
  Color3 sum = Color3::Zero();
  double count = 0;
  for (const Place& place : places) {
    if (!counts(place)) continue;
    const auto bin = static_cast<int>(bin_of(place.chromaticity()));
    if (std::abs(bin / kBins - best / kBins) > 1 || std::abs(bin % kBins - best % kBins) > 1) continue;
    sum += place.chromaticity();
    ++count;
  }
  return Color3(sum / count);
}

/// Standard deviation of normally distributed values, from the numbers of values that differ from the mean by
/// 0, 1, ... levels; at least half a level.
double sigma_of(const std::array<std::size_t, 256>& differences, std::size_t count) {
  // Share of a normal distribution within one sigma. A difference of n levels counts as n - 1/2 to n + 1/2:
  // with whole levels, the result and therefore the margins would jump from image to image.
  const double wanted = 0.683 * static_cast<double>(count);
  double below = 0;
  for (std::size_t level = 0; level < differences.size(); ++level) {
    const auto here = static_cast<double>(differences[level]);
    if (here > 0 && below + here >= wanted) {
      const double from = level == 0 ? 0 : static_cast<double>(level) - 0.5,
                   to = static_cast<double>(level) + 0.5;
      return std::max(0.5, from + (to - from) * (wanted - below) / here);
    }
    below += here;
  }
  return 0.5;
}

Places find_places(const SurfaceSearch& search) {
  Places out;
  for (std::size_t frame = 0; frame < search.frames.size(); ++frame) {
    const SmallPicture& picture = search.pictures[frame].finest();
    const int reach = std::max(1, static_cast<int>(0.15 * search.largest_dot_px / picture.cell_px()));
    const int away =
        std::max(3, static_cast<int>(std::ceil(1.3 * search.largest_dot_px / picture.cell_px())));
    const auto cells = static_cast<std::size_t>(picture.width()) * static_cast<std::size_t>(picture.height());
    const int step = std::max(1, static_cast<int>(std::sqrt(static_cast<double>(cells) / kPlacesPerFrame)));
    const auto is_left_out = [&](const Eigen::Vector2d& pixel) {
      return std::any_of(search.left_out.begin(), search.left_out.end(), [&](const PixelDisc& disc) {
        return disc.frame == frame &&
               std::hypot(disc.x_px - pixel.x(), disc.y_px - pixel.y()) < disc.radius_px;
      });
    };
    const auto mean_at = [&](int x, int y) -> std::optional<Color3> {
      if (x < reach || y < reach || x + reach >= picture.width() || y + reach >= picture.height()) return {};
      return picture.mean(x, y, reach);
    };
    for (int y = reach; y + reach < picture.height() && !search.stop.stop_requested(); y += step) {
      for (int x = reach; x + reach < picture.width(); x += step) {
        if (!picture.shows(x, y)) continue;
        const Color3 here = picture.mean(x, y, reach);
        const auto alike = [&](int dx, int dy) {
          // At the image's edge there is one side only.
          const auto one = mean_at(x - dx, y - dy), other = mean_at(x + dx, y + dy);
          return (one || other) && (!one || goes_on(here, *one)) && (!other || goes_on(here, *other));
        };
        const bool across = alike(away, 0), along = alike(0, away);
        if (!across && !along) continue;
        if (is_left_out(picture.pixel_of(x, y))) continue;
        Place place{frame, x, y, here};
        if (across != along) {
          const int dx = across ? 0 : away, dy = across ? away : 0;
          const auto one = mean_at(x - dx, y - dy), other = mean_at(x + dx, y + dy);
          if (one && other)
            place.beside = std::make_unique<std::array<Color3, 2>>(
                std::array{chromaticity_of(*one), chromaticity_of(*other)});
        }
        out.push_back(std::move(place));
      }
    }
  }
  return out;
}

Yuv in_light(Yuv color, double factor) {
  const Rgb rgb = to_rgb(color);
  const auto scaled = [factor](std::uint8_t value) {
    return static_cast<std::uint8_t>(std::min(255.0, factor * value + 0.5));
  };
  return to_yuv({scaled(rgb.r), scaled(rgb.g), scaled(rgb.b)});
}

/// The brightness that this share of the colours' pixels exceeds.
int brightness_above(std::span<const SurfaceColors::Color> colors, std::size_t total, double share) {
  std::array<std::size_t, 256> counts{};
  for (const auto& [color, count] : colors) counts[color.y] += count;
  std::size_t above = 0;
  int level = 255;
  while (level > 0 && static_cast<double>(above + counts[static_cast<std::size_t>(level)]) <
                          share * static_cast<double>(total))
    above += counts[static_cast<std::size_t>(level--)];
  return level;
}

/// The colours that a surface may have in a range of light, in bins of SurfaceColors.
class Taken {
 public:
  static constexpr int kSide = SurfaceColors::kSide, kLevels = 256 / kSide;

  explicit Taken(const std::array<double, 3>& reach_levels) : bins_(std::size_t{kSide} * kSide * kSide) {
    // Bins whose middle lies in the ellipsoid, which is enlarged by half a bin.
    std::array<double, 3> radius{};
    for (std::size_t c = 0; c < 3; ++c) radius[c] = reach_levels[c] / kLevels + 0.5;
    const int most = static_cast<int>(*std::max_element(radius.begin(), radius.end()));
    for (int u = -most; u <= most; ++u) {
      for (int v = -most; v <= most; ++v) {
        for (int y = -most; y <= most; ++y) {
          const double dy = y / radius[0], du = u / radius[1], dv = v / radius[2];
          if (dy * dy + du * du + dv * dv <= 1) around_.push_back({u, v, y});
        }
      }
    }
  }

  void add(Yuv color) {
    const std::array<int, 3> middle{color.u / kLevels, color.v / kLevels, color.y / kLevels};
    // Skips bins added before: many colours of a surface share a bin.
    if (std::exchange(bins_[index(middle)], std::uint8_t{kMiddle}) == kMiddle) return;
    for (const auto& [du, dv, dy] : around_) {
      const std::array<int, 3> at{middle[0] + du, middle[1] + dv, middle[2] + dy};
      if (*std::min_element(at.begin(), at.end()) < 0 || *std::max_element(at.begin(), at.end()) >= kSide)
        continue;
      bins_[index(at)] |= kNear;
    }
  }
  bool has(Yuv color) const {
    return bins_[index({color.u / kLevels, color.v / kLevels, color.y / kLevels})] != 0;
  }

 private:
  static constexpr std::uint8_t kMiddle = 1, kNear = 2;
  static std::size_t index(const std::array<int, 3>& uvy) {
    return static_cast<std::size_t>((uvy[0] * kSide + uvy[1]) * kSide + uvy[2]);
  }
  std::vector<std::uint8_t> bins_;
  std::vector<std::array<int, 3>> around_;
};

Taken taken_by(const SurfaceColors& surfaces, SurfaceKind kind, const ClearRange& range) {
  std::array<double, 3> reach_levels = surfaces.noise_sigma;
  for (double& reach : reach_levels) reach *= range.noise_sigmas;
  Taken out(reach_levels);
  const std::vector<SurfaceColors::Color> colors = surfaces.colors(kind);
  const std::size_t total = surfaces.total(kind);
  // Rarer colours belong to edges or small objects.
  const auto least =
      std::max<std::uint32_t>(2, static_cast<std::uint32_t>(5e-5 * static_cast<double>(total)));
  // Highlights need not stay clear over the whole range of light, because they are too few for a flood.
  constexpr double kShine = kFloodShare / 2, kShineMore = 1.06;
  // Over-exposed carpet looks like dots: if a channel is clipped, the cleared range is only slightly larger
  // than the wanted margin. The additional 0.1 keeps noise in later images from reducing the margin.
  constexpr double kBrightestClipped = 1 + kWantedMargin + 0.1;
  const double bright = std::max(1, brightness_above(colors, total, kShine));
  for (const auto& [color, count] : colors) {
    if (count < least) continue;
    const Rgb rgb = to_rgb(color);
    const double clips_at = 255.0 / std::max({rgb.r, rgb.g, rgb.b, std::uint8_t{1}});
    const double brightest = std::min(range.brightest, std::max(kBrightestClipped, clips_at));
    const double most =
        std::max(kShineMore, brightest * std::min(1.0, bright / std::max<double>(1, color.y)));
    constexpr double kStep = 1.015;
    for (double factor = range.darkest; factor < most; factor *= kStep) out.add(in_light(color, factor));
    out.add(in_light(color, most));
  }
  return out;
}

/// A surface's chroma per level of luma, which does not change with the light unless a channel is clipped.
class Hue {
 public:
  Hue(const SurfaceColors& surfaces, SurfaceKind kind) : noise_sigma_(surfaces.noise_sigma) {
    const std::vector<SurfaceColors::Color> colors = surfaces.colors(kind);
    double luma = 0, count = 0;
    std::array<double, 2> sums{};
    for (const auto& color : colors) {
      if (is_clipped(color.color)) continue;
      const auto chroma = chroma_of(color.color);
      for (std::size_t c = 0; c < 2; ++c) sums[c] += color.count * chroma[c];
      luma += static_cast<double>(color.count) * color.color.y;
      count += color.count;
    }
    if (luma <= 0) return;
    mean_luma_ = luma / count;
    std::array<double, 2> squares{};
    for (std::size_t c = 0; c < 2; ++c) per_luma_[c] = sums[c] / luma;
    for (const auto& color : colors) {
      if (is_clipped(color.color)) continue;
      const auto chroma = chroma_of(color.color);
      for (std::size_t c = 0; c < 2; ++c)
        squares[c] += color.count * square(chroma[c] - per_luma_[c] * color.color.y) / count;
    }
    // Binning adds variance that is not texture.
    constexpr double kBin = 256.0 / SurfaceColors::kSide, kBinVariance = kBin * kBin / 12;
    for (std::size_t c = 0; c < 2; ++c)
      texture_[c] = std::sqrt(std::max(0.0, squares[c] - kBinVariance)) / mean_luma_;
  }
  /// Distance between a colour and the surface in any light, in sigmas of its texture and of a pixel's noise,
  /// reduced by `within_levels` per channel. 0 if a channel is clipped, because then the light changes the
  /// hue.
  double sigmas_from(Yuv color, double within_levels) const {
    if (mean_luma_ <= 0 || is_clipped(color)) return 0;
    const auto chroma = chroma_of(color);
    double sigmas2 = 0;
    for (std::size_t c = 0; c < 2; ++c) {
      const double variance = square(noise_sigma_[c + 1]) + square(per_luma_[c] * noise_sigma_[0]) +
                              square(texture_[c] * color.y);
      const double away = std::abs(chroma[c] - per_luma_[c] * color.y) - within_levels;
      sigmas2 += square(std::max(0.0, away)) / variance;
    }
    return std::sqrt(sigmas2);
  }

 private:
  static constexpr double square(double value) { return value * value; }
  static std::array<double, 2> chroma_of(Yuv color) { return {color.u - 128.0, color.v - 128.0}; }
  static bool is_clipped(Yuv color) {
    constexpr int kClippedByte = 235;
    const Rgb rgb = to_rgb(color);
    return std::max({rgb.r, rgb.g, rgb.b}) > kClippedByte;
  }
  std::array<double, 2> per_luma_{}, texture_{};  // for U and V
  double mean_luma_ = 0;
  std::array<double, 3> noise_sigma_;
};

/// Normally distributed samples with sigma 1 per channel; deterministic.
std::vector<std::array<double, 3>> noise_samples() {
  constexpr std::size_t kCount = 64;
  std::vector<std::array<double, 3>> out;
  std::uint32_t state = 1;
  const auto uniform = [&] {
    state = state * 1664525 + 1013904223;  // Numerical Recipes' generator: the upper bits are good
    return (static_cast<double>(state >> 8) + 0.5) / (1 << 24);
  };
  for (std::size_t i = 0; i < kCount; ++i) {
    std::array<double, 3> one{};
    for (double& value : one)
      value = std::sqrt(-2 * std::log(uniform())) * std::cos(2 * std::numbers::pi * uniform());
    out.push_back(one);
  }
  return out;
}

}  // namespace

bool is_surface_label(Label label) {
  return label == label::kField || label == label::kWhite || label == label::kBlack;
}

std::string_view name_of(SurfaceKind kind) {
  constexpr std::array<std::string_view, kSurfaceKinds> kNames{"carpet", "floor", "other surfaces"};
  return kNames[static_cast<std::size_t>(kind)];
}

std::vector<SurfaceColors::Color> SurfaceColors::colors(SurfaceKind kind) const {
  const std::vector<std::uint32_t>& counts = counts_[static_cast<std::size_t>(kind)];
  std::vector<Color> out;
  for (std::size_t bin = 0; bin < counts.size(); ++bin) {
    if (counts[bin] == 0) continue;
    const auto middle = [](std::size_t place) {
      constexpr int kLevels = 256 / kSide;
      return static_cast<std::uint8_t>(static_cast<int>(place) * kLevels + kLevels / 2);
    };
    constexpr std::size_t kMask = kSide - 1;
    out.push_back(
        {{middle(bin & kMask), middle(bin >> (2 * kBits)), middle(bin >> kBits & kMask)}, counts[bin]});
  }
  return out;
}

SurfaceColors find_surfaces(const SurfaceSearch& search) {
  const Places places = find_places(search);
  const auto carpet =
      search.carpet_chromaticity ? search.carpet_chromaticity : commonest(places, [&](const Place& place) {
        if (!search.on_carpet) return true;
        return search.on_carpet(place.frame,
                                search.pictures[place.frame].finest().pixel_of(place.cell_x, place.cell_y));
      });
  const auto like_carpet = [&](const Color3& chromaticity) {
    return carpet && (chromaticity - *carpet).norm() < kCarpetAlike;
  };
  const auto is_carpet = [&](const Place& place) { return like_carpet(place.chromaticity()); };
  // White lines may have the colour of a grey floor, but have carpet on both sides.
  const auto is_line = [&](const Place& place) {
    return place.beside && like_carpet((*place.beside)[0]) && like_carpet((*place.beside)[1]);
  };
  const auto floor =
      commonest(places, [&](const Place& place) { return !is_carpet(place) && !is_line(place); });
  const auto is_floor = [&](const Place& place) {
    return floor && (place.chromaticity() - *floor).norm() < kFloorAlike && !is_line(place);
  };
  const auto floor_places = std::count_if(
      places.begin(), places.end(), [&](const Place& place) { return !is_carpet(place) && is_floor(place); });
  const bool has_floor =
      static_cast<double>(floor_places) > kMinFloorShare * static_cast<double>(places.size());

  SurfaceColors out;
  std::array<std::array<std::size_t, 256>, 3> differences{};  // numbers of pixels, by difference in levels
  for (const Place& place : places) {
    const SurfaceKind kind = is_carpet(place)               ? SurfaceKind::kCarpet
                             : has_floor && is_floor(place) ? SurfaceKind::kFloor
                                                            : SurfaceKind::kOther;
    const auto level = [](double value) {
      return static_cast<std::uint8_t>(std::clamp(value + 0.5, 0.0, 255.0));
    };
    const Yuv around = to_yuv({level(place.color[0]), level(place.color[1]), level(place.color[2])});
    out.add(kind, around);
    const ImageView& image = search.frames[place.frame];
    const int cells = search.pictures[place.frame].finest().cell_px() / (is_bayer(image.format) ? 2 : 1);
    const Yuv pixel = cell_color(image, place.cell_x * cells, place.cell_y * cells);
    ++differences[0][static_cast<std::size_t>(std::abs(pixel.y - around.y))];
    ++differences[1][static_cast<std::size_t>(std::abs(pixel.u - around.u))];
    ++differences[2][static_cast<std::size_t>(std::abs(pixel.v - around.v))];
  }
  for (std::size_t c = 0; c < 3; ++c) out.noise_sigma[c] = sigma_of(differences[c], places.size());
  return out;
}

std::size_t clear_surfaces(ColorTable& table, const SurfaceColors& surfaces, const ClearRange& range,
                           const std::function<bool(Label, Yuv)>& keep) {
  const Taken carpet = taken_by(surfaces, SurfaceKind::kCarpet, range),
              floor = taken_by(surfaces, SurfaceKind::kFloor, range),
              other = taken_by(surfaces, SurfaceKind::kOther, range);
  const Hue carpet_hue(surfaces, SurfaceKind::kCarpet);
  // 0.3 % of a surface's own pixels lie beyond this distance, which is too few for a flood.
  constexpr double kOtherHueSigmas = 3.4;
  const double half_cell_levels = 128.0 / table.side();
  std::size_t changed = 0;
  for (std::size_t cell = 0; cell < table.labels.size(); ++cell) {
    Label& label = table.labels[cell];
    if (label == label::kClear || is_surface_label(label)) continue;
    const Yuv color = table.color_of(cell);
    const bool in_carpet = carpet.has(color);
    if (!in_carpet && !floor.has(color) && !other.has(color)) continue;
    if ((!in_carpet || carpet_hue.sigmas_from(color, half_cell_levels) > kOtherHueSigmas) &&
        keep(label, color))
      continue;
    label = label::kClear;
    ++changed;
  }
  return changed;
}

SurfaceReach reach_of(const SurfaceColors& surfaces, SurfaceKind kind, const ClearRange& range) {
  return [taken = taken_by(surfaces, kind, range)](Yuv color) { return taken.has(color); };
}

std::vector<LabelMargin> table_margins(const Lut& lut, const SurfaceColors& surfaces,
                                       const std::stop_token& stop) {
  std::array<bool, label::kMaxCount> in_table{};
  for (const Label label : lut.yuv().labels) in_table[label] = true;
  static const auto kNoise = noise_samples();
  std::vector<LabelMargin> out;
  for (const SurfaceKind kind : {SurfaceKind::kCarpet, SurfaceKind::kFloor}) {
    const std::vector<SurfaceColors::Color> colors = surfaces.colors(kind);
    if (colors.empty()) continue;
    const auto flood = kFloodShare * static_cast<double>(surfaces.total(kind));
    std::array<std::optional<double>, label::kMaxCount> brighter, darker;
    const auto look = [&](double factor, auto& first) {
      if (stop.stop_requested()) return;
      std::array<double, label::kMaxCount> count{};
      for (const auto& [color, pixels] : colors) {
        const Yuv lit = in_light(color, factor);
        for (const auto& noise : kNoise) {
          const auto level = [&](std::size_t c, std::uint8_t value) {
            return static_cast<std::uint8_t>(
                std::clamp(value + surfaces.noise_sigma[c] * noise[c] + 0.5, 0.0, 255.0));
          };
          count[lut.of_yuv(level(0, lit.y), level(1, lit.u), level(2, lit.v))] +=
              static_cast<double>(pixels) / static_cast<double>(kNoise.size());
        }
      }
      for (std::size_t label = 0; label < count.size(); ++label) {
        if (count[label] > flood && !first[label]) first[label] = factor;
      }
    };
    constexpr double kStep = 1.01;
    for (double factor = 1; factor < LabelMargin::kMaxFactor; factor *= kStep) look(factor, brighter);
    for (double factor = 1; factor > 1 / LabelMargin::kMaxFactor; factor /= kStep) look(factor, darker);
    for (std::size_t i = 1; i < label::kMaxCount; ++i) {
      const auto label = static_cast<Label>(i);
      if (in_table[i] && !is_surface_label(label)) out.push_back({label, kind, brighter[i], darker[i]});
    }
  }
  return out;
}

std::optional<MinMargin> min_to_carpet(std::span<const LabelMargin> margins) {
  std::optional<MinMargin> least;
  for (const LabelMargin& margin : margins) {
    if (margin.surface != SurfaceKind::kCarpet) continue;
    for (const auto& factor : {margin.brighter, margin.darker}) {
      if (!factor) continue;
      const double change = *factor - 1;
      if (!least || std::abs(change) < std::abs(least->change)) least = {margin.label, change};
    }
  }
  return least;
}

bool about_same(std::span<const LabelMargin> a, std::span<const LabelMargin> b) {
  constexpr double kAlike = 1.05;
  const auto alike = [](const std::optional<double>& one, const std::optional<double>& other, double limit) {
    const double ratio = one.value_or(limit) / other.value_or(limit);
    return ratio < kAlike && ratio > 1 / kAlike;
  };
  return std::ranges::equal(a, b, [&](const LabelMargin& one, const LabelMargin& other) {
    return one.label == other.label && one.surface == other.surface &&
           alike(one.brighter, other.brighter, LabelMargin::kMaxFactor) &&
           alike(one.darker, other.darker, 1 / LabelMargin::kMaxFactor);
  });
}

}  // namespace sslv
