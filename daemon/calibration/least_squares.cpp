// SPDX-License-Identifier: Apache-2.0
#include "calibration/least_squares.h"

#include <Eigen/Dense>
#include <unsupported/Eigen/NonLinearOptimization>

namespace sslv {

Minimum minimise(LeastSquares& problem, Eigen::VectorXd& x, int max_evaluations, double tolerance) {
  Eigen::LevenbergMarquardt<LeastSquares> solver(problem);
  solver.parameters.maxfev = max_evaluations;
  solver.parameters.ftol = solver.parameters.xtol = tolerance;
  solver.minimize(x);
  return {static_cast<int>(solver.nfev), 0.5 * solver.fnorm * solver.fnorm};
}

}  // namespace sslv
