// SPDX-License-Identifier: Apache-2.0
#include "calibration/find_pose.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>
#include <set>

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

/// Projection of a camera that looks straight down: pixel = scale * rotation * (x, -y) + shift.
struct Similarity {
  double cos = 1, sin = 0;  // cosine and sine of the rotation, times the scale in px/mm
  Eigen::Vector2d shift_px;

  Eigen::Vector2d operator()(const Eigen::Vector2d& place_mm) const {
    const double x = place_mm.x(), y = -place_mm.y();
    return shift_px + Eigen::Vector2d(cos * x - sin * y, sin * x + cos * y);
  }
  double px_per_mm() const { return std::hypot(cos, sin); }
};

/// Least-squares fit.
Similarity similarity_of(Points pixels, Points places) {
  Eigen::Vector2d middle_px(0, 0), middle_mm(0, 0);
  const auto flipped = [&](std::size_t i) { return Eigen::Vector2d(places[i].x(), -places[i].y()); };
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    middle_px += pixels[i] / static_cast<double>(pixels.size());
    middle_mm += flipped(i) / static_cast<double>(pixels.size());
  }
  double a = 0, b = 0, n = 0;
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    const Eigen::Vector2d p = flipped(i) - middle_mm, q = pixels[i] - middle_px;
    a += p.dot(q);
    b += p.x() * q.y() - p.y() * q.x();
    n += p.squaredNorm();
  }
  Similarity out{a / n, b / n, middle_px};
  out.shift_px = Eigen::Vector2d::Zero();
  out.shift_px = middle_px - out({middle_mm.x(), -middle_mm.y()});
  return out;
}

/// A camera looking straight down that projects the field like the similarity `map`.
LensCamera looking_down(const Similarity& map, int width_px, int height_px, const CameraPrior& prior) {
  LensCamera out;
  out.width = width_px;
  out.height = height_px;
  out.center_x = prior.center_x;
  out.center_y = prior.center_y;
  out.k1 = prior.k1;
  out.k2 = prior.k2;
  const double scale = std::max(1e-6, map.px_per_mm()), c = map.cos / scale, s = map.sin / scale;
  const double height_mm = prior.height_mm.value_or(prior.focal_px / scale);
  out.focal_px = scale * height_mm;
  out.rotation << c, s, 0, s, -c, 0, 0, 0, -1;
  const Eigen::Vector2d d = (Eigen::Vector2d(prior.center_x, prior.center_y) - map.shift_px) / scale;
  out.position_mm = {c * d.x() + s * d.y(), -(-s * d.x() + c * d.y()), height_mm};
  return out;
}

/// For few places: adds all assignments of pixels to places.
void add_permutations(Points pixels, Points places, std::vector<Assignment>& out) {
  Assignment order(places.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::set<Assignment> seen;
  do {
    Assignment first(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(pixels.size()));
    if (seen.insert(first).second && is_from_above(pixels, places, first)) out.push_back(std::move(first));
  } while (std::next_permutation(order.begin(), order.end()));
}

/// For many places: assigns two pixels to two places, and each other pixel to the place that is nearest under
/// the similarity through these two.
void add_by_pairs(Points pixels, Points places, const LinePicture& picture, std::vector<Assignment>& out,
                  const std::stop_token& stop) {
  struct Candidate {
    Assignment place_of;
    double off_px;
  };
  std::vector<Candidate> candidates;
  const double width = picture.width();
  const double max_off_px = 0.12 * width;  // tilt and distortion cause deviations from the similarity
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    for (std::size_t j = i + 1; j < pixels.size(); ++j) {
      if (stop.stop_requested()) return;
      if ((pixels[i] - pixels[j]).norm() < 0.15 * width) continue;
      const std::array pair{pixels[i], pixels[j]};
      for (std::size_t a = 0; a < places.size(); ++a) {
        for (std::size_t b = 0; b < places.size(); ++b) {
          if (a == b) continue;
          const Similarity map = similarity_of(pair, std::array{places[a], places[b]});
          if (map.px_per_mm() * 20000 < width || map.px_per_mm() * 1500 > width) continue;
          Candidate candidate{Assignment(pixels.size()), 0};
          std::set<std::size_t> taken;
          for (std::size_t k = 0; k < pixels.size(); ++k) {
            double nearest = max_off_px;
            for (std::size_t p = 0; p < places.size(); ++p) {
              const double off = (map(places[p]) - pixels[k]).norm();
              if (off >= nearest) continue;
              nearest = off;
              candidate.place_of[k] = p;
            }
            candidate.off_px += nearest;
            if (nearest >= max_off_px || !taken.insert(candidate.place_of[k]).second) {
              candidate.off_px = -1;
              break;
            }
          }
          if (candidate.off_px >= 0 && is_from_above(pixels, places, candidate.place_of))
            candidates.push_back(std::move(candidate));
        }
      }
    }
  }
  std::sort(candidates.begin(), candidates.end(),
            [](const Candidate& a, const Candidate& b) { return a.off_px < b.off_px; });
  constexpr std::size_t kMax = 120;
  std::set<Assignment> seen;
  for (Candidate& candidate : candidates) {
    if (seen.size() >= kMax) break;
    if (seen.insert(candidate.place_of).second) out.push_back(std::move(candidate.place_of));
  }
}

}  // namespace

CameraFit camera_of_points(Points pixels, Points places_mm, double sigma_px, int width_px, int height_px,
                           const CameraPrior& prior) {
  std::vector<Sighting> sightings(pixels.size());
  LensCamera camera = looking_down(similarity_of(pixels, places_mm), width_px, height_px, prior);
  // A tilted camera is far from the start, which looks straight down. Fit with a coarse sigma first: with the
  // final sigma alone, the solver may end in a wrong minimum.
  CameraFit fit;
  for (const double sigma : {0.02 * width_px, sigma_px}) {
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

std::vector<PoseGuess> guess_poses(Points pixels, Points places_mm, bool any_order, double click_sigma_px,
                                   const LinePicture& picture, std::span<const PaintedCurve> curves,
                                   const CameraPrior& prior, const std::stop_token& stop) {
  std::vector<PoseGuess> out;
  if (pixels.size() < 3 || places_mm.size() < pixels.size()) return out;
  std::vector<Assignment> assignments;
  if (!any_order) {
    Assignment given(pixels.size());
    std::iota(given.begin(), given.end(), std::size_t{0});
    assignments.push_back(std::move(given));
  } else if (places_mm.size() <= 6) {
    add_permutations(pixels, places_mm, assignments);
  } else {
    add_by_pairs(pixels, places_mm, picture, assignments, stop);
  }

  const auto points = evidence_points(curves);
  constexpr double kMaxRmsSigmas = 12;
  for (const Assignment& place_of : assignments) {
    if (stop.stop_requested()) return {};
    std::vector<Eigen::Vector2d> places;
    for (const std::size_t place : place_of) places.push_back(places_mm[place]);
    // Four corners do not determine the distortion: try several values, and choose the one that fits the
    // lines best.
    PoseGuess best;
    best.evidence = -1;
    for (const double k1 : {0.0, 0.05, 0.1, 0.17, 0.25, 0.35, 0.5}) {
      CameraPrior held = prior;
      held.k1 = k1;
      held.k1_sigma = 0.02;
      const CameraFit fit =
          camera_of_points(pixels, places, click_sigma_px, picture.width(), picture.height(), held);
      if (!is_plausible(fit.camera) || fit.rms > kMaxRmsSigmas) continue;
      const double evidence = line_evidence(fit.camera, points, picture);
      if (evidence > best.evidence) best = {fit.camera, place_of, fit.rms * click_sigma_px, evidence};
    }
    if (best.evidence >= 0) out.push_back(std::move(best));
  }
  std::sort(out.begin(), out.end(),
            [](const PoseGuess& a, const PoseGuess& b) { return a.evidence > b.evidence; });
  return out;
}

}  // namespace sslv
