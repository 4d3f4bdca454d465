// SPDX-License-Identifier: Apache-2.0
#include "lab/accuracy_bound.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

#include <Eigen/Dense>

namespace sslv {
namespace {

constexpr double kRoundingVariance = 1.0 / 12;
/// Samples this far inside the top's rim are certainly black, or on a dot.
constexpr double kTopRimMm = 12;
constexpr double kReachSigmas = 4.5;  // in sigmas of the blur: a more distant edge has no effect

/// The share of a pixel on one side of a blurred edge (integral()), and its derivative (density()).
class BlurredPixel {
 public:
  explicit BlurredPixel(double blur_px) : sigma_(std::max(blur_px, 0.05)) {}
  double reach_px() const { return kReachSigmas * sigma_ + 0.5; }
  double density(double away_px) const {
    return phi((away_px + 0.5) / sigma_) - phi((away_px - 0.5) / sigma_);
  }
  double integral(double away_px) const {
    return sigma_ * (phi_integral((away_px + 0.5) / sigma_) - phi_integral((away_px - 0.5) / sigma_));
  }

 private:
  static double phi(double z) { return 0.5 * std::erfc(-z / std::numbers::sqrt2); }
  static double phi_integral(double z) {
    return z * phi(z) + std::exp(-0.5 * z * z) / std::sqrt(2 * std::numbers::pi);
  }
  double sigma_;
};

/// The effect of a dot on the pixels around it.
struct DotPixels {
  int left, top, width, height;
  struct Pixel {
    double cover = 0;                                  // share of the pixel that the dot covers
    Eigen::Vector3d change = Eigen::Vector3d::Zero();  // derivative of cover by x (mm), y (mm), heading (rad)
    bool on_top = false;  // on the robot's top, not near its rim, and on no other dot
  };
  std::vector<Pixel> pixels;

  Pixel& at(int x, int y) { return pixels[static_cast<std::size_t>((y - top) * width + x - left)]; }
  const Pixel& at(int x, int y) const {
    return pixels[static_cast<std::size_t>((y - top) * width + x - left)];
  }
};

/// Draws a dot, given in its robot's frame.
DotPixels draw(const BoundPicture& picture, std::span<const BoundPose> moments, const PatternDot& dot,
               bool& in_view) {
  const BlurredPixel blur(picture.blur_px);
  const double reach_px = blur.reach_px();
  struct RimPoint {
    Eigen::Vector2d pixel;
    double along_v;          // step in y to the next point, px
    Eigen::Vector3d change;  // area (px^2) swept here, by x (mm), y (mm) and heading (rad)
  };
  constexpr std::size_t kPoints = 96;
  std::vector<std::array<RimPoint, kPoints>> rims;
  Eigen::Vector2d least = Eigen::Vector2d::Constant(1e9), most = -least;
  in_view = true;
  for (const BoundPose& pose : moments) {
    const double c = std::cos(pose.orientation_rad), s = std::sin(pose.orientation_rad);
    const Eigen::Vector2d arm(c * dot.x_mm - s * dot.y_mm, s * dot.x_mm + c * dot.y_mm);
    auto& rim = rims.emplace_back();
    for (std::size_t i = 0; i < kPoints; ++i) {
      const double angle = 2 * std::numbers::pi * static_cast<double>(i) / kPoints;
      const Eigen::Vector2d out(std::cos(angle), std::sin(angle));
      const Eigen::Vector2d field = Eigen::Vector2d(pose.x_mm, pose.y_mm) + arm + dot.diameter_mm / 2 * out;
      const auto pixel = picture.camera.project({field.x(), field.y(), pose.height_mm});
      if (!pixel) {
        in_view = false;
        return {};
      }
      const double length_mm = std::numbers::pi * dot.diameter_mm / kPoints;
      const double px2 = length_mm / picture.camera.mm2_per_px(*pixel, pose.height_mm);
      rim[i] = {*pixel, 0, px2 * Eigen::Vector3d(out.x(), out.y(), arm.x() * out.y() - arm.y() * out.x())};
      least = least.cwiseMin(*pixel);
      most = most.cwiseMax(*pixel);
    }
    double area = 0;
    for (std::size_t i = 0; i < kPoints; ++i) {
      rim[i].along_v = (rim[(i + 1) % kPoints].pixel.y() - rim[(i + kPoints - 1) % kPoints].pixel.y()) / 2;
      area += rim[i].pixel.x() * rim[i].along_v;
    }
    if (area < 0) {  // y points down in images
      for (RimPoint& point : rim) point.along_v = -point.along_v;
    }
  }
  DotPixels out;
  out.left = static_cast<int>(std::floor(least.x() - reach_px)) & ~1;  // whole pairs of pixels
  out.top = static_cast<int>(std::floor(least.y() - reach_px));
  out.width = ((static_cast<int>(std::ceil(most.x() + reach_px)) - out.left) | 1) + 1;
  out.height = static_cast<int>(std::ceil(most.y() + reach_px)) - out.top + 1;
  if (out.left < 0 || out.top < 0 || out.left + out.width > picture.image.width ||
      out.top + out.height > picture.image.height) {
    in_view = false;
    return {};
  }
  out.pixels.resize(static_cast<std::size_t>(out.width) * static_cast<std::size_t>(out.height));
  const double share = 1 / static_cast<double>(moments.size());
  for (const auto& rim : rims) {
    for (const RimPoint& point : rim) {
      const int x0 = std::max(out.left, static_cast<int>(std::ceil(point.pixel.x() - reach_px)));
      const int y0 = static_cast<int>(std::ceil(point.pixel.y() - reach_px));
      const int y1 = static_cast<int>(std::floor(point.pixel.y() + reach_px));
      for (int y = y0; y <= y1; ++y) {
        const double across = share * blur.density(y - point.pixel.y());
        // Green's theorem: a point of the rim adds or removes coverage left of it.
        for (int x = out.left; x < x0 + static_cast<int>(2 * reach_px) + 1 && x < out.left + out.width; ++x) {
          const double away = point.pixel.x() - x;
          DotPixels::Pixel& pixel = out.at(x, y);
          pixel.cover += across * point.along_v * blur.integral(away);
          pixel.change += across * blur.density(away) * point.change;
        }
      }
    }
  }
  const BoundPose& pose = moments[moments.size() / 2];
  const double c = std::cos(pose.orientation_rad), s = std::sin(pose.orientation_rad);
  const Eigen::Vector2d arm(c * dot.x_mm - s * dot.y_mm, s * dot.x_mm + c * dot.y_mm);
  const double near_mm = dot.diameter_mm / 2 + picture.patterns.gap_mm / 2;
  for (int y = out.top; y < out.top + out.height; ++y) {
    for (int x = out.left; x < out.left + out.width; ++x) {
      const auto field =
          picture.camera.unproject({static_cast<double>(x), static_cast<double>(y)}, pose.height_mm);
      if (!field) continue;
      const Eigen::Vector2d from = *field - Eigen::Vector2d(pose.x_mm, pose.y_mm);
      out.at(x, y).on_top = (from - arm).norm() < near_mm &&
                            from.norm() < picture.patterns.top_radius_mm - kTopRimMm &&
                            c * from.x() + s * from.y() < picture.patterns.top_front_mm - kTopRimMm / 2;
    }
  }
  return out;
}

/// A value of the image and its pixel; U and V of YUV images belong to the pixels x and x + 1.
struct Sample {
  int plane;
  double value;
  DotPixels::Pixel pixel;
};

/// Values that share noise: all of one pixel, or of two pixels in YUV images.
struct Unit {
  std::array<Sample, 4> samples;
  std::size_t count = 0;
};

template <class Use>
void for_units(const ImageView& image, const DotPixels& dot, const Use& use) {
  const bool yuv = is_yuv422(image.format);
  const int red_x = image.format == PixelFormat::kBayerGr8 || image.format == PixelFormat::kBayerBg8 ? 1 : 0;
  const int red_y = image.format == PixelFormat::kBayerGb8 || image.format == PixelFormat::kBayerBg8 ? 1 : 0;
  for (int y = dot.top; y < dot.top + dot.height; ++y) {
    const std::uint8_t* row = image.row(y);
    for (int x = dot.left; x < dot.left + dot.width; x += yuv ? 2 : 1) {
      Unit unit;
      const DotPixels::Pixel& pixel = dot.at(x, y);
      const auto add = [&](int plane, double value, const DotPixels::Pixel& seen) {
        unit.samples[unit.count++] = {plane, value, seen};
      };
      if (yuv) {
        const DotPixels::Pixel& right = dot.at(x + 1, y);
        const DotPixels::Pixel both{(pixel.cover + right.cover) / 2, (pixel.change + right.change) / 2,
                                    pixel.on_top && right.on_top};
        const int luma = image.format == PixelFormat::kUyvy ? 1 : 0;
        add(0, row[2 * x + luma], pixel);
        add(0, row[2 * x + 2 + luma], right);
        add(1, row[2 * x + 1 - luma], both);
        add(2, row[2 * x + 3 - luma], both);
      } else if (is_bayer(image.format)) {
        const bool red_column = x % 2 == red_x, red_row = y % 2 == red_y;
        add(red_column != red_row ? 1 : red_row ? 0 : 2, row[x], pixel);
      } else {
        for (int c = 0; c < 3; ++c) add(c, row[3 * x + c], pixel);
      }
      use(unit);
    }
  }
}

/// Noise covariance of a unit's values; `variance`: of each red, green and blue value.
Eigen::MatrixXd covariance_of(PixelFormat format, double variance) {
  if (!is_yuv422(format)) {
    const int values = is_bayer(format) ? 1 : 3;
    return (variance + kRoundingVariance) * Eigen::MatrixXd::Identity(values, values);
  }
  // BT.601 full range, as in image/color.h: Y of both pixels, U and V of their mean.
  const Eigen::RowVector3d y(0.299, 0.587, 0.114);
  const Eigen::RowVector3d u = (Eigen::RowVector3d(0, 0, 1) - y) / 1.772;
  const Eigen::RowVector3d v = (Eigen::RowVector3d(1, 0, 0) - y) / 1.402;
  Eigen::Matrix<double, 4, 6> mix = Eigen::Matrix<double, 4, 6>::Zero();
  mix.block<1, 3>(0, 0) = mix.block<1, 3>(1, 3) = y;
  mix.block<1, 3>(2, 0) = mix.block<1, 3>(2, 3) = u / 2;
  mix.block<1, 3>(3, 0) = mix.block<1, 3>(3, 3) = v / 2;
  return variance * mix * mix.transpose() + kRoundingVariance * Eigen::Matrix4d::Identity();
}

/// The dot's contrast in each plane by least squares. Subtracts the estimate's variance from the estimate's
/// square, since the square is biased by the variance.
std::array<double, 3> contrasts_of(const ImageView& image, const DotPixels& dot,
                                   const Eigen::MatrixXd& noise) {
  struct Sums {
    double n = 0, t = 0, tt = 0, v = 0, tv = 0, variance = 0;
  };
  std::array<Sums, 3> sums;
  for_units(image, dot, [&](const Unit& unit) {
    for (std::size_t i = 0; i < unit.count; ++i) {
      const Sample& one = unit.samples[i];
      if (!one.pixel.on_top) continue;
      Sums& s = sums[static_cast<std::size_t>(one.plane)];
      ++s.n;
      s.t += one.pixel.cover;
      s.tt += one.pixel.cover * one.pixel.cover;
      s.v += one.value;
      s.tv += one.pixel.cover * one.value;
      s.variance = noise(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(i));
    }
  });
  std::array<double, 3> out{};
  for (std::size_t p = 0; p < 3; ++p) {
    const Sums& s = sums[p];
    const double spread = s.n > 0 ? s.tt - s.t * s.t / s.n : 0;
    if (!(spread > 1e-3)) continue;
    const double contrast = (s.tv - s.v * s.t / s.n) / spread;
    out[p] = std::copysign(std::sqrt(std::max(0.0, contrast * contrast - s.variance / spread)), contrast);
  }
  return out;
}

}  // namespace

std::optional<RobotBound> robot_bound(const BoundPicture& picture, std::span<const BoundPose> moments) {
  const PatternTable& patterns = picture.patterns;
  const Eigen::MatrixXd noise =
      covariance_of(picture.image.format, picture.noise_sigma * picture.noise_sigma);
  const Eigen::MatrixXd weight = noise.inverse();
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i <= patterns.dots.size(); ++i) {
    const PatternDot dot =
        i == 0 ? PatternDot{patterns.center_x_mm, patterns.center_y_mm, patterns.center_diameter_mm}
               : patterns.dots[i - 1];
    bool in_view = false;
    const DotPixels pixels = draw(picture, moments, dot, in_view);
    if (!in_view) return std::nullopt;
    const auto contrast = contrasts_of(picture.image, pixels, noise);
    for_units(picture.image, pixels, [&](const Unit& unit) {
      Eigen::Matrix<double, 4, 3> change;
      for (std::size_t k = 0; k < unit.count; ++k) {
        const Sample& one = unit.samples[k];
        change.row(static_cast<Eigen::Index>(k)) =
            contrast[static_cast<std::size_t>(one.plane)] * one.pixel.change.transpose();
      }
      const auto count = static_cast<Eigen::Index>(unit.count);
      information += change.topRows(count).transpose() * weight * change.topRows(count);
    });
  }
  if (!(information.determinant() > 0)) return std::nullopt;
  const Eigen::Matrix3d covariance = information.inverse();
  return RobotBound{std::sqrt(covariance(0, 0) + covariance(1, 1)), std::sqrt(covariance(2, 2))};
}

}  // namespace sslv
