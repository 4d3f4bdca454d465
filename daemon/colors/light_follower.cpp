// SPDX-License-Identifier: Apache-2.0
#include "colors/light_follower.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace sslv {
namespace {

// Limits for a confirmed robot; each of its dots must also have the colour that belongs to the robot's id.
constexpr double kMaxConfirmedRmsMm = 3, kMinConfirmedR2 = 0.4, kMinConfirmedMargin = 0.3, kMaxMovedMm = 10;
/// Channels at or above kMayBeClipped may be clipped; contrasts below kMinContrast are mostly noise.
constexpr double kMayBeClipped = 245, kMinContrast = 8;
/// Standard deviation (log) between dots of one colour, due to print, shade and blur.
constexpr double kPrintSigma = 0.03;
/// kReferenceDots: number of dots of one team and colour that make a reference. kMinDots: number of a robot's
/// dots that must have a reference.
constexpr int kReferenceDots = 8;
constexpr std::size_t kMinDots = 3;
/// Dots needed to adjust a channel's balance. Dots in which the channel is clipped do not count.
constexpr std::size_t kMinOfChannel = 4;
/// Share of the difference that each image corrects. Brightness follows fast, with noise smoothed; balance
/// follows slowly.
constexpr double kFollowBrightness = 0.7, kFollowBalance = 0.2;
/// Fewer robots cannot separate an area's brightness from the whole image's.
constexpr std::size_t kMinRobotsForAreas = 3;
/// Change of a gain or of an area (log) that requires a new table.
constexpr double kTableStepLog = 0.05, kAreaStepLog = 0.07;
/// A jump of the light is at least kMinJumpLog, and at least the share kAlikeShare of all areas agrees with
/// it to within kAlikeLog.
constexpr double kMinJumpLog = 0.15, kAlikeLog = 0.12, kAlikeShare = 0.8;
/// A busy computer processes few images, so the last confirmed robots may be seconds old.
constexpr double kVanishedWithinS = 3, kTrialS = 2;
constexpr double kMinuteS = 60;
constexpr std::size_t kMaxSteps = 500;

double mean_light(const std::array<double, 3>& values) {
  return (values[0] + values[1] + values[2]) / 3;
}

/// Weighted median of `log`; 0 for an empty list. Sorts the list.
template <class List>
double weighted_median(List& list) {
  if (list.empty()) return 0;
  std::sort(list.begin(), list.end(), [](const auto& a, const auto& b) { return a.log < b.log; });
  double all = 0, sum = 0;
  for (const auto& one : list) all += one.weight;
  for (const auto& one : list) {
    sum += one.weight;
    if (sum >= all / 2) return one.log;
  }
  return list.back().log;
}

std::size_t area_of(const ImageView& image, double x, double y) {
  const auto place = [](double at, int size, int areas) {
    return std::clamp(static_cast<int>(at / size * areas), 0, areas - 1);
  };
  return static_cast<std::size_t>(place(y, image.height, LightState::kRows) * LightState::kColumns +
                                  place(x, image.width, LightState::kColumns));
}

/// A value that grows with the light at a pixel: Y, or green.
std::uint8_t luma_at(const ImageView& image, int x, int y) {
  const std::uint8_t* row = image.row(y);
  if (is_yuv422(image.format)) return row[2 * x + (image.format == PixelFormat::kUyvy ? 1 : 0)];
  if (is_bayer(image.format)) {
    const bool green_first = image.format == PixelFormat::kBayerGr8 || image.format == PixelFormat::kBayerGb8;
    return row[(x & ~1) + ((y % 2 == 0) == green_first ? 0 : 1)];
  }
  return row[bytes_per_pixel(image.format) * x + (bytes_per_pixel(image.format) == 3 ? 1 : 0)];
}

/// Median luma of each area. Most of an area shows the floor.
template <std::size_t N>
std::array<float, N> area_lumas(const ImageView& image) {
  constexpr int kPoints = 9;  // points in each direction
  std::array<float, N> out;
  std::array<std::uint8_t, kPoints * kPoints> values;
  for (std::size_t area = 0; area < N; ++area) {
    const int column = static_cast<int>(area) % LightState::kColumns,
              row = static_cast<int>(area) / LightState::kColumns;
    std::size_t count = 0;
    for (int i = 0; i < kPoints; ++i) {
      for (int k = 0; k < kPoints; ++k) {
        const auto place = [](int at, int point, int size, int areas) {
          return (2 * (at * kPoints + point) + 1) * size / (2 * areas * kPoints);
        };
        values[count++] = luma_at(image, place(column, k, image.width, LightState::kColumns),
                                  place(row, i, image.height, LightState::kRows));
      }
    }
    std::nth_element(values.begin(), values.begin() + count / 2, values.begin() + count);
    out[area] = values[count / 2];
  }
  return out;
}

}  // namespace

const char* name_of(LightFollowing following) {
  switch (following) {
    case LightFollowing::kOff: return "off";
    case LightFollowing::kLearning: return "learning";
    case LightFollowing::kFollowing: return "following";
    case LightFollowing::kAtBound: return "at_bound";
    case LightFollowing::kFrozen: return "frozen";
  }
  return "";
}

LightFollower::LightFollower(std::shared_ptr<const Lut> accepted)
    : tables_{accepted, std::move(accepted), {}} {}

void LightFollower::take_back() {
  set_gain({});
  areas_ = {};
  state_.areas.fill(1);
  carpet_.trial.reset();
  state_.from_carpet = false;
  taken_back_ = true;
  freeze("returned to the accepted table; switch it off and on to follow again");
}

void LightFollower::switch_off() {
  if (state_.following == LightFollowing::kOff) return;
  set_gain({});
  areas_ = {};
  references_.clear();
  last_minute_.clear();
  carpet_ = {};
  taken_back_ = has_followed_ = false;
  state_ = {};
}

void LightFollower::observe(const FollowLightParams& params, const Look& look) {
  if (look.time_s < time_s_) {  // the clock was set back
    carpet_.before.reset();
    if (carpet_.trial) carpet_.trial->began_s = look.time_s;
  }
  time_s_ = look.time_s;
  if (!params.enabled) return switch_off();
  if (taken_back_) return;
  state_.robots = 0;
  if (!look.scene.camera) return freeze("the camera is not calibrated");
  if (look.game_is_running && !params.in_match) return freeze("the game is running");
  if (!last_minute_.empty() && look.time_s < last_minute_.back().first) last_minute_.clear();
  while (!last_minute_.empty() && last_minute_.front().first < look.time_s - kMinuteS)
    last_minute_.pop_front();

  const std::vector<Dot> dots = confirmed_dots(params, look);
  const std::size_t robots = dots.empty() ? 0 : dots.back().robot + 1;
  const auto luma = area_lumas<LightAreas::kCount>(look.image);
  if (robots < static_cast<std::size_t>(params.min_robots)) {
    freeze(robots == 0 ? "no robot is confirmed"
                       : fmt::format("{} of {} robots are confirmed", robots, params.min_robots));
    return try_carpet(params, look, luma);
  }
  const bool followed = follow_robots(params, look, dots);
  if (!followed && has_followed_) {
    freeze("the robots' colours are not known yet");
    return try_carpet(params, look, luma);
  }
  if (!followed) state_.following = LightFollowing::kLearning;
  has_followed_ = has_followed_ || followed;
  learn_references(dots);
  if (robots >= kMinRobotsForAreas) learn_areas(dots);
  for (std::size_t i = 0; i < LightAreas::kCount; ++i) state_.areas[i] = std::exp(areas_.change_log_of(i));
  state_.robots = static_cast<int>(robots);
  state_.last_confirmed_s = look.time_s;
  state_.from_carpet = false;
  carpet_.trial.reset();
  carpet_.before = {look.time_s, luma, look.robots.size()};
}

std::vector<LightFollower::Dot> LightFollower::confirmed_dots(const FollowLightParams& params,
                                                              const Look& look) {
  std::vector<Dot> out;
  std::size_t robots = 0;
  const PatternFitter::Frame frame{look.image, *look.scene.camera, look.patterns, *tables_.in_use,
                                   kUsualBlurPx};
  for (const Robot& robot : look.robots) {
    if (robot.confidence < params.min_confidence) continue;
    const auto code = std::find_if(look.patterns.codes.begin(), look.patterns.codes.end(),
                                   [&](const PatternTable::Code& one) { return one.id == robot.id; });
    if (code == look.patterns.codes.end()) continue;
    const PatternFit fit =
        fitter_.fit(frame, {robot.x_mm, robot.y_mm, robot.orientation_rad}, robot.height_mm, 2);
    const std::size_t sides = look.patterns.dots.size();
    if (fit.seen != static_cast<int>(sides) + 1 || fit.rms_mm > kMaxConfirmedRmsMm ||
        fit.min_r2 < kMinConfirmedR2 ||
        std::hypot(fit.pose.x_mm - robot.x_mm, fit.pose.y_mm - robot.y_mm) > kMaxMovedMm)
      continue;
    const auto color_of = [&](std::size_t i) {
      return i == sides ? look.patterns.team_colors[static_cast<std::size_t>(robot.team)] : code->colors[i];
    };
    std::vector<Dot> dots;
    for (std::size_t i = 0; i <= sides; ++i) {
      const PatternDotFit& dot = fit.dots[i == sides ? PatternFit::kCenter : i];
      if (dot.color != color_of(i) || dot.margin < kMinConfirmedMargin) break;
      Dot& one = dots.emplace_back();
      one.key = {robot.team, dot.color};
      one.robot = robots;
      one.area = area_of(look.image, dot.pixel_x, dot.pixel_y);
      const auto& c = dot.contrast_rgb;
      const double noise = std::sqrt(c[0] * c[0] + c[1] * c[1] + c[2] * c[2]) / std::max(dot.snr, 1.0);
      one.sigma_grey = std::max(1.0, noise / 2);
      for (std::size_t k = 0; k < 3; ++k) {
        one.contrast[k] = c[k];
        one.below_end[k] = dot.color_rgb[k] < kMayBeClipped;
      }
    }
    if (dots.size() != sides + 1) continue;
    out.insert(out.end(), dots.begin(), dots.end());
    ++robots;
  }
  return out;
}

/// Difference (log) of a dot's channel from the value expected from its reference, its area and the gain;
/// nothing if the channel carries little information.
std::optional<LightFollower::Difference> LightFollower::difference(const Dot& dot, std::size_t channel,
                                                                   int min_count) const {
  const auto known = references_.find(dot.key);
  if (known == references_.end() || known->second.count[channel] < min_count || !dot.below_end[channel])
    return std::nullopt;
  const double expected = known->second.contrast[channel] + gain_[channel] + areas_.log_of(dot.area);
  const double grey = std::exp(expected);
  if (grey < kMinContrast) return std::nullopt;
  const double sigma = dot.sigma_grey / grey;
  return Difference{std::log(std::max(dot.contrast[channel], 1.0)) - expected,
                    1 / (sigma * sigma + kPrintSigma * kPrintSigma)};
}

bool LightFollower::follow_robots(const FollowLightParams& params, const Look& look,
                                  const std::vector<Dot>& dots) {
  std::vector<Difference> all;
  std::array<std::vector<Difference>, 3> by_channel;
  std::map<std::size_t, std::size_t> known_dots;  // by robot
  for (const Dot& dot : dots) {
    bool known = false;
    for (std::size_t c = 0; c < 3; ++c) {
      const auto one = difference(dot, c, kReferenceDots);
      if (!one) continue;
      known = true;
      all.push_back(*one);
      by_channel[c].push_back(*one);
    }
    if (known) ++known_dots[dot.robot];
  }
  const auto robots = std::count_if(known_dots.begin(), known_dots.end(),
                                    [](const auto& entry) { return entry.second >= kMinDots; });
  if (robots < params.min_robots) return false;

  const double brightness = weighted_median(all);
  Log3 gain = gain_, turn{};
  for (std::size_t c = 0; c < 3; ++c) {
    if (by_channel[c].size() >= kMinOfChannel) turn[c] = weighted_median(by_channel[c]) - brightness;
  }
  for (std::size_t c = 0; c < 3; ++c)
    gain[c] += kFollowBrightness * brightness + kFollowBalance * (turn[c] - mean_light(turn));
  std::string bound;
  set_gain(bounded(params, gain, bound));
  last_minute_.emplace_back(look.time_s, gain_);
  state_.following = bound.empty() ? LightFollowing::kFollowing : LightFollowing::kAtBound;
  state_.why = bound;
  return true;
}

void LightFollower::learn_references(const std::vector<Dot>& dots) {
  for (const Dot& dot : dots) {
    Reference& reference = references_[dot.key];
    for (std::size_t c = 0; c < 3; ++c) {
      if (reference.count[c] >= kReferenceDots || !dot.below_end[c] || dot.contrast[c] < kMinContrast)
        continue;
      const double log = std::log(dot.contrast[c]) - gain_[c] - areas_.log_of(dot.area);
      reference.contrast[c] += (log - reference.contrast[c]) / ++reference.count[c];
    }
  }
}

void LightFollower::learn_areas(const std::vector<Dot>& dots) {
  struct Seen {
    std::size_t area;
    double log;
  };
  std::vector<Seen> robots;
  std::vector<Difference> of_robots;
  for (std::size_t i = 0; i < dots.size();) {
    std::vector<Difference> differences;
    const std::size_t first = i;
    for (; i < dots.size() && dots[i].robot == dots[first].robot; ++i) {
      for (std::size_t c = 0; c < 3; ++c) {
        if (const auto one = difference(dots[i], c, 1)) differences.push_back(*one);
      }
    }
    if (differences.size() < kMinDots) continue;
    robots.push_back({dots[first].area, weighted_median(differences)});
    of_robots.push_back({robots.back().log, 1});
  }
  // The difference common to all robots belongs to the whole image.
  const double common = weighted_median(of_robots);
  for (const Seen& seen : robots) areas_.learn(seen.area, areas_.log_of(seen.area) + seen.log - common);
}

/// If robots suddenly disappear while the floor becomes brighter or darker by the same factor everywhere, a
/// lamp or the camera's exposure has changed. Then changes the gain by that factor on trial.
void LightFollower::try_carpet(const FollowLightParams& params, const Look& look, const AreaLuma& luma) {
  if (carpet_.trial) {
    if (look.time_s - carpet_.trial->began_s <= kTrialS) return;
    set_gain(carpet_.trial->gain);
    carpet_.trial.reset();
    carpet_.before.reset();
    state_.from_carpet = false;
    return;
  }
  if (!carpet_.before || look.time_s - carpet_.before->time_s > kVanishedWithinS ||
      2 * look.robots.size() >= carpet_.before->robots)
    return;
  std::array<double, LightAreas::kCount> logs;
  for (std::size_t i = 0; i < LightAreas::kCount; ++i)
    logs[i] = std::log(std::max(luma[i], 1.0F) / std::max(carpet_.before->luma[i], 1.0F));
  auto sorted = logs;
  std::nth_element(sorted.begin(), sorted.begin() + LightAreas::kCount / 2, sorted.end());
  const double jump = sorted[LightAreas::kCount / 2];
  const auto alike =
      std::count_if(logs.begin(), logs.end(), [&](double log) { return std::abs(log - jump) < kAlikeLog; });
  if (std::abs(jump) < kMinJumpLog || static_cast<double>(alike) < kAlikeShare * LightAreas::kCount) return;
  carpet_.trial = {look.time_s, gain_};
  Log3 gain = gain_;
  for (double& one : gain) one += jump;
  std::string bound;
  set_gain(bounded(params, gain, bound));
  state_.from_carpet = true;
}

/// Limits the gain to the bounds. Sets `bound` to the user-readable name of the bound that was reached, if
/// any.
LightFollower::Log3 LightFollower::bounded(const FollowLightParams& params, Log3 gain,
                                           std::string& bound) const {
  const auto limit = [&](double wanted, double most, double max_per_min, const auto& of, const char* what) {
    const double total = std::log(most), per_min = std::log(max_per_min);
    double low = -total, high = total;
    for (const auto& [then_s, then] : last_minute_) {
      low = std::max(low, of(then) - per_min);
      high = std::min(high, of(then) + per_min);
    }
    low = std::max(low, -total), high = std::max(low, std::min(high, total));
    const double allowed = std::clamp(wanted, low, high);
    if (std::abs(allowed - wanted) > 0.01 && bound.empty()) {
      bound =
          std::abs(allowed) > total - 1e-6
              ? fmt::format("the {} differs from the accepted table's by more than a factor {:g}", what, most)
              : fmt::format("the {} changes by more than a factor {:g} in a minute", what, max_per_min);
    }
    return allowed;
  };
  const double brightness =
      limit(mean_light(gain), params.max_brightness, params.max_brightness_per_min, mean_light, "brightness");
  const double mean = mean_light(gain);
  for (std::size_t c = 0; c < 3; ++c) {
    gain[c] = brightness + limit(
                               gain[c] - mean, params.max_balance, params.max_balance_per_min,
                               [c](const Log3& then) { return then[c] - mean_light(then); }, "colour");
  }
  return gain;
}

void LightFollower::set_gain(const Log3& gain) {
  gain_ = gain;
  for (std::size_t c = 0; c < 3; ++c) state_.gain[c] = std::exp(gain[c]);
}

void LightFollower::freeze(std::string why) {
  state_.following = LightFollowing::kFrozen;
  state_.why = std::move(why);
}

LightChange LightFollower::change() const {
  LightChange out;
  for (std::size_t c = 0; c < 3; ++c) out.gain[c] = std::exp(gain_[c]);
  const auto [least, greatest] = std::minmax_element(state_.areas.begin(), state_.areas.end());
  if (std::log(*least) < -kAreaStepLog) out.darkest_area = *least;
  if (std::log(*greatest) > kAreaStepLog) out.brightest_area = *greatest;
  return out;
}

std::shared_ptr<const Lut> LightFollower::new_table() {
  LightChange wanted = change();
  const auto apart = [](const LightChange& a, const LightChange& b) {
    double most = 0;
    for (std::size_t c = 0; c < 3; ++c)
      most = std::max(most, std::abs(std::log(a.gain[c] / b.gain[c])) / kTableStepLog);
    most = std::max(most, std::abs(std::log(a.darkest_area / b.darkest_area)) / kAreaStepLog);
    return std::max(most, std::abs(std::log(a.brightest_area / b.brightest_area)) / kAreaStepLog);
  };
  const bool is_back = apart(wanted, {}) < 1 && apart(wanted, tables_.change) >= 1;
  if (wanted == LightChange{} || is_back) {
    wanted = {};
    if (tables_.change == wanted) return nullptr;
  } else if (apart(wanted, tables_.change) < 1) {
    return nullptr;
  }
  tables_.change = wanted;
  tables_.in_use = wanted == LightChange{}
                       ? tables_.accepted
                       : std::make_shared<const Lut>(table_in_light(*tables_.accepted, wanted));
  steps_.push_back({time_s_, wanted, state_.robots, state_.from_carpet});
  if (steps_.size() > kMaxSteps) steps_.pop_front();
  return tables_.in_use;
}

}  // namespace sslv
