// SPDX-License-Identifier: Apache-2.0
#include "vision/ball_fit.h"

#include "geometry/plane_patch.h"
#include "vision/sample_planes.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>

#include <Eigen/Dense>

namespace sslv {
namespace {

/// Width of the ring of carpet around the ball. For pixels larger than kUsualPixelMm it grows by kMarginGrows
/// mm per mm; otherwise the ring would contain no samples. In YUV images it is only ensured to be at least
/// one pixel wide, because the chroma samples are twice as wide and would extend further out.
constexpr double kMarginMm = 9, kUsualPixelMm = 6.1, kMarginGrows = 1.7;
constexpr double kWanderMm = 5;  // samples are complete for centres up to this far from the start
constexpr int kPasses = 4;
/// If a smaller share of the ball is visible, any object fits.
constexpr double kMinVisible = 0.3;
/// With fewer values than this in all planes together, any object fits.
constexpr int kMinValues = 6;
constexpr double kMinVariance = 0.5;
constexpr double kMaxStepMm = 8, kSmallStepMm = 0.6;
/// If the result is this far from the start, the fit is repeated from the result.
constexpr double kFarMm = 4;
/// The fit fails instead of being repeated if r2 is below kHopelessR2 and cells are smaller than kLargeCell
/// radii.
constexpr double kHopelessR2 = 0.15, kLargeCell = 0.75;
/// Carpet samples differ from their median by at most this many sigmas.
constexpr float kOddCarpet = 4.5F;
constexpr float kMinSpread = 2.5F;
constexpr float kOddReachPx = 1.2F;
constexpr double kMinClear = 0.5;  // share of the ring's samples that should remain
/// One side of a ball differs from its middle by about this share of its contrast.
constexpr float kShading = 0.3F;
/// Value of PlaneSamples::keep for a sample that a robot hides.
constexpr float kHidden = -1;
/// Value of PlaneSamples::keep for an outlier: a sample that does not match the model, such as a highlight or
/// a shadow. It counts only in the residuals.
constexpr float kUnlikeModel = -0.5F;
/// Outliers differ from the model by more than kUnlike sigmas and by more than the share kUnlikeShare of the
/// contrast. Samples within kUnlikeFrom of the silhouette determine the position and are never left out.
constexpr float kUnlike = 3, kUnlikeShare = 0.12F, kUnlikeFrom = 0.3F;
/// With fewer samples of a plane, and in Bayer images, outliers cannot be recognised.
constexpr std::size_t kMinOfPlane = 28;
/// Prior for shading by direction, which is a small part of the light; in units of one grey level squared.
constexpr double kShadePrior = 0.5;

/// Whether a robot's body, an upright prism from the floor to its top, hides a point of the floor from the
/// camera.
class Hides {
 public:
  Hides(const Robot& robot, const CameraModel& camera, double radius_mm, double front_mm)
      : robot_(robot),
        c_(std::cos(robot.orientation_rad)),
        s_(std::sin(robot.orientation_rad)),
        camera_(camera.position_mm()),
        radius_mm_(radius_mm),
        front_mm_(front_mm) {}

  /// `place_mm` is where the sample's ray meets the plane z = height_mm.
  bool at(const Eigen::Vector2d& place_mm, double height_mm) const {
    // The ray from that plane up to the robot's top, in the robot's frame.
    const double up = (robot_.height_mm - height_mm) / (camera_.z() - height_mm);
    const Eigen::Vector2d top_mm = place_mm + up * (camera_.head<2>() - place_mm);
    constexpr int kSteps = 8;
    for (int i = 0; i <= kSteps; ++i) {
      const Eigen::Vector2d p = place_mm + (top_mm - place_mm) * (static_cast<double>(i) / kSteps);
      const double dx = p.x() - robot_.x_mm, dy = p.y() - robot_.y_mm;
      if (dx * dx + dy * dy < radius_mm_ * radius_mm_ && c_ * dx + s_ * dy < front_mm_) return true;
    }
    return false;
  }
  bool is_near(double x_mm, double y_mm, double reach_mm) const {
    const double dx = robot_.x_mm - x_mm, dy = robot_.y_mm - y_mm;
    const double lean = (camera_.head<2>() - Eigen::Vector2d(x_mm, y_mm)).norm() * robot_.height_mm /
                        std::max(1.0, camera_.z() - robot_.height_mm);
    const double near_mm = radius_mm_ + reach_mm + lean;
    return dx * dx + dy * dy < near_mm * near_mm;
  }

 private:
  const Robot& robot_;
  double c_, s_;
  Eigen::Vector3d camera_;
  double radius_mm_, front_mm_;
};

/// Median of 8-bit values.
class Median {
 public:
  void add(float value) {
    ++counts_[static_cast<std::uint8_t>(value)];
    ++total_;
  }
  std::size_t count() const { return total_; }
  float get() const {
    std::size_t below = 0, value = 0;
    while (below + counts_[value] <= total_ / 2) below += counts_[value++];
    return static_cast<float>(value);
  }

 private:
  std::array<std::uint16_t, 256> counts_{};
  std::size_t total_ = 0;
};

double margin_mm(double mm_per_px, bool yuv) {
  return yuv ? std::max(kMarginMm, mm_per_px)
             : kMarginMm + kMarginGrows * std::max(0.0, mm_per_px - kUsualPixelMm);
}

float as_float(double value) {
  return static_cast<float>(value);
}

}  // namespace

/// Position of a sample in the ball's model.
struct BallFitter::Place {
  float nx, ny;                 // gradient, on the plane, of the ray's distance from the ball's centre
  float z;                      // -1: outside the blurred silhouette, 1: inside
  float slope;                  // change of the sample's covered share with the radius, 1 / mm
  std::array<float, 5> column;  // the model's columns from kCover on

  /// Returns false if the sample lies outside the ball's surroundings. `sigma_*2`: squared blur of a sample
  /// (px^2).
  bool look_up(const BallTemplate& ball, float u, float v, float sigma_x2, float sigma_y2) {
    const KernelPatch& patch = ball.patch;
    const float x = u * (patch.xu + patch.xuu * u + patch.xuv * v) + v * (patch.xv + patch.xvv * v) - ball.x;
    const float y = u * (patch.yu + patch.yuu * u + patch.yuv * v) + v * (patch.yv + patch.yvv * v) - ball.y;
    const float gx = ball.mxx * x + ball.mxy * y, gy = ball.mxy * x + ball.myy * y;
    const float r2 = std::max(gx * x + gy * y, 1e-6F);
    if (!(r2 < ball.outer_radius * ball.outer_radius)) return false;
    const float r = std::sqrt(r2);
    nx = gx / r, ny = gy / r;
    const float right = patch.xu * nx + patch.yu * ny, down = patch.xv * nx + patch.yv * ny;
    const float s2 = sigma_x2 * right * right + sigma_y2 * down * down + 1e-6F;
    const float half_mm = 3 * std::sqrt(s2);
    z = std::clamp((ball.radius - s2 * 0.5F / ball.radius - r) / half_mm, -1.0F, 1.0F);
    const float z2 = z * z, w = 1 - z2;
    const float cover = 0.5F + z * (35.0F / 32) * (1 + z2 * (-1 + z2 * (0.6F - z2 / 7)));
    slope = 35.0F / 32 * w * w * w / half_mm;
    const float up = std::sqrt(std::max(0.0F, 1 - r2 / (ball.radius * ball.radius)));
    column = {cover, cover * x / ball.radius, cover * y / ball.radius, cover * up, 1};
    return true;
  }
  /// Residual of a value.
  float left(const std::array<float, 5>& weights, float value) const {
    for (std::size_t a = 0; a < column.size(); ++a) value -= weights[a] * column[a];
    return value;
  }
};

struct BallFitter::Group {
  PlaneSamples samples;
  /// Indices of the samples that no robot hides.
  struct Places {
    std::array<std::uint16_t, 1024> at;
    std::size_t count = 0;
    void add(std::size_t place) {
      if (count < at.size()) at[count++] = static_cast<std::uint16_t>(place);
    }
    std::span<const std::uint16_t> all() const { return std::span(at).first(count); }
  };
  Places core, rim, ring;  // samples on the ball, just outside its silhouette, further out
  std::array<Place, PlaneSamples::kMax> places;  // model positions; set by leave_out_unlike()
  RectangleSamples flat;
};

/// State of a fit from one start position.
struct BallFitter::Look {
  PlanePatch patch;
  SamplePlanes planes;
  BallTemplate ball;
  std::size_t groups = 0;
  int around = 0;
  /// For each plane, in order: weights of the model's columns from kCover on, and the contrast.
  std::array<std::array<float, 5>, 3> weights{};
  std::array<float, 3> contrast{};
};

BallFitter::BallFitter() : look_(std::make_unique<Look>()) {
  for (auto& group : groups_) group = std::make_unique<Group>();
}
BallFitter::~BallFitter() = default;

BallFit BallFitter::fit(const Frame& frame, double x_mm, double y_mm, const MayBeBall& may_be_ball) noexcept {
  BallFit out;
  double from_x_mm = x_mm, from_y_mm = y_mm;
  constexpr int kStarts = 3;
  for (int start = 1; start <= kStarts; ++start) {
    out = fit_from(frame, from_x_mm, from_y_mm, may_be_ball);
    // The surroundings and the hidden parts were determined for the start position. If the result is far from
    // the start, fit again from the result.
    if (!out.ok || out.moved_mm < kFarMm) break;
    // If a ball hardly explains the image and the fit moves far away, the object is a letter, a stripe or a
    // shirt. But if cells are as large as the ball's radius, the first start position itself may be that far
    // off.
    const double cell_mm = (look_->groups == 3 ? 2 : 1) * look_->patch.mm_per_px();
    if (out.r2 < kHopelessR2 && cell_mm < kLargeCell * frame.radius_mm) {
      out.ok = false;
      break;
    }
    from_x_mm = out.x_mm;
    from_y_mm = out.y_mm;
  }
  out.moved_mm = std::hypot(out.x_mm - x_mm, out.y_mm - y_mm);
  out.ok = out.ok && out.moved_mm < frame.radius_mm;
  return out;
}

/// Reads the samples on and around the ball, marks the samples that robots hide, and sorts the other samples
/// into core, rim and ring.
bool BallFitter::read(const Frame& frame, Look& look, BallFit& out) noexcept {
  // Squared distance of a ray from the ball's centre, given the point p where the ray meets the plane: |p|^2
  // - (n p)^2. The ray's direction n is nearly constant over a ball.
  const auto ray = frame.camera.ray(look.patch.pixel);
  if (!ray) return false;
  const Eigen::Vector3d n = ray->normalized();
  const double outer_mm = frame.radius_mm + margin_mm(look.patch.mm_per_px(), look.planes.yuv);
  BallTemplate& ball = look.ball;
  ball = {kernel_patch(look.patch),
          0,
          0,
          as_float(frame.radius_mm),
          as_float(outer_mm),
          as_float(1 - n.x() * n.x()),
          as_float(-n.x() * n.y()),
          as_float(1 - n.y() * n.y()),
          as_float(frame.blur_px),
          1};
  // The more obliquely the ball is seen, the longer its image.
  const double longest = 1 / std::abs(n.z());

  boost::container::static_vector<Hides, 4> hiding;
  for (const Robot& robot : frame.robots) {
    const Hides hides(robot, frame.camera, frame.robot_radius_mm, frame.robot_front_mm);
    if (hiding.size() < hiding.capacity() &&
        hides.is_near(look.patch.field_mm.x(), look.patch.field_mm.y(), outer_mm + kWanderMm))
      hiding.push_back(hides);
  }
  const float radius2 = ball.radius * ball.radius, outer2 = ball.outer_radius * ball.outer_radius;
  int on_ball = 0, visible = 0;  // values
  for (; look.groups < 3 && !look.planes.groups[look.groups].empty(); ++look.groups) {
    const auto& grids = look.planes.groups[look.groups];
    Group& group = *groups_[look.groups];
    PlaneSamples& samples = group.samples;
    samples.count = 0;
    for (const SampleGrid& grid : grids)
      read_samples(ball.patch, 0, 0, as_float((outer_mm + kWanderMm) * longest), frame.image, grid, samples);
    const auto count = static_cast<std::size_t>(samples.count);
    std::fill_n(samples.keep.begin(), count, 1.0F);
    group.core.count = group.rim.count = group.ring.count = 0;
    const float inner_mm = ball.radius + 0.9F * as_float(look.patch.mm_per_px()) * grids.front().wide_px;
    const float inner2 = inner_mm * inner_mm;
    for (std::size_t i = 0; i < count; ++i) {
      const float u = samples.u[i], v = samples.v[i];
      const float x = ball.patch.xu * u + ball.patch.xv * v, y = ball.patch.yu * u + ball.patch.yv * v;
      const float r2 = ball.mxx * x * x + 2 * ball.mxy * x * y + ball.myy * y * y;
      if (r2 > outer2) continue;
      const bool hidden = std::any_of(hiding.begin(), hiding.end(), [&](const Hides& hides) {
        return hides.at(look.patch.field_mm + look.patch.to_plane(u, v), frame.radius_mm);
      });
      if (hidden) samples.keep[i] = kHidden;
      if (r2 < radius2) {
        on_ball += samples.planes;
        visible += hidden ? 0 : samples.planes;
      } else if (r2 > inner2) {
        ++look.around;
      }
      if (!hidden) (r2 > inner2 ? group.ring : r2 > radius2 ? group.rim : group.core).add(i);
    }
  }
  out.visible_share = on_ball > 0 ? static_cast<double>(visible) / on_ball : 0;
  return on_ball >= kMinValues && out.visible_share >= kMinVisible;
}

/// Treats the majority of the samples around the ball as carpet and leaves out the other samples.
void BallFitter::leave_out_odd(const Look& look, BallFit& out) noexcept {
  struct Odd {
    float u, v;
  };
  boost::container::static_vector<Odd, 256> odd;
  int clear = 0;
  for (std::size_t g = 0; g < look.groups; ++g) {
    const Group& group = *groups_[g];
    const auto ring = group.ring.all();
    clear += static_cast<int>(ring.size());
    if (ring.size() < 5) continue;
    for (std::size_t p = 0; p < static_cast<std::size_t>(group.samples.planes); ++p) {
      const auto& value = group.samples.value[p];
      Median values, distances;
      for (const std::uint16_t i : ring) values.add(value[i]);
      const float middle = values.get();
      for (const std::uint16_t i : ring) distances.add(std::abs(value[i] - middle));
      // For a normal distribution, sigma is 1.48 times the median distance.
      const float limit = kOddCarpet * std::max(1.48F * distances.get(), kMinSpread);
      const auto leave_out = [&](std::size_t i) {
        if (odd.size() < odd.capacity()) odd.push_back({group.samples.u[i], group.samples.v[i]});
      };
      for (const std::uint16_t i : ring) {
        if (std::abs(value[i] - middle) > limit) leave_out(i);
      }
      // Samples at the silhouette show the ball, the carpet or a mixture of both. Samples with other values
      // show a line that runs under the ball.
      Median inside;
      for (const std::uint16_t i : group.core.all()) inside.add(value[i]);
      if (group.core.count == 0) continue;
      const float core = inside.get(), slack = limit + kShading * std::abs(core - middle);
      const float low = std::min(middle, core) - slack, high = std::max(middle, core) + slack;
      for (const std::uint16_t i : group.rim.all()) {
        if (value[i] < low || value[i] > high) leave_out(i);
      }
    }
  }
  if (!odd.empty()) {
    // These samples are left out in all planes, together with their neighbours, which show half of the same
    // object.
    const auto is_odd = [&](std::size_t g, std::size_t i, bool narrow) {
      const PlaneSamples& samples = groups_[g]->samples;
      const SampleGrid& grid = look.planes.groups[g].front();
      const float reach_px = kOddReachPx + (narrow ? grid.wide_px : static_cast<float>(grid.step_x));
      return std::any_of(odd.begin(), odd.end(), [&](const Odd& other) {
        const float du = samples.u[i] - other.u, dv = samples.v[i] - other.v;
        return du * du + dv * dv < reach_px * reach_px;
      });
    };
    const auto count_clear = [&](const auto& is_clear) {
      int count = 0;
      for (std::size_t g = 0; g < look.groups; ++g) {
        for (const std::uint16_t i : groups_[g]->ring.all()) count += is_clear(g, i) ? 1 : 0;
      }
      return count;
    };
    // In Bayer images, samples of one colour are so far apart that hardly any might remain if the neighbours
    // were left out, too.
    const bool narrow = look.groups == 3 && count_clear([&](std::size_t g, std::size_t i) {
                                              return !is_odd(g, i, false);
                                            }) < kMinClear * look.around;
    for (std::size_t g = 0; g < look.groups; ++g) {
      PlaneSamples& samples = groups_[g]->samples;
      for (std::size_t i = 0; i < static_cast<std::size_t>(samples.count); ++i) {
        if (is_odd(g, i, narrow)) samples.keep[i] = std::min(samples.keep[i], 0.0F);
      }
    }
    clear = count_clear([&](std::size_t g, std::size_t i) { return groups_[g]->samples.keep[i] > 0; });
  }
  out.clear_share = look.around > 0 ? static_cast<double>(clear) / look.around : 0;
}

/// Leaves out highlights on the ball and its shadow beside it, which would bias the position. Returns the
/// number of samples left out.
int BallFitter::leave_out_unlike(const Look& look) noexcept {
  constexpr float kNowhere = 2;  // z of a sample outside the ball's surroundings
  int count = 0;
  std::size_t first = 0;
  for (std::size_t g = 0; g < look.groups; ++g) {
    PlaneSamples& samples = groups_[g]->samples;
    auto& places = groups_[g]->places;
    const auto planes = static_cast<std::size_t>(samples.planes), n = static_cast<std::size_t>(samples.count);
    const float wide_px = look.planes.groups[g].front().wide_px;
    const float sigma_x2 = look.ball.blur_px * look.ball.blur_px + wide_px * wide_px / 12;
    const float sigma_y2 = look.ball.blur_px * look.ball.blur_px + 1.0F / 12;
    for (std::size_t i = 0; i < n; ++i) {
      if (!places[i].look_up(look.ball, samples.u[i], samples.v[i], sigma_x2, sigma_y2))
        places[i].z = kNowhere;
    }
    for (std::size_t p = 0; p < planes; ++p) {
      const auto& weights = look.weights[first + p];
      Median lefts;
      const auto left_of = [&](std::size_t i) {
        return std::abs(places[i].left(weights, samples.value[p][i]));
      };
      for (std::size_t i = 0; i < n; ++i) {
        if (samples.keep[i] > 0 && places[i].z != kNowhere) lefts.add(std::min(255.0F, left_of(i)));
      }
      if (lefts.count() < kMinOfPlane) continue;
      const float limit = std::max({kUnlike * 1.48F * (lefts.get() + 0.5F),
                                    kUnlikeShare * std::abs(look.contrast[first + p]), kUnlike * kMinSpread});
      for (std::size_t i = 0; i < n; ++i) {
        if (samples.keep[i] > 0 && places[i].z != kNowhere && std::abs(places[i].z) > kUnlikeFrom &&
            left_of(i) > limit) {
          samples.keep[i] = kUnlikeModel;
          ++count;
        }
      }
    }
    first += planes;
  }
  return count;
}

void BallFitter::judge(BallFit& out) const noexcept {
  const Look& look = *look_;
  constexpr std::size_t kSectors = 8, kHarmonics = 6;
  float outside = 0, left2 = 0, kept = 0, values = 0;
  std::array<float, kSectors> sector{}, sector_weight{};
  std::array<float, kHarmonics> along{}, length2{};
  const BallTemplate& ball = look.ball;
  Place place{};
  std::size_t first = 0;  // first plane of the group
  for (std::size_t g = 0; g < look.groups; ++g) {
    const PlaneSamples& samples = groups_[g]->samples;
    const auto planes = static_cast<std::size_t>(samples.planes);
    const float wide_px = look.planes.groups[g].front().wide_px;
    const float sigma_x2 = ball.blur_px * ball.blur_px + wide_px * wide_px / 12;
    const float sigma_y2 = ball.blur_px * ball.blur_px + 1.0F / 12;
    float energy = 0;
    for (std::size_t p = 0; p < planes; ++p) energy += look.contrast[first + p] * look.contrast[first + p];
    for (std::size_t i = 0; i < static_cast<std::size_t>(samples.count); ++i) {
      if (samples.keep[i] == kHidden) continue;
      if (!place.look_up(ball, samples.u[i], samples.v[i], sigma_x2, sigma_y2)) continue;
      const float nx = place.nx, ny = place.ny;
      const float length = std::sqrt(nx * nx + ny * ny), c = nx / length, s = ny / length;
      const float c2 = c * c - s * s, d2 = 2 * c * s, c3 = c * c2 - s * d2, d3 = s * c2 + c * d2;
      const std::array<float, kHarmonics> wave{c2, d2, c3, d3, c2 * c2 - d2 * d2, 2 * c2 * d2};
      float projected = 0;
      for (std::size_t p = 0; p < planes; ++p) {
        const auto& weight = look.weights[first + p];
        const float value = samples.value[p][i];
        projected += look.contrast[first + p] * (value - weight[4]);
        if (!(samples.keep[i] > 0 || samples.keep[i] == kUnlikeModel)) continue;
        const float left = place.left(weight, value);
        left2 += left * left;
        ++values;
        if (samples.keep[i] == kUnlikeModel) continue;
        for (std::size_t k = 0; k < kHarmonics; ++k) {
          const float pull = weight[0] * place.slope * wave[k];
          along[k] += pull * left;
          length2[k] += pull * pull;
        }
      }
      if (samples.keep[i] > 0 || samples.keep[i] == kUnlikeModel) kept += energy;
      if (place.z <= -0.8F) {
        outside += energy;
        const float angle = std::atan2(ny, nx) * (0.5F / 3.14159265F) + 0.5F;
        const auto at = std::min(kSectors - 1, static_cast<std::size_t>(angle * kSectors));
        sector[at] += std::clamp(projected, -energy, 1.5F * energy);
        sector_weight[at] += energy;
      }
    }
    first += planes;
  }
  for (std::size_t k = 0; k < kSectors; ++k) {
    const float slack = outside / (2 * kSectors);
    out.max_alike = std::max(out.max_alike, static_cast<double>(sector[k] / (sector_weight[k] + slack)));
  }
  out.misfit = kept > 0 ? std::sqrt(left2 / kept) : 1;
  double squares = 0, variance = 0;
  const double left_variance = std::max(1.0, static_cast<double>(left2 / std::max(1.0F, values)));
  for (std::size_t k = 0; k < kHarmonics; ++k) {
    const double known = static_cast<double>(length2[k]) + left_variance / 25;  // prior: 5 mm
    squares += static_cast<double>(along[k] * along[k]) / (known * known);
    variance += left_variance / known;
  }
  out.out_of_round_mm = std::sqrt(squares);
  out.out_of_round_sigma_mm = std::sqrt(variance);
}

double BallFitter::rectangle_gain(const Frame& frame, const BallFit& found) noexcept {
  // Fits again at the ball's final position, so that the surroundings are determined for this position.
  if (!fit_from(frame, found.x_mm, found.y_mm, {}).ok) return -1;
  const Look& look = *look_;
  const BallTemplate& ball = look.ball;
  Place place{};
  std::array<double, 3> left2{};
  std::array<RectangleSamples*, 3> groups{};
  std::size_t first = 0;
  for (std::size_t g = 0; g < look.groups; ++g) {
    const PlaneSamples& samples = groups_[g]->samples;
    RectangleSamples& flat = groups_[g]->flat;
    groups[g] = &flat;
    flat.count = 0;
    flat.planes = static_cast<std::size_t>(samples.planes);
    const float wide_px = look.planes.groups[g].front().wide_px;
    const float sigma_x2 = ball.blur_px * ball.blur_px + wide_px * wide_px / 12;
    const float sigma_y2 = ball.blur_px * ball.blur_px + 1.0F / 12;
    const KernelPatch& patch = ball.patch;
    const auto covariance = [&](float a_u, float a_v, float b_u, float b_v) {
      return static_cast<double>(sigma_x2 * a_u * b_u + sigma_y2 * a_v * b_v);
    };
    flat.blur_mm2 = {{{covariance(patch.xu, patch.xv, patch.xu, patch.xv),
                       covariance(patch.xu, patch.xv, patch.yu, patch.yv)},
                      {covariance(patch.xu, patch.xv, patch.yu, patch.yv),
                       covariance(patch.yu, patch.yv, patch.yu, patch.yv)}}};
    for (std::size_t i = 0; i < static_cast<std::size_t>(samples.count); ++i) {
      const bool is_unlike = samples.keep[i] == kUnlikeModel;
      if (!(samples.keep[i] > 0 || is_unlike) || flat.count == RectangleSamples::kMax) continue;
      const float u = samples.u[i], v = samples.v[i];
      if (!place.look_up(ball, u, v, sigma_x2, sigma_y2)) continue;
      // A highlight supports neither model.
      if (is_unlike && place.z > 0) continue;
      flat.x[flat.count] = u * (patch.xu + patch.xuu * u + patch.xuv * v) + v * (patch.xv + patch.xvv * v);
      flat.y[flat.count] = u * (patch.yu + patch.yuu * u + patch.yuv * v) + v * (patch.yv + patch.yvv * v);
      for (std::size_t p = 0; p < flat.planes; ++p) {
        const float value = samples.value[p][i], left = place.left(look.weights[first + p], value);
        flat.value[p][flat.count] = value;
        left2[first + p] += static_cast<double>(left * left);
      }
      ++flat.count;
    }
    first += flat.planes;
  }
  // A square of the same area as the ball's image.
  const double half_mm = std::sqrt(std::numbers::pi) / 2 * frame.radius_mm;
  fit_rectangle({static_cast<double>(ball.x), static_cast<double>(ball.y), half_mm, half_mm, 0},
                std::span(groups).first(look.groups));
  double sum = 0, count = 0;
  first = 0;
  for (std::size_t g = 0; g < look.groups; ++g) {
    const auto n = static_cast<double>(groups[g]->count);
    for (std::size_t p = 0; p < groups[g]->planes && n > 0; ++p) {
      sum += n * std::log((left2[first + p] / n + kMinVariance) / (groups[g]->left2[p] / n + kMinVariance));
      count += n;
    }
    first += groups[g]->planes;
  }
  return count > 0 ? sum / count : 0;
}

BallFit BallFitter::fit_from(const Frame& frame, double x_mm, double y_mm,
                             const MayBeBall& may_be_ball) noexcept {
  BallFit out;
  const double reach_mm = frame.radius_mm + kMarginMm + kWanderMm;
  const auto patch = plane_patch(frame.camera, {x_mm, y_mm}, frame.radius_mm, reach_mm);
  if (!patch) return out;
  Look& look = *look_;
  look = {*patch, sample_planes(frame.image.format), {}, 0, 0};
  if (!read(frame, look, out)) return out;
  leave_out_odd(look, out);
  BallTemplate& ball = look.ball;

  using Columns = Eigen::Matrix<double, 5, 1>;
  std::array<double, 3> contrast{}, color{};
  bool trimmed = false;
  for (int pass = 1; pass <= kPasses; ++pass) {
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();  // x, y, radius
    Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
    double explained = 0, total = 0;
    std::size_t next = 0;
    for (std::size_t g = 0; g < look.groups; ++g) {
      ball.wide_px = look.planes.groups[g].front().wide_px;
      const BallSums sums = sum_ball(ball, groups_[g]->samples);
      const auto product = [&](int a, int b) {
        return static_cast<double>(
            a >= b ? sums.products[static_cast<std::size_t>(a)][static_cast<std::size_t>(b)]
                   : sums.products[static_cast<std::size_t>(b)][static_cast<std::size_t>(a)]);
      };
      const double count = product(kGround, kGround);
      if (count < 4 || product(kCover, kCover) < 0.5) return out;
      Eigen::Matrix<double, 5, 5> gram;
      for (int a = 0; a < 5; ++a) {
        for (int b = 0; b < 5; ++b) gram(a, b) = product(kCover + a, kCover + b);
      }
      for (int a = kShadeX; a <= kShadeUp; ++a) gram(a - kCover, a - kCover) += kShadePrior;
      const Eigen::LDLT<Eigen::Matrix<double, 5, 5>> solver(gram);
      Eigen::Matrix<double, 5, 3> cross;
      for (int a = 0; a < 5; ++a) {
        for (int b = 0; b < 3; ++b) cross(a, b) = product(kCover + a, b);
      }
      const Eigen::Matrix<double, 5, 3> eliminated = solver.solve(cross);
      for (std::size_t p = 0; p < static_cast<std::size_t>(groups_[g]->samples.planes); ++p, ++next) {
        const auto& plane = sums.planes[p];
        Columns with;
        for (int a = 0; a < 5; ++a)
          with[a] = static_cast<double>(plane.with[static_cast<std::size_t>(kCover + a)]);
        const Columns s = solver.solve(with);
        const double left = std::max(0.0, static_cast<double>(plane.square) - s.dot(with));
        const double free = std::max(1.0, count - 7);  // degrees of freedom of the residuals
        const double variance = std::max(left / free, kMinVariance);
        const double mean = with[kGround - kCover] / count;
        const double all = std::max(0.0, static_cast<double>(plane.square) - count * mean * mean);
        total += all / (count - 1) / variance;
        explained += (all / (count - 1) - left / free) / variance;
        // The contrast at the silhouette is `edge`; the middle is brighter by the upward shading.
        const double edge = s[0];
        contrast[next] = edge + 0.7 * s[kShadeUp - kCover];
        color[next] = contrast[next] + s[kGround - kCover];
        for (int a = 0; a < 5; ++a) look.weights[next][static_cast<std::size_t>(a)] = as_float(s[a]);
        look.contrast[next] = as_float(contrast[next]);
        Eigen::Matrix3d moves;
        for (int a = 0; a < 3; ++a) {
          for (int b = 0; b < 3; ++b) moves(a, b) = product(a, b);
        }
        Eigen::Vector3d rest;
        for (int a = 0; a < 3; ++a)
          rest[a] = static_cast<double>(plane.with[static_cast<std::size_t>(a)]) - cross.col(a).dot(s);
        normal += edge * edge / variance * (moves - cross.transpose() * eliminated);
        gradient += edge / variance * rest;
      }
    }
    if (next < 3) return out;
    const Eigen::Matrix2d places = normal.topLeftCorner<2, 2>();
    if (!(places.determinant() > 0)) return out;
    Eigen::Vector2d step = places.ldlt().solve(gradient.head<2>());
    const double length_mm = step.norm();
    if (length_mm > kMaxStepMm) step *= kMaxStepMm / length_mm;
    ball.x += as_float(step.x());
    ball.y += as_float(step.y());
    out.moved_mm = std::hypot(ball.x, ball.y);
    const auto tell = [&] {
      out.x_mm = x_mm + ball.x;
      out.y_mm = y_mm + ball.y;
      out.r2 = total > 0 ? std::max(0.0, explained / total) : 0;
      const Eigen::Vector3d with_radius = normal.ldlt().solve(gradient);
      out.radius_mm = frame.radius_mm + with_radius.z();
      const Eigen::Matrix2d place_cov = places.inverse();
      out.place_cov = {place_cov(0, 0), place_cov(0, 1), place_cov(1, 1)};
      out.radius_sigma_mm = std::sqrt(std::max(0.0, normal.inverse()(2, 2)));
      out.color = look.planes.yuv ? rgb_of_yuv_color(color) : color;
      const auto difference = look.planes.yuv ? rgb_of_yuv_contrast(contrast) : contrast;
      out.contrast =
          Eigen::Vector3d(difference.data()).norm() / std::max(1.0, Eigen::Vector3d(out.color.data()).norm());
    };
    const auto is_hopeless = [&] {
      if (!may_be_ball) return false;
      tell();
      return !may_be_ball(out);
    };
    const bool too_far = !(out.moved_mm < kWanderMm);
    if (pass == 1 && !trimmed && is_hopeless()) return out;
    if (length_mm > kSmallStepMm && pass < kPasses && !too_far) continue;
    if (!trimmed && !too_far && look.groups < 3) {
      trimmed = true;
      if (is_hopeless()) return out;
      if (leave_out_unlike(look) > 0) {
        pass = kPasses - 2;  // two more passes
        continue;
      }
    }

    tell();
    out.ok = true;
    return out;
  }
  return out;
}

}  // namespace sslv
