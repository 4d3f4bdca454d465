// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "chance.h"
#include "light_color.h"

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace sslv::halls {

/// A ray at a time relative to the frame's time: moving objects are displaced accordingly.
struct Ray {
  Eigen::Vector3d origin, direction;
  double time_s = 0;
};

struct Motion {
  Eigen::Vector2d velocity_mm_s = Eigen::Vector2d::Zero();
  double spin_rad_s = 0;
};

/// `along`: in units of the ray's direction.
struct Hit {
  double along;
  Color color;  // including shading
};

struct Sphere {
  Eigen::Vector3d center;
  double radius;
};

/// Something standing or lying on the floor, in field mm; rays come from above.
class Solid {
 public:
  virtual ~Solid() = default;
  virtual std::optional<Hit> hit(const Ray& ray) const = 0;
  virtual Sphere bounds() const = 0;
};

/// A robot: an upright prism, round with a flat front, with the league's pattern on its top.
class Robot final : public Solid {
 public:
  struct Look {
    double height_mm = 140, radius_mm = 89, front_mm = 56;
    Color top, side;
    std::array<Color, 5> dots;  // centre, front left, rear left, rear right, front right
    double wear = 0;            // fraction of a dot's print that is worn off
    std::uint32_t wear_seed = 0;
  };
  Robot(const Eigen::Vector2d& at_mm, double orientation_rad, const Look& look, const Motion& motion = {});

  std::optional<Hit> hit(const Ray& ray) const override;
  Sphere bounds() const override;

  const Eigen::Vector2d& at_mm() const { return at_mm_; }
  const Look& look() const { return look_; }
  const Motion& motion() const { return motion_; }
  /// Negative inside the outline as seen from above.
  double distance_to_outline_mm(const Eigen::Vector2d& point_mm) const;
  /// Points evenly spread over the top, in field mm.
  std::vector<Eigen::Vector3d> top_points() const;

 private:
  Eigen::Vector2d local(double x, double y) const { return {cos_ * x + sin_ * y, -sin_ * x + cos_ * y}; }
  Color top_color(const Eigen::Vector2d& p) const;

  Eigen::Vector2d at_mm_;
  double cos_, sin_;
  Look look_;
  Motion motion_;
};

/// Directions of the light at one place: unit vectors and their shares.
struct LightFrom {
  std::array<Eigen::Vector3f, 3> directions;
  std::array<float, 3> shares{};
};

class Ball final : public Solid {
 public:
  static constexpr double kRadiusMm = 21.5;
  struct Look {
    Color color = Color::Ones();
    Color bounce = Color::Zero();  // of the carpet; lights the ball from below
    float gloss = 0;               // strength of a lamp's reflection
    float gloss_power = 80;
    std::uint32_t dimples = 0;
  };
  Ball(const Eigen::Vector2d& at_mm, const Look& look, const LightFrom& light, const Motion& motion = {});
  std::optional<Hit> hit(const Ray& ray) const override;
  Sphere bounds() const override { return {center_, kRadiusMm}; }

 private:
  Eigen::Vector3d center_;
  Look look_;
  LightFrom light_;
  Motion motion_;
};

/// An ellipsoid rotated about the vertical axis: shoes, palms, heads, bodies.
class Ellipsoid final : public Solid {
 public:
  Ellipsoid(const Eigen::Vector3d& center, const Eigen::Vector3d& half_axes, double yaw_rad,
            const Color& color)
      : center_(center),
        half_axes_(half_axes),
        cos_(std::cos(yaw_rad)),
        sin_(std::sin(yaw_rad)),
        color_(color) {}
  std::optional<Hit> hit(const Ray& ray) const override;
  Sphere bounds() const override { return {center_, half_axes_.maxCoeff()}; }

 private:
  Eigen::Vector3d unit(const Eigen::Vector3d& v) const {
    return {(cos_ * v.x() + sin_ * v.y()) / half_axes_.x(), (-sin_ * v.x() + cos_ * v.y()) / half_axes_.y(),
            v.z() / half_axes_.z()};
  }
  Eigen::Vector3d center_, half_axes_;
  double cos_, sin_;
  Color color_;
};

/// All points within `radius` of a line segment: arms, fingers, legs.
class Capsule final : public Solid {
 public:
  Capsule(const Eigen::Vector3d& a, const Eigen::Vector3d& b, double radius, const Color& color)
      : a_(a), b_(b), radius_(radius), color_(color) {}
  std::optional<Hit> hit(const Ray& ray) const override;
  Sphere bounds() const override { return {(a_ + b_) / 2, (a_ - b_).norm() / 2 + radius_}; }

 private:
  Eigen::Vector3d a_, b_;
  double radius_;
  Color color_;
};

/// An upright truncated cone; a band around it may have another colour.
class Cone final : public Solid {
 public:
  Cone(const Eigen::Vector2d& at, double base_radius, double top_radius, double height, const Color& color,
       const Color& band)
      : at_(at), base_(base_radius), top_(top_radius), height_(height), color_(color), band_(band) {}
  std::optional<Hit> hit(const Ray& ray) const override;
  Sphere bounds() const override { return {{at_.x(), at_.y(), height_ / 2}, std::hypot(height_ / 2, base_)}; }

 private:
  Eigen::Vector2d at_;
  double base_, top_, height_;
  Color color_, band_;
};

/// A box on the floor, rotated about the vertical axis, with a word on its two long faces: boards, goal
/// walls.
class Box final : public Solid {
 public:
  struct Look {
    Color color, ink;
    std::string word;   // letters A B C E H I L N O P R S T U; repeated along the board
    bool disc = false;  // a disc of ink after each word
  };
  Box(const Eigen::Vector3d& center, const Eigen::Vector3d& half_size, double yaw_rad, Look look)
      : center_(center),
        half_(half_size),
        cos_(std::cos(yaw_rad)),
        sin_(std::sin(yaw_rad)),
        look_(std::move(look)) {}
  std::optional<Hit> hit(const Ray& ray) const override;
  Sphere bounds() const override { return {center_, half_.norm()}; }

 private:
  bool has_ink(double u_mm, double v_mm) const;
  Eigen::Vector3d center_, half_;
  double cos_, sin_;
  Look look_;
};

}  // namespace sslv::halls
