// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include <Eigen/Core>

namespace sslv {

/// Residuals whose sum of squares is minimised. A negative return value ends the solver.
class LeastSquares {
 public:
  virtual ~LeastSquares() = default;
  virtual int inputs() const = 0;
  virtual int values() const = 0;
  virtual int operator()(const Eigen::VectorXd& x, Eigen::VectorXd& values) const = 0;
  /// The Jacobian: values() rows, inputs() columns.
  virtual int df(const Eigen::VectorXd& x, Eigen::MatrixXd& changes) const = 0;
};

struct Minimum {
  int evaluations = 0;
  double cost = 0;  // half the sum of squares
};

/// Moves `x` to a minimum by Levenberg-Marquardt, with at most `max_evaluations` evaluations of the
/// residuals. Stops when the relative change of x or of the cost is below `tolerance`.
Minimum minimise(LeastSquares& problem, Eigen::VectorXd& x, int max_evaluations, double tolerance);

/// Cauchy loss: large residuals count little.
struct CauchyLoss {
  double sigmas = 0;  // scale of the loss; 0: least squares

  /// Transformed residual, whose square is the loss.
  double value(double residual) const {
    if (sigmas <= 0) return residual;
    return std::copysign(sigmas * std::sqrt(std::log1p(residual * residual / (sigmas * sigmas))), residual);
  }
  /// Derivative of value().
  double slope(double residual) const {
    if (sigmas <= 0 || residual == 0) return 1;
    return residual / (1 + residual * residual / (sigmas * sigmas)) / value(residual);
  }
};

}  // namespace sslv
