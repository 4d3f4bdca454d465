// SPDX-License-Identifier: Apache-2.0
#include "vision/ball_fit.h"

#include "geometry/plane_patch.h"
#include "vision/sample_planes.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include <Eigen/Dense>

namespace sslv {
namespace {

constexpr double kMarginMm = 9;  // ring of carpet around the ball
constexpr double kWanderMm = 5;  // samples are read for a centre this far from the start
constexpr int kPasses = 4;
/// With less of the ball in view, whatever there is fits.
constexpr double kLeastVisible = 0.3;
/// Fewer values than this, of all planes together, fit anything.
constexpr int kLeastValues = 12;
constexpr double kLeastVariance = 0.5;
constexpr double kMostStepMm = 8, kSmallStepMm = 0.6;
/// A start this far off is followed by another.
constexpr double kFarMm = 4;
/// Carpet differs from its median by no more than this many times its usual difference.
constexpr float kOddCarpet = 4.5F;
constexpr float kLeastSpread = 2.5F;
constexpr float kOddReachPx = 1.2F;
/// One side of a ball differs from its middle by about this share of its contrast.
constexpr float kShading = 0.3F;
/// Shading by direction is a small part of the light: priors in units of one grey level squared.
constexpr double kShadePrior = 0.5;

/// Whether a robot's body, an upright prism from the floor to its top, stands before the floor there.
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
    // The ray's way from that plane up to the robot's top, in the robot's frame.
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

/// Of 8-bit values.
class Median {
 public:
  void add(float value) {
    ++counts_[static_cast<std::uint8_t>(value)];
    ++total_;
  }
  float get() const {
    std::size_t below = 0, value = 0;
    while (below + counts_[value] <= total_ / 2) below += counts_[value++];
    return static_cast<float>(value);
  }

 private:
  std::array<std::uint16_t, 256> counts_{};
  std::size_t total_ = 0;
};

float as_float(double value) {
  return static_cast<float>(value);
}

}  // namespace

struct BallFitter::Group {
  PlaneSamples samples;
  /// Places of samples that no robot hides.
  struct Places {
    std::array<std::uint16_t, 1024> at;
    std::size_t count = 0;
    void add(std::size_t place) {
      if (count < at.size()) at[count++] = static_cast<std::uint16_t>(place);
    }
    std::span<const std::uint16_t> all() const { return std::span(at).first(count); }
  };
  Places core, rim, ring;  // on the ball, just outside its silhouette, around it
};

/// One start of a fit.
struct BallFitter::Look {
  PlanePatch patch;
  SamplePlanes planes;
  BallTemplate ball;
  std::size_t groups = 0;
  int around = 0;
};

BallFitter::BallFitter() {
  for (auto& group : groups_) group = std::make_unique<Group>();
}
BallFitter::~BallFitter() = default;

BallFit BallFitter::fit(const Frame& frame, double x_mm, double y_mm) noexcept {
  BallFit out;
  double from_x_mm = x_mm, from_y_mm = y_mm;
  constexpr int kStarts = 3;
  for (int start = 1; start <= kStarts; ++start) {
    out = fit_from(frame, from_x_mm, from_y_mm);
    // What lies around and what is hidden was looked up for the start: with a far better one, again.
    if (!out.ok || out.moved_mm < kFarMm) break;
    from_x_mm = out.x_mm;
    from_y_mm = out.y_mm;
  }
  out.moved_mm = std::hypot(out.x_mm - x_mm, out.y_mm - y_mm);
  out.ok = out.ok && out.moved_mm < frame.radius_mm;
  return out;
}

/// Reads the samples about the ball, leaves out those that robots hide and finds those around it.
bool BallFitter::read(const Frame& frame, Look& look, BallFit& out) noexcept {
  // The squared distance of a ray from the ball's centre, by the place p where it meets the plane:
  // |p|^2 - (n p)^2 with the ray's direction n, which hardly changes over a ball.
  const auto ray = frame.camera.ray(look.patch.pixel);
  if (!ray) return false;
  const Eigen::Vector3d n = ray->normalized();
  const double outer_mm = frame.radius_mm + kMarginMm;
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
  // Its picture is the longer the more slantwise it is seen.
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
      if (hidden) samples.keep[i] = 0;
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
  return on_ball >= kLeastValues && out.visible_share >= kLeastVisible;
}

/// What lies around the ball is carpet by its majority; the rest is left out.
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
      // 1.48 times the median distance is sigma, were they normally distributed.
      const float limit = kOddCarpet * std::max(1.48F * distances.get(), kLeastSpread);
      const auto leave_out = [&](std::size_t i) {
        if (odd.size() < odd.capacity()) odd.push_back({group.samples.u[i], group.samples.v[i]});
      };
      for (const std::uint16_t i : ring) {
        if (std::abs(value[i] - middle) > limit) leave_out(i);
      }
      // At the silhouette there is ball, carpet or something between: what is not, is a line that runs under
      // it.
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
    // In all planes, with their neighbours, which are half of what they are.
    clear = 0;
    for (std::size_t g = 0; g < look.groups; ++g) {
      Group& group = *groups_[g];
      PlaneSamples& samples = group.samples;
      const float reach_px = kOddReachPx + static_cast<float>(look.planes.groups[g].front().step_x);
      for (std::size_t i = 0; i < static_cast<std::size_t>(samples.count); ++i) {
        const bool is_odd = std::any_of(odd.begin(), odd.end(), [&](const Odd& other) {
          const float du = samples.u[i] - other.u, dv = samples.v[i] - other.v;
          return du * du + dv * dv < reach_px * reach_px;
        });
        if (is_odd) samples.keep[i] = 0;
      }
      for (const std::uint16_t i : group.ring.all()) clear += samples.keep[i] != 0 ? 1 : 0;
    }
  }
  out.clear_share = look.around > 0 ? static_cast<double>(clear) / look.around : 0;
}

BallFit BallFitter::fit_from(const Frame& frame, double x_mm, double y_mm) noexcept {
  BallFit out;
  const double reach_mm = frame.radius_mm + kMarginMm + kWanderMm;
  const auto patch = plane_patch(frame.camera, {x_mm, y_mm}, frame.radius_mm, reach_mm);
  if (!patch) return out;
  Look look{*patch, sample_planes(frame.image.format), {}, 0, 0};
  if (!read(frame, look, out)) return out;
  leave_out_odd(look, out);
  BallTemplate& ball = look.ball;

  using Columns = Eigen::Matrix<double, 5, 1>;
  std::array<double, 3> contrast{}, color{};
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
        const double free = std::max(1.0, count - 7);  // samples beyond those that any model could fit
        const double variance = std::max(left / free, kLeastVariance);
        const double mean = with[kGround - kCover] / count;
        const double all = std::max(0.0, static_cast<double>(plane.square) - count * mean * mean);
        total += all / (count - 1) / variance;
        explained += (all / (count - 1) - left / free) / variance;
        // Light at the silhouette; its middle is brighter by the shading upwards.
        const double edge = s[0];
        contrast[next] = edge + 0.7 * s[kShadeUp - kCover];
        color[next] = contrast[next] + s[kGround - kCover];
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
    if (length_mm > kMostStepMm) step *= kMostStepMm / length_mm;
    ball.x += as_float(step.x());
    ball.y += as_float(step.y());
    out.moved_mm = std::hypot(ball.x, ball.y);
    const bool too_far = !(out.moved_mm < kWanderMm);
    if (length_mm > kSmallStepMm && pass < kPasses && !too_far) continue;

    out.ok = true;
    out.x_mm = x_mm + ball.x;
    out.y_mm = y_mm + ball.y;
    out.r2 = total > 0 ? std::max(0.0, explained / total) : 0;
    const Eigen::Vector3d with_radius = normal.ldlt().solve(gradient);
    out.radius_mm = frame.radius_mm + with_radius.z();
    out.radius_sigma_mm = std::sqrt(std::max(0.0, normal.inverse()(2, 2)));
    out.color = look.planes.yuv ? rgb_of_yuv_color(color) : color;
    const auto difference = look.planes.yuv ? rgb_of_yuv_contrast(contrast) : contrast;
    out.contrast =
        Eigen::Vector3d(difference.data()).norm() / std::max(1.0, Eigen::Vector3d(out.color.data()).norm());
    return out;
  }
  return out;
}

}  // namespace sslv
