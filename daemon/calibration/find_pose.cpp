// SPDX-License-Identifier: Apache-2.0
#include "calibration/find_pose.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <numeric>
#include <optional>
#include <utility>

#include <Eigen/Dense>

namespace sslv {
namespace {

using Assignment = std::vector<std::size_t>;  // for each pixel, index of its place
using Points = std::span<const Eigen::Vector2d>;

/// Twice the signed area of a triangle; the sign gives its orientation.
double turn_of(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c) {
  const Eigen::Vector2d ab = b - a, ac = c - a;
  return ab.x() * ac.y() - ab.y() * ac.x();
}

/// Whether a camera above the field could show the places at the pixels. All triangles then have opposite
/// orientations in the image and on the field, because the image's y axis points down.
bool is_from_above(Points pixels, Points places, const Assignment& place_of) {
  constexpr double kMinPx2 = 400, kMinMm2 = 1e5;  // inaccurate clicks may flip smaller triangles
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    for (std::size_t j = i + 1; j < pixels.size(); ++j) {
      for (std::size_t k = j + 1; k < pixels.size(); ++k) {
        const double seen = turn_of(pixels[i], pixels[j], pixels[k]);
        const double real = turn_of(places[place_of[i]], places[place_of[j]], places[place_of[k]]);
        if (std::abs(seen) > kMinPx2 && std::abs(real) > kMinMm2 && seen * real > 0) return false;
      }
    }
  }
  return true;
}

using Triangle = std::array<std::size_t, 3>;

/// The three pixels with the largest area.
Triangle widest_triangle(Points pixels) {
  Triangle best{0, 1, 2};
  double largest = -1;
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    for (std::size_t j = i + 1; j < pixels.size(); ++j) {
      for (std::size_t k = j + 1; k < pixels.size(); ++k) {
        const double area = std::abs(turn_of(pixels[i], pixels[j], pixels[k]));
        if (area <= largest) continue;
        largest = area;
        best = {i, j, k};
      }
    }
  }
  return best;
}

/// The cameras of one lens that show three places of the floor at three pixels.
class CamerasOfTriangle {
 public:
  /// `lens`: its pose is ignored.
  CamerasOfTriangle(const LensCamera& lens, const std::array<Eigen::Vector2d, 3>& pixels) : camera_(lens) {
    for (std::size_t i = 0; i < 3; ++i) {
      const Eigen::Vector2d seen =
          (pixels[i] - Eigen::Vector2d(lens.center_x, lens.center_y)) / lens.focal_px;
      const double r2 = seen.squaredNorm();
      const Eigen::Vector2d straight = seen * (1 + r2 * (lens.k1 + r2 * lens.k2));
      rays_[i] = Eigen::Vector3d(straight.x(), straight.y(), 1).normalized();
    }
  }

  /// Calls `use` with each: at most four. The distances to the places solve a quartic equation (Grunert 1841,
  /// as in Haralick et al. 1994, "Review and analysis of solutions of the three point perspective pose
  /// estimation problem").
  template <typename Use>
  void for_each(const std::array<Eigen::Vector2d, 3>& places, Use use) {
    const double cos_a = rays_[1].dot(rays_[2]), cos_b = rays_[0].dot(rays_[2]),
                 cos_c = rays_[0].dot(rays_[1]);
    const double b2 = (places[0] - places[2]).squaredNorm();
    const double a = (places[1] - places[2]).squaredNorm() / b2,
                 c = (places[0] - places[1]).squaredNorm() / b2;
    const double d = a - c;
    const std::array<double, 5> by_power{
        (1 + d) * (1 + d) - 4 * a * cos_c * cos_c,
        4 * (-d * (1 + d) * cos_b + 2 * a * cos_c * cos_c * cos_b - (1 - a - c) * cos_a * cos_c),
        2 * (d * d - 1 + 2 * d * d * cos_b * cos_b + 2 * (1 - c) * cos_a * cos_a -
             4 * (a + c) * cos_a * cos_b * cos_c + 2 * (1 - a) * cos_c * cos_c),
        4 * (d * (1 - d) * cos_b - (1 - a - c) * cos_a * cos_c + 2 * c * cos_a * cos_a * cos_b),
        (d - 1) * (d - 1) - 4 * c * cos_a * cos_a};
    if (!(std::abs(by_power[4]) > 1e-12)) return;  // also of equal places
    Eigen::Matrix4d companion = Eigen::Matrix4d::Zero();
    for (int i = 0; i < 4; ++i) companion(i, 3) = -by_power[static_cast<std::size_t>(i)] / by_power[4];
    for (int i = 0; i < 3; ++i) companion(i + 1, i) = 1;
    const Eigen::Vector4cd roots = companion.eigenvalues();
    for (int i = 0; i < 4; ++i) {
      const double v = roots[i].real();  // distance to the third place over that to the first
      // Where two solutions meet, inexact pixels make them complex.
      if (v <= 0 || std::abs(roots[i].imag()) > kMaxImaginary * v) continue;
      const double divisor = 2 * (cos_c - v * cos_a);
      if (std::abs(divisor) < 1e-9) continue;
      const double u = ((d - 1) * v * v - 2 * d * cos_b * v + 1 + d) / divisor;  // the second over the first
      if (u <= 0) continue;
      const double first_mm = std::sqrt(b2 / (1 + v * v - 2 * v * cos_b));
      if (place({first_mm * rays_[0], first_mm * u * rays_[1], first_mm * v * rays_[2]}, places))
        use(camera_);
    }
  }

 private:
  /// `seen_mm`: the places in the camera's coordinates. Returns whether the camera is above the field.
  bool place(const std::array<Eigen::Vector3d, 3>& seen_mm, const std::array<Eigen::Vector2d, 3>& places) {
    const auto frame = [](const Eigen::Vector3d& along, const Eigen::Vector3d& other) {
      Eigen::Matrix3d out;
      out.col(0) = along.normalized();
      out.col(2) = along.cross(other).normalized();
      out.col(1) = out.col(2).cross(out.col(0));
      return out;
    };
    const auto on_floor = [&](std::size_t i) { return Eigen::Vector3d(places[i].x(), places[i].y(), 0); };
    camera_.rotation = frame(seen_mm[1] - seen_mm[0], seen_mm[2] - seen_mm[0]) *
                       frame(on_floor(1) - on_floor(0), on_floor(2) - on_floor(0)).transpose();
    camera_.position_mm = on_floor(0) - camera_.rotation.transpose() * seen_mm[0];
    return camera_.position_mm.z() > 0 && is_plausible(camera_);
  }

  static constexpr double kMaxImaginary = 0.3;

  LensCamera camera_;
  std::array<Eigen::Vector3d, 3> rays_;
};

/// Lenses to try: of the prior, and if it is vague, of shorter and longer focal length.
std::vector<LensCamera> lenses_of(const CameraPrior& prior, int width_px, int height_px) {
  LensCamera lens;
  lens.width = width_px;
  lens.height = height_px;
  lens.center_x = prior.center_x;
  lens.center_y = prior.center_y;
  lens.k1 = prior.k1;
  lens.k2 = prior.k2;
  std::vector<LensCamera> out;
  for (const double sigmas : {0.0, -0.8, 0.8}) {
    const double ratio = std::exp(sigmas * prior.focal_share);
    lens.focal_px = ratio * prior.focal_px;
    lens.k1 = ratio * ratio * prior.k1;  // the same distortion in pixels
    lens.k2 = std::pow(ratio, 4) * prior.k2;
    out.push_back(lens);
  }
  return out;
}

/// Assigns pixels to places: tries all cameras of three pixels, and assigns each other pixel to the nearest
/// place.
class AssignmentSearch {
 public:
  static constexpr std::size_t kMaxPlaces = 30;  // the time grows with the fourth power

  AssignmentSearch(Points pixels, Points places, const LinePicture& picture,
                   std::span<const PaintedCurve> curves, const CameraPrior& prior)
      : pixels_(pixels),
        places_(places),
        picture_(picture),
        prior_(prior),
        points_(points_along(curves, kStepMm, kClearMm)),
        triangle_(widest_triangle(pixels)) {}

  /// The most promising first.
  std::vector<Assignment> run(const std::stop_token& stop) {
    for (const double k1 : {0.0, 0.15, 0.4}) {
      CameraPrior held = prior_;
      held.k1 = k1;
      for (const LensCamera& lens : lenses_of(held, picture_.width(), picture_.height())) {
        try_lens(lens, stop);
      }
    }
    std::vector<std::pair<double, Assignment>> best;
    best.reserve(found_.size());
    for (auto& [assignment, found] : found_) {
      if (stop.stop_requested()) return {};
      if (!is_minimal()) found.promise = evidence(found.camera) * (1 - found.off_px / max_off_px());
      best.emplace_back(found.promise, assignment);
    }
    std::sort(best.begin(), best.end(), std::greater<>{});
    if (best.size() > kMax) best.resize(kMax);
    std::vector<Assignment> out;
    for (auto& [promise, assignment] : best) out.push_back(std::move(assignment));
    return out;
  }

 private:
  /// The best camera for an assignment.
  struct Found {
    double off_px = 1e9;  // largest distance of a pixel from its place
    LensCamera camera;
    double promise = 0;
  };

  void try_lens(const LensCamera& lens, const std::stop_token& stop) {
    const std::array pixels{pixels_[triangle_[0]], pixels_[triangle_[1]], pixels_[triangle_[2]]};
    const double seen_turn = turn_of(pixels[0], pixels[1], pixels[2]);
    CamerasOfTriangle cameras(lens, pixels);
    for (std::size_t a = 0; a < places_.size() && !stop.stop_requested(); ++a) {
      for (std::size_t b = 0; b < places_.size(); ++b) {
        for (std::size_t c = 0; c < places_.size(); ++c) {
          const std::array places{places_[a], places_[b], places_[c]};
          // The image's y axis points down: seen from above, triangles turn the other way round.
          if (a == b || turn_of(places[0], places[1], places[2]) * seen_turn >= 0) continue;
          cameras.for_each(places, [&](const LensCamera& camera) { try_camera(camera, {a, b, c}); });
        }
      }
    }
  }

  void try_camera(const LensCamera& camera, const Triangle& places) {
    if (prior_.height_mm && std::abs(std::log(camera.position_mm.z() / *prior_.height_mm)) > kMaxHeightLog)
      return;
    Assignment assignment(pixels_.size(), places_.size());
    for (std::size_t i = 0; i < 3; ++i) assignment[triangle_[i]] = places[i];
    double off_px = 0;
    for (std::size_t i = 0; i < pixels_.size(); ++i) {
      if (assignment[i] < places_.size()) continue;
      double nearest_px = max_off_px();
      for (std::size_t p = 0; p < places_.size(); ++p) {
        if (std::find(assignment.begin(), assignment.end(), p) != assignment.end()) continue;
        const auto seen = camera.project({places_[p].x(), places_[p].y(), 0});
        const double here_px = seen ? (*seen - pixels_[i]).norm() : nearest_px;
        if (here_px >= nearest_px) continue;
        nearest_px = here_px;
        assignment[i] = p;
      }
      if (assignment[i] == places_.size()) return;
      off_px = std::max(off_px, nearest_px);
    }
    if (!is_from_above(pixels_, places_, assignment)) return;
    Found& found = found_[assignment];
    if (is_minimal()) {
      found.promise = std::max(found.promise, evidence(camera));
    } else if (off_px < found.off_px) {
      found.off_px = off_px;
      found.camera = camera;
    }
  }

  /// Three points: all cameras fit them equally well.
  bool is_minimal() const { return pixels_.size() == 3; }
  double max_off_px() const { return kMaxOffShare * picture_.width(); }
  double evidence(const LensCamera& camera) const { return line_evidence(camera, points_, picture_); }

  static constexpr double kStepMm = 240, kClearMm = 30;
  static constexpr double kMaxOffShare = 0.12;   // of the image's width: the lens is not known yet
  static constexpr double kMaxHeightLog = 0.35;  // for the same reason
  static constexpr std::size_t kMax = 120;

  Points pixels_, places_;
  const LinePicture& picture_;
  const CameraPrior& prior_;
  std::vector<CurvePoint> points_;
  Triangle triangle_;
  std::map<Assignment, Found> found_;
};

/// Cameras from which to fit points, the best first. Three points have several cameras, and four nearly so.
std::vector<LensCamera> first_cameras(Points pixels, Points places_mm, int width_px, int height_px,
                                      const CameraPrior& prior) {
  struct Start {
    double off_px;  // mean distance of the points
    LensCamera camera;
  };
  std::vector<Start> all;
  const Triangle t = widest_triangle(pixels);
  for (const LensCamera& lens : lenses_of(prior, width_px, height_px)) {
    CamerasOfTriangle cameras(lens, {pixels[t[0]], pixels[t[1]], pixels[t[2]]});
    cameras.for_each({places_mm[t[0]], places_mm[t[1]], places_mm[t[2]]}, [&](const LensCamera& camera) {
      double off_px = 0;
      for (std::size_t i = 0; i < pixels.size(); ++i) {
        const auto seen = camera.project({places_mm[i].x(), places_mm[i].y(), 0});
        off_px += seen ? std::min<double>(width_px, (*seen - pixels[i]).norm()) : width_px;
      }
      all.push_back({off_px / static_cast<double>(pixels.size()), camera});
    });
  }
  std::sort(all.begin(), all.end(), [](const Start& a, const Start& b) { return a.off_px < b.off_px; });
  constexpr double kAlikeShare = 0.01, kAlikeCos = 0.996;  // 5 degrees
  std::vector<LensCamera> out;
  for (const Start& start : all) {
    if (start.off_px > all.front().off_px + kAlikeShare * width_px) break;
    const bool is_known = std::any_of(out.begin(), out.end(), [&](const LensCamera& other) {
      return other.rotation.row(2).dot(start.camera.rotation.row(2)) > kAlikeCos;
    });
    if (!is_known) out.push_back(start.camera);
  }
  return out;
}

CameraFit fit_points(LensCamera camera, Points pixels, Points places_mm, double sigma_px,
                     const CameraPrior& prior) {
  std::vector<Sighting> sightings(pixels.size());
  // Three exact points and a wrong lens are far from the result. Fit with a coarse sigma first: with the
  // final sigma alone, the solver may end in a wrong minimum.
  CameraFit fit;
  for (const double sigma : {0.02 * camera.width, sigma_px}) {
    for (std::size_t i = 0; i < pixels.size(); ++i) {
      sightings[i].place_mm = {places_mm[i].x(), places_mm[i].y(), 0};
      sightings[i].pixel = pixels[i];
      sightings[i].sigma_px = sigma;
    }
    fit = fit_camera(camera, sightings, prior);
    camera = fit.camera;
  }
  return fit;
}

}  // namespace

std::optional<CameraFit> camera_of_points(Points pixels, Points places_mm, double sigma_px, int width_px,
                                          int height_px, const CameraPrior& prior) {
  const auto starts = first_cameras(pixels, places_mm, width_px, height_px, prior);
  if (starts.empty()) return std::nullopt;
  return fit_points(starts.front(), pixels, places_mm, sigma_px, prior);
}

std::vector<CurvePoint> evidence_points(std::span<const PaintedCurve> curves) {
  constexpr double kStepMm = 60, kClearMm = 30;
  return points_along(curves, kStepMm, kClearMm);
}

double line_evidence(const LensCamera& camera, std::span<const CurvePoint> points,
                     const LinePicture& picture) {
  constexpr double kRadiusShare = 0.012, kMarginPx = 4;
  constexpr int kEnough = 40;
  const double radius_px = kRadiusShare * picture.width();
  double found = 0;
  int expected = 0;
  for (const CurvePoint& point : points) {
    const auto pixel = camera.project(point.place_mm);
    if (!pixel || !camera.is_in_picture(*pixel, kMarginPx)) continue;
    ++expected;
    const double off = picture.distance_px.row(static_cast<int>(pixel->y() + 0.5))[std::lround(pixel->x())];
    if (off < radius_px) found += 1 - off / radius_px;
  }
  return expected > 0 ? found / std::max(kEnough, expected) : 0;
}

std::vector<PoseGuess> guess_poses(Points pixels, Points places_mm, bool names_known, double click_sigma_px,
                                   const LinePicture& picture, std::span<const PaintedCurve> curves,
                                   const CameraPrior& prior, const std::stop_token& stop) {
  std::vector<PoseGuess> out;
  if (pixels.size() < 3 || places_mm.size() < pixels.size()) return out;
  std::vector<Assignment> assignments;
  if (names_known) {
    assignments.emplace_back(pixels.size());
    std::iota(assignments.front().begin(), assignments.front().end(), std::size_t{0});
  } else if (places_mm.size() <= AssignmentSearch::kMaxPlaces) {
    assignments = AssignmentSearch(pixels, places_mm, picture, curves, prior).run(stop);
  }

  const auto points = evidence_points(curves);
  constexpr double kMaxRmsSigmas = 12;
  for (const Assignment& place_of : assignments) {
    if (stop.stop_requested()) return {};
    std::vector<Eigen::Vector2d> places;
    for (const std::size_t place : place_of) places.push_back(places_mm[place]);
    // Few points do not determine the distortion: try several values, and choose the one that fits the lines
    // best.
    PoseGuess best;
    best.evidence = -1;
    for (const double k1 : {0.0, 0.05, 0.1, 0.17, 0.25, 0.35, 0.5}) {
      CameraPrior held = prior;
      held.k1 = k1;
      held.k1_sigma = 0.02;
      for (const LensCamera& start : first_cameras(pixels, places, picture.width(), picture.height(), held)) {
        const CameraFit fit = fit_points(start, pixels, places, click_sigma_px, held);
        if (!is_plausible(fit.camera) || fit.rms > kMaxRmsSigmas) continue;
        const double evidence = line_evidence(fit.camera, points, picture);
        if (evidence > best.evidence) best = {fit.camera, place_of, fit.rms * click_sigma_px, evidence};
      }
    }
    if (best.evidence >= 0) out.push_back(std::move(best));
  }
  std::sort(out.begin(), out.end(),
            [](const PoseGuess& a, const PoseGuess& b) { return a.evidence > b.evidence; });
  return out;
}

}  // namespace sslv
