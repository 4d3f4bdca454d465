// SPDX-License-Identifier: Apache-2.0
#include "calibration/fit_camera.h"

#include "base/statistics.h"
#include "calibration/least_squares.h"

#include <cmath>
#include <limits>

#include <Eigen/Dense>

namespace sslv {
namespace {

/// Residual in sigmas for places that the camera cannot show.
constexpr double kUnseen = 1e3;

/// Residuals and their Jacobian. Rows: two per point sighting, one per line sighting, then the prior's.
class Problem final : public LeastSquares {
 public:
  Problem(const LensCamera& start, std::span<const Sighting> sightings, const CameraPrior& prior,
          double cauchy)
      : start_(start), sightings_(sightings), prior_(prior), loss_{cauchy} {
    for (const Sighting& sighting : sightings) rows_ += sighting.normal ? 1 : 2;
  }

  int inputs() const override { return kCameraParams; }
  int values() const override { return sighting_rows() + PriorRows::kCount; }
  int sighting_rows() const { return rows_; }

  int operator()(const Eigen::VectorXd& x, Eigen::VectorXd& out) const override {
    visit(x, &out, nullptr);
    return 0;
  }
  int df(const Eigen::VectorXd& x, Eigen::MatrixXd& out) const override {
    visit(x, nullptr, &out);
    return 0;
  }

 private:
  void visit(const Eigen::VectorXd& x, Eigen::VectorXd* values, Eigen::MatrixXd* changes) const {
    const SteppedCamera stepped(start_, CameraStep(x));
    int row = 0;
    const auto add = [&](double off, const Eigen::Matrix<double, 1, kCameraParams>& by_step) {
      if (values != nullptr) (*values)[row] = loss_.value(off);
      if (changes != nullptr) changes->row(row) = loss_.slope(off) * by_step;
      ++row;
    };
    using Change = Eigen::Matrix<double, 1, kCameraParams>;
    for (const Sighting& sighting : sightings_) {
      const auto seen = stepped.project(sighting.place_mm);
      const double weight = 1 / sighting.sigma_px;
      if (!seen) {
        for (int i = 0; i < (sighting.normal ? 1 : 2); ++i) add(kUnseen, Change::Zero());
      } else if (sighting.normal) {
        const Eigen::Vector2d& n = *sighting.normal;
        add(weight * n.dot(seen->pixel - sighting.pixel), weight * n.transpose() * seen->by_step);
      } else {
        const Eigen::Vector2d off = weight * (seen->pixel - sighting.pixel);
        for (int i = 0; i < 2; ++i) add(off[i], weight * seen->by_step.row(i));
      }
    }
    const PriorRows known = prior_rows(stepped, prior_);
    if (values != nullptr) values->tail<PriorRows::kCount>() = known.off;
    if (changes != nullptr) changes->bottomRows<PriorRows::kCount>() = known.by_step;
  }

  const LensCamera& start_;
  std::span<const Sighting> sightings_;
  const CameraPrior& prior_;
  CauchyLoss loss_;
  int rows_ = 0;
};

bool is_sane(const LensCamera& camera) {
  return camera.position_mm.allFinite() && camera.rotation.allFinite() && std::isfinite(camera.k1) &&
         camera.focal_px > 10 && camera.focal_px < 1e6;
}

/// Iterates until no step reduces the cost.
void descend(LensCamera& camera, double& cost, std::span<const Sighting> sightings, const CameraPrior& prior,
             const FitOptions& options) {
  // Restarting from the result makes the step's parameters small changes of a nearby camera again.
  constexpr int kRounds = 4;
  int steps_left = options.max_steps;
  for (int round = 0; round < kRounds && steps_left > 0; ++round) {
    Problem problem(camera, sightings, prior, options.cauchy);
    Eigen::VectorXd step = Eigen::VectorXd::Zero(kCameraParams);
    const Minimum found = minimise(problem, step, steps_left, 1e-10);
    steps_left -= found.evaluations;
    const LensCamera next = moved(camera, CameraStep(step));
    if (!is_sane(next)) break;
    camera = next;
    cost = found.cost;
    if (step.norm() < 1e-6) break;
  }
}

}  // namespace

CameraFit fit_camera(const LensCamera& start, std::span<const Sighting> sightings, const CameraPrior& prior,
                     const FitOptions& options) {
  CameraFit out;
  out.camera = start;
  out.cost = std::numeric_limits<double>::infinity();
  descend(out.camera, out.cost, sightings, prior, options);
  // If the sightings hardly determine the focal length, the fit may end far along the valley, from where it
  // returns slowly. Fit again from the expected focal length and keep the better camera.
  constexpr double kFarSigmas = 1.5;
  const double grown = std::log(out.camera.focal_px / prior.focal_px);
  if (std::abs(grown) > kFarSigmas * prior.focal_share) {
    CameraStep back = CameraStep::Zero();
    back[kZoom] = -grown;
    LensCamera other = moved(out.camera, back);
    double cost = std::numeric_limits<double>::infinity();
    descend(other, cost, sightings, prior, options);
    if (cost < out.cost) out.camera = other;
  }
  const Problem problem(out.camera, sightings, prior, options.cauchy);
  Eigen::VectorXd values(problem.values());
  Eigen::MatrixXd changes(problem.values(), static_cast<int>(kCameraParams));
  const Eigen::VectorXd here = Eigen::VectorXd::Zero(kCameraParams);
  problem(here, values);
  problem.df(here, changes);
  const auto seen = changes.topRows(problem.sighting_rows());
  const auto known = changes.bottomRows(changes.rows() - problem.sighting_rows());
  out.by_sightings = seen.transpose() * seen;
  out.by_prior = known.transpose() * known;
  out.cost = 0.5 * values.squaredNorm();
  out.rms = rms(residuals(out.camera, sightings));
  return out;
}

std::vector<double> residuals(const LensCamera& camera, std::span<const Sighting> sightings) {
  std::vector<double> out;
  out.reserve(sightings.size());
  for (const Sighting& sighting : sightings) {
    const auto pixel = camera.project(sighting.place_mm);
    if (!pixel) {
      out.push_back(kUnseen);
    } else {
      const Eigen::Vector2d off = (*pixel - sighting.pixel) / sighting.sigma_px;
      out.push_back(sighting.normal ? sighting.normal->dot(off) : off.norm());
    }
  }
  return out;
}

std::vector<double> residuals_px(const LensCamera& camera, std::span<const Sighting> sightings) {
  std::vector<double> out = residuals(camera, sightings);
  for (std::size_t i = 0; i < out.size(); ++i) out[i] *= sightings[i].sigma_px;
  return out;
}

Eigen::Matrix<double, Eigen::Dynamic, kCameraParams> residuals_by_step(const LensCamera& camera,
                                                                       std::span<const Sighting> sightings) {
  Eigen::Matrix<double, Eigen::Dynamic, kCameraParams> out(static_cast<Eigen::Index>(sightings.size()),
                                                           static_cast<int>(kCameraParams));
  const SteppedCamera stepped(camera, CameraStep::Zero());
  Eigen::Index row = 0;
  for (const Sighting& sighting : sightings) {
    out.row(row).setZero();
    const auto seen = stepped.project(sighting.place_mm);
    if (seen && sighting.normal)
      out.row(row) = sighting.normal->transpose() * seen->by_step / sighting.sigma_px;
    ++row;
  }
  return out;
}

}  // namespace sslv
