// SPDX-License-Identifier: Apache-2.0
#include "solids.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>

#include <Eigen/Geometry>

namespace sslv::halls {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// The league's pattern: dots of 40 mm at 65 mm around a centre of 50 mm; x forward, y left.
struct DotPlace {
  double x, y, radius;
};
constexpr std::array<DotPlace, 5> kDots{DotPlace{0, 0, 25}, DotPlace{35, 54.772, 20},
                                        DotPlace{-54.772, 35, 20}, DotPlace{-54.772, -35, 20},
                                        DotPlace{35, -54.772, 20}};

/// Diffuse light, mostly from above.
Color shaded(const Color& color, double normal_z) {
  return color * static_cast<float>(0.4 + 0.6 * std::max(0.0, normal_z));
}

/// An interval of the ray parameter t.
struct Span {
  double from = -kInfinity, to = kInfinity;
  bool empty() const { return !(from < to); }
};

/// The interval of t in which a + t b is within -half..half.
Span slab(double a, double b, double half) {
  if (std::abs(b) < 1e-12) return std::abs(a) < half ? Span{} : Span{1, 0};
  const double s = (-half - a) / b, t = (half - a) / b;
  return {std::min(s, t), std::max(s, t)};
}

/// The interval between the roots of a t^2 + 2 b t + c = 0, a > 0; empty if there are none.
Span roots(double a, double b, double c) {
  const double discriminant = b * b - a * c;
  if (a <= 0 || discriminant <= 0) return {1, 0};
  const double root = std::sqrt(discriminant);
  return {(-b - root) / a, (-b + root) / a};
}

// Letters of 5 x 7 pixels, one byte per row, the leftmost pixel in the highest of five bits.
struct Glyph {
  char letter;
  std::array<std::uint8_t, 7> rows;
};
constexpr std::array kGlyphs{
    Glyph{'A', {14, 17, 17, 31, 17, 17, 17}}, Glyph{'B', {30, 17, 17, 30, 17, 17, 30}},
    Glyph{'C', {14, 17, 16, 16, 16, 17, 14}}, Glyph{'E', {31, 16, 16, 30, 16, 16, 31}},
    Glyph{'H', {17, 17, 17, 31, 17, 17, 17}}, Glyph{'I', {14, 4, 4, 4, 4, 4, 14}},
    Glyph{'L', {16, 16, 16, 16, 16, 16, 31}}, Glyph{'N', {17, 25, 21, 19, 17, 17, 17}},
    Glyph{'O', {14, 17, 17, 17, 17, 17, 14}}, Glyph{'P', {30, 17, 17, 30, 16, 16, 16}},
    Glyph{'R', {30, 17, 17, 30, 20, 18, 17}}, Glyph{'S', {15, 16, 16, 14, 1, 1, 30}},
    Glyph{'T', {31, 4, 4, 4, 4, 4, 4}},       Glyph{'U', {17, 17, 17, 17, 17, 17, 14}},
};

}  // namespace

Robot::Robot(const Eigen::Vector2d& at_mm, double orientation_rad, const Look& look, const Motion& motion)
    : at_mm_(at_mm),
      cos_(std::cos(orientation_rad)),
      sin_(std::sin(orientation_rad)),
      look_(look),
      motion_(motion) {}

Sphere Robot::bounds() const {
  return {{at_mm_.x(), at_mm_.y(), look_.height_mm / 2}, std::hypot(look_.height_mm / 2, look_.radius_mm)};
}

double Robot::distance_to_outline_mm(const Eigen::Vector2d& point_mm) const {
  const Eigen::Vector2d p = local(point_mm.x() - at_mm_.x(), point_mm.y() - at_mm_.y());
  return std::max(p.norm() - look_.radius_mm, p.x() - look_.front_mm);
}

std::vector<Eigen::Vector3d> Robot::top_points() const {
  constexpr int kSide = 25;
  std::vector<Eigen::Vector3d> out;
  for (int i = -kSide; i <= kSide; ++i) {
    for (int j = -kSide; j <= kSide; ++j) {
      const Eigen::Vector2d p = at_mm_ + Eigen::Vector2d(i, j) * (look_.radius_mm / kSide);
      if (distance_to_outline_mm(p) <= 0) out.push_back({p.x(), p.y(), look_.height_mm});
    }
  }
  return out;
}

Color Robot::top_color(const Eigen::Vector2d& p) const {
  for (std::size_t i = 0; i < kDots.size(); ++i) {
    const double x = p.x() - kDots[i].x, y = p.y() - kDots[i].y;
    if (x * x + y * y >= kDots[i].radius * kDots[i].radius) continue;
    if (look_.wear <= 0) return look_.dots[i];
    // Scratches in one direction, and faded spots.
    const float scratch = smooth_noise(p.x() / 3, p.y() / 25, look_.wear_seed) +
                          smooth_noise(p.x() / 9, p.y() / 9, look_.wear_seed + 1);
    const auto limit = static_cast<float>(0.9 - 1.1 * look_.wear);
    return scratch > limit ? Color(look_.dots[i] * 0.35F + look_.top * 0.65F) : look_.dots[i];
  }
  return look_.top;
}

std::optional<Hit> Robot::hit(const Ray& ray) const {
  Eigen::Vector2d o = local(ray.origin.x() - at_mm_.x() - motion_.velocity_mm_s.x() * ray.time_s,
                            ray.origin.y() - at_mm_.y() - motion_.velocity_mm_s.y() * ray.time_s);
  Eigen::Vector2d d = local(ray.direction.x(), ray.direction.y());
  if (motion_.spin_rad_s != 0 && ray.time_s != 0) {
    const Eigen::Rotation2Dd turn(-motion_.spin_rad_s * ray.time_s);
    o = turn * o;
    d = turn * d;
  }
  const double at_top = (look_.height_mm - ray.origin.z()) / ray.direction.z();
  const double at_floor = -ray.origin.z() / ray.direction.z();
  const Eigen::Vector2d p = o + at_top * d;
  const double radius2 = look_.radius_mm * look_.radius_mm;
  if (p.x() <= look_.front_mm && p.squaredNorm() <= radius2) return Hit{at_top, top_color(p)};
  // Outside the top: does the ray enter the outline before it reaches the floor?
  Span inside = roots(d.squaredNorm(), o.dot(d), o.squaredNorm() - radius2);
  const double at_front = (look_.front_mm - o.x()) / d.x();
  if (d.x() < 0) inside.from = std::max(inside.from, at_front);
  if (d.x() > 0) inside.to = std::min(inside.to, at_front);
  if (inside.empty() || inside.from < at_top || inside.from > at_floor) return std::nullopt;
  const double z = ray.origin.z() + inside.from * ray.direction.z();
  return Hit{inside.from, look_.side * static_cast<float>(0.4 + 0.6 * z / look_.height_mm)};
}

Ball::Ball(const Eigen::Vector2d& at_mm, const Look& look, const LightFrom& light, const Motion& motion)
    : center_(at_mm.x(), at_mm.y(), kRadiusMm), look_(look), light_(light), motion_(motion) {}

std::optional<Hit> Ball::hit(const Ray& ray) const {
  Eigen::Vector3d from = ray.origin - center_;
  from.head<2>() -= motion_.velocity_mm_s * ray.time_s;
  const Span inside =
      roots(ray.direction.squaredNorm(), from.dot(ray.direction), from.squaredNorm() - kRadiusMm * kRadiusMm);
  if (inside.empty()) return std::nullopt;
  const Eigen::Vector3f normal = ((from + inside.from * ray.direction) / kRadiusMm).cast<float>();
  const Eigen::Vector3f to_eye = -ray.direction.normalized().cast<float>();
  // A third of the light is ambient, the rest comes from lamps; on an upward surface they add up to 1.
  float direct = 0, upwards = 0, mirrored = 0;
  for (std::size_t i = 0; i < light_.directions.size(); ++i) {
    const Eigen::Vector3f& lamp = light_.directions[i];
    direct += light_.shares[i] * std::max(0.0F, normal.dot(lamp));
    upwards += light_.shares[i] * lamp.z();
    const float half = std::max(0.0F, normal.dot((lamp + to_eye).normalized()));
    mirrored += light_.shares[i] * std::pow(half, look_.gloss_power);
  }
  const float room = 0.35F * (0.65F + 0.35F * normal.z());
  const float dimple = 1 + 0.07F * smooth_noise(9 * normal.x(), 9 * normal.y(), look_.dimples);
  const float light = (room + 0.65F * direct / std::max(upwards, 1e-3F)) * dimple;
  const float below = 0.25F * std::max(0.0F, 0.6F - normal.z());
  return Hit{inside.from,
             look_.color * light + look_.color * look_.bounce * below * 4 + look_.gloss * mirrored};
}

std::optional<Hit> Ellipsoid::hit(const Ray& ray) const {
  const Eigen::Vector3d o = unit(ray.origin - center_), d = unit(ray.direction);
  const Span inside = roots(d.squaredNorm(), o.dot(d), o.squaredNorm() - 1);
  if (inside.empty()) return std::nullopt;
  const Eigen::Vector3d p = o + inside.from * d;
  const Eigen::Vector3d normal = (p.array() / half_axes_.array()).matrix().normalized();
  return Hit{inside.from, shaded(color_, normal.z())};
}

std::optional<Hit> Capsule::hit(const Ray& ray) const {
  // The cylinder between the ends, then the spheres at the ends.
  const Eigen::Vector3d axis = b_ - a_, from = ray.origin - a_;
  const double length2 = axis.squaredNorm();
  const double d_axis = ray.direction.dot(axis), o_axis = from.dot(axis);
  const Span round = roots(ray.direction.squaredNorm() - d_axis * d_axis / length2,
                           from.dot(ray.direction) - o_axis * d_axis / length2,
                           from.squaredNorm() - o_axis * o_axis / length2 - radius_ * radius_);
  double along = kInfinity;
  Eigen::Vector3d center = a_;
  if (!round.empty()) {
    const double share = (o_axis + round.from * d_axis) / length2;
    if (share >= 0 && share <= 1) {
      along = round.from;
      center = a_ + share * axis;
    }
  }
  for (const Eigen::Vector3d& end : {a_, b_}) {
    const Eigen::Vector3d to = ray.origin - end;
    const Span ball =
        roots(ray.direction.squaredNorm(), to.dot(ray.direction), to.squaredNorm() - radius_ * radius_);
    if (!ball.empty() && ball.from < along) {
      along = ball.from;
      center = end;
    }
  }
  if (along == kInfinity) return std::nullopt;
  const Eigen::Vector3d point = ray.origin + along * ray.direction;
  return Hit{along, shaded(color_, (point - center).z() / radius_)};
}

std::optional<Hit> Cone::hit(const Ray& ray) const {
  const double to_top = (height_ - ray.origin.z()) / ray.direction.z();
  const Eigen::Vector2d o = ray.origin.head<2>() - at_, d = ray.direction.head<2>();
  if ((o + to_top * d).norm() <= top_) return Hit{to_top, shaded(color_, 0.2)};  // the open inside
  // o + t d| = base - slope z, squared.
  const double slope = (base_ - top_) / height_;
  const double r0 = base_ - slope * ray.origin.z(), r1 = -slope * ray.direction.z();
  const double a = d.squaredNorm() - r1 * r1, b = o.dot(d) - r0 * r1, c = o.squaredNorm() - r0 * r0;
  const double discriminant = b * b - a * c;
  if (std::abs(a) < 1e-15 || discriminant <= 0) return std::nullopt;
  const double root = std::sqrt(discriminant);
  double along = kInfinity;
  for (const double t : {(-b - root) / a, (-b + root) / a}) {
    const double z = ray.origin.z() + t * ray.direction.z();
    if (z >= 0 && z <= height_) along = std::min(along, t);
  }
  if (along == kInfinity) return std::nullopt;
  const double share = (ray.origin.z() + along * ray.direction.z()) / height_;
  return Hit{along, shaded(share > 0.45 && share < 0.7 ? band_ : color_, slope / std::hypot(1, slope))};
}

bool Box::has_ink(double u_mm, double v_mm) const {
  if (look_.word.empty()) return false;
  const double height = 2 * half_.z(), cell = 0.62 * height / 7;
  const double period = cell * 6 * (static_cast<double>(look_.word.size()) + 2);
  const double u = std::fmod(u_mm + 1e4 * period, period);
  const double row = (height - 0.19 * height - v_mm) / cell;
  const double center_u = period - 6 * cell;
  if (look_.disc && std::hypot(u - center_u, v_mm - height / 2) < 0.3 * height) return true;
  if (row < 0 || row >= 7) return false;
  const auto letter = static_cast<std::size_t>(u / (6 * cell));
  const int column = static_cast<int>(u / cell) % 6;
  if (letter >= look_.word.size() || column > 4) return false;
  const auto glyph = std::find_if(kGlyphs.begin(), kGlyphs.end(),
                                  [&](const Glyph& g) { return g.letter == look_.word[letter]; });
  return glyph != kGlyphs.end() && ((glyph->rows[static_cast<std::size_t>(row)] >> (4 - column)) & 1) != 0;
}

std::optional<Hit> Box::hit(const Ray& ray) const {
  const auto turned = [&](const Eigen::Vector3d& v) {
    return Eigen::Vector3d(cos_ * v.x() + sin_ * v.y(), -sin_ * v.x() + cos_ * v.y(), v.z());
  };
  const Eigen::Vector3d o = turned(ray.origin - center_), d = turned(ray.direction);
  Span inside;
  int face = 2;
  for (int axis = 0; axis < 3; ++axis) {
    const Span part = slab(o[axis], d[axis], half_[axis]);
    if (part.from > inside.from) {
      inside.from = part.from;
      face = axis;
    }
    inside.to = std::min(inside.to, part.to);
  }
  if (inside.empty()) return std::nullopt;
  const Eigen::Vector3d p = o + inside.from * d;
  if (face == 2) return Hit{inside.from, look_.color};
  // Mirrored so that the letters are readable from the visible side.
  const bool ink = face == 1 && has_ink(p.y() < 0 ? p.x() + half_.x() : half_.x() - p.x(), p.z() + half_.z());
  return Hit{inside.from, shaded(ink ? look_.ink : look_.color, 0.4)};
}

}  // namespace sslv::halls
