// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include <Eigen/Core>

namespace sslv {

/// What Eigen's solver wants to know of a problem.
struct LeastSquaresTypes {
  using Scalar = double;
  using InputType = Eigen::VectorXd;
  using ValueType = Eigen::VectorXd;
  using JacobianType = Eigen::MatrixXd;
};

/// Cauchy's loss: residuals many sigmas off count little.
struct CauchyLoss {
  double sigmas = 0;  // from where on; 0: all count by their square

  /// What to take for a residual so that its square is the loss.
  double value(double residual) const {
    if (sigmas <= 0) return residual;
    return std::copysign(sigmas * std::sqrt(std::log1p(residual * residual / (sigmas * sigmas))), residual);
  }
  /// Change of that with the residual.
  double slope(double residual) const {
    if (sigmas <= 0 || residual == 0) return 1;
    return residual / (1 + residual * residual / (sigmas * sigmas)) / value(residual);
  }
};

}  // namespace sslv
