// SPDX-License-Identifier: Apache-2.0
#include "calibration/fit_camera.h"

#include "calibration/least_squares.h"
#include "calibration/statistics.h"

#include <cmath>
#include <limits>

#include <Eigen/Dense>
#include <unsupported/Eigen/NonLinearOptimization>

namespace sslv {
namespace {

/// In sigmas, for places that the camera cannot show.
constexpr double kUnseen = 1e3;

/// Residuals and their changes, as rows: two for a point, one for a line, and those of the prior.
class Problem : public LeastSquaresTypes {
 public:
  Problem(const LensCamera& start, std::span<const Sighting> sightings, const CameraPrior& prior,
          double cauchy)
      : start_(start), sightings_(sightings), prior_(prior), loss_{cauchy} {
    for (const Sighting& sighting : sightings) rows_ += sighting.normal ? 1 : 2;
  }

  int inputs() const { return kCameraParams; }
  int values() const { return sighting_rows() + PriorRows::kCount; }
  int sighting_rows() const { return rows_; }

  int operator()(const InputType& x, ValueType& out) const {
    visit(x, &out, nullptr);
    return 0;
  }
  int df(const InputType& x, JacobianType& out) const {
    visit(x, nullptr, &out);
    return 0;
  }

 private:
  void visit(const InputType& x, ValueType* values, JacobianType* changes) const {
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

/// Down to where no step helps any more.
void descend(LensCamera& camera, double& cost, std::span<const Sighting> sightings, const CameraPrior& prior,
             const FitOptions& options) {
  // Restarted from where it arrived, the steps' parameters are again small changes of a camera near by.
  constexpr int kRounds = 4;
  int steps_left = options.max_steps;
  for (int round = 0; round < kRounds && steps_left > 0; ++round) {
    Problem problem(camera, sightings, prior, options.cauchy);
    Eigen::LevenbergMarquardt<Problem> solver(problem);
    solver.parameters.maxfev = steps_left;
    solver.parameters.ftol = solver.parameters.xtol = 1e-10;
    Eigen::VectorXd step = Eigen::VectorXd::Zero(kCameraParams);
    solver.minimize(step);
    steps_left -= static_cast<int>(solver.nfev);
    const LensCamera next = moved(camera, CameraStep(step));
    if (!is_sane(next)) break;
    camera = next;
    cost = 0.5 * solver.fnorm * solver.fnorm;
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
  // A focal length that the sightings hardly show may have gone far up its valley, from where steps are slow
  // to come back: started again at its expected value, they need not.
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
