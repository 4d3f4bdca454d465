// SPDX-License-Identifier: Apache-2.0
#include "calibration/refine_jointly.h"

#include "base/statistics.h"
#include "calibration/least_squares.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include <Eigen/Dense>

namespace sslv {
namespace {

/// Distance between nodes; between them, the offset of unevenly painted lines is interpolated.
constexpr double kPieceMm = 600;
/// Standard deviation of the lines' offsets from their positions.
constexpr double kLineSigmaMm = 2;
/// Standard deviation of one line patch.
constexpr double kPatchSigmaPx = 0.05;

Eigen::Vector2d side_of(const Eigen::Vector2d& direction) {
  return {-direction.y(), direction.x()};
}

double place_along(const PaintedCurve& curve, const Eigen::Vector2d& place) {
  const Eigen::Vector2d rel = place - curve.from;
  if (!curve.is_arc) return std::clamp(rel.dot(curve.direction(0)), 0.0, curve.length_mm());
  double turn = std::atan2(rel.y(), rel.x()) - curve.begin_rad;
  turn -= 2 * std::numbers::pi * std::floor(turn / (2 * std::numbers::pi));
  return std::min(turn * curve.radius_mm, curve.length_mm());
}

/// Sideways offset of each curve's paint, piecewise linear between nodes. Each node is a parameter.
class Paint {
 public:
  explicit Paint(std::span<const PaintedCurve> curves) {
    for (const PaintedCurve& curve : curves) {
      first_.push_back(count_);
      pieces_.push_back(std::max(1, static_cast<int>(curve.length_mm() / kPieceMm)));
      count_ += pieces_.back() + 1;
    }
  }
  int count() const { return count_; }

  struct Share {
    int before, after;  // indices of the nodes
    double of_after;
  };
  Share at(std::size_t curve, double share_of_length) const {
    const double at = share_of_length * pieces_[curve];
    const int piece = std::clamp(static_cast<int>(at), 0, pieces_[curve] - 1);
    return {first_[curve] + piece, first_[curve] + piece + 1, at - piece};
  }

 private:
  std::vector<int> first_, pieces_;
  int count_ = 0;
};

/// Parameters: each camera's step, the offset of each paint node, and the position of each tie.
class JointProblem final : public LeastSquares {
 public:
  JointProblem(std::span<const LensCamera> starts, std::span<const RefinedCamera> cameras,
               std::span<const PaintedCurve> curves, std::span<const OverlapTie> ties,
               const std::stop_token& stop)
      : starts_(starts), cameras_(cameras), curves_(curves), ties_(ties), stop_(stop), paint_(curves) {
    for (const RefinedCamera& camera : cameras)
      rows_ += static_cast<int>(camera.sightings.size()) + PriorRows::kCount;
    rows_ += paint_.count() + 4 * static_cast<int>(ties.size());
  }

  int inputs() const override { return first_tie() + 2 * static_cast<int>(ties_.size()); }
  int values() const override { return rows_; }
  int first_paint() const { return static_cast<int>(cameras_.size()) * kCameraParams; }
  int first_tie() const { return first_paint() + paint_.count(); }

  int operator()(const Eigen::VectorXd& x, Eigen::VectorXd& out) const override {
    visit(x, &out, nullptr);
    return stop_.stop_requested() ? -1 : 0;
  }
  int df(const Eigen::VectorXd& x, Eigen::MatrixXd& out) const override {
    out.setZero();
    visit(x, nullptr, &out);
    return stop_.stop_requested() ? -1 : 0;
  }

 private:
  void visit(const Eigen::VectorXd& x, Eigen::VectorXd* values, Eigen::MatrixXd* changes) const {
    int row = 0;
    const auto set = [&](double value) {
      if (values != nullptr) (*values)[row] = value;
    };
    const auto change = [&](int param, double by) {
      if (changes != nullptr) (*changes)(row, param) = by;
    };
    std::vector<SteppedCamera> stepped;
    for (std::size_t c = 0; c < cameras_.size(); ++c)
      stepped.emplace_back(starts_[c], CameraStep(x.segment<kCameraParams>(offset(c))));

    for (std::size_t c = 0; c < cameras_.size(); ++c) {
      for (const Sighting& sighting : cameras_[c].sightings) {
        const PaintedCurve& curve = curves_[sighting.curve];
        const double at_mm = place_along(curve, sighting.place_mm.head<2>());
        const Paint::Share share = paint_.at(sighting.curve, at_mm / curve.length_mm());
        const double before = x[first_paint() + share.before], after = x[first_paint() + share.after];
        const double off_mm = before + share.of_after * (after - before);
        const Eigen::Vector2d side = side_of(curve.direction(at_mm));
        const Eigen::Vector3d place = sighting.place_mm + off_mm * Eigen::Vector3d(side.x(), side.y(), 0);
        const auto seen = stepped[c].project(place);
        const Eigen::Vector2d n = sighting.normal.value_or(Eigen::Vector2d::Zero()) / kPatchSigmaPx;
        set(seen ? kLoss.value(n.dot(seen->pixel - sighting.pixel)) : 0);
        if (seen && changes != nullptr) {
          const double slope = kLoss.slope(n.dot(seen->pixel - sighting.pixel));
          changes->block(row, offset(c), 1, kCameraParams) = slope * n.transpose() * seen->by_step;
          // Numerical derivative: moves the point 1 mm sideways.
          const auto beside = stepped[c].camera().project(place + Eigen::Vector3d(side.x(), side.y(), 0));
          const double by_mm = beside ? slope * n.dot(*beside - seen->pixel) : 0;
          change(first_paint() + share.before, by_mm * (1 - share.of_after));
          change(first_paint() + share.after, by_mm * share.of_after);
        }
        ++row;
      }
      const PriorRows known = prior_rows(stepped[c], cameras_[c].prior);
      if (values != nullptr) values->segment<PriorRows::kCount>(row) = known.off;
      if (changes != nullptr)
        changes->block<PriorRows::kCount, kCameraParams>(row, offset(c)) = known.by_step;
      row += PriorRows::kCount;
    }
    for (int i = 0; i < paint_.count(); ++i, ++row) {
      set(x[first_paint() + i] / kLineSigmaMm);
      change(first_paint() + i, 1 / kLineSigmaMm);
    }
    for (std::size_t t = 0; t < ties_.size(); ++t) {
      const OverlapTie& tie = ties_[t];
      const int param = first_tie() + 2 * static_cast<int>(t);
      const Eigen::Vector3d place(x[param], x[param + 1], tie.height_mm);
      for (const auto& [c, pixel] : {std::pair{tie.camera_a, tie.pixel_a}, {tie.camera_b, tie.pixel_b}}) {
        const auto seen = stepped[c].project(place);
        const auto right = stepped[c].camera().project(place + Eigen::Vector3d::UnitX()),
                   ahead = stepped[c].camera().project(place + Eigen::Vector3d::UnitY());
        for (int i = 0; i < 2; ++i, ++row) {
          const double off = seen ? (seen->pixel[i] - pixel[i]) / tie.sigma_px : 0;
          set(kLoss.value(off));
          if (!seen || !right || !ahead || changes == nullptr) continue;
          const double slope = kLoss.slope(off) / tie.sigma_px;
          changes->block(row, offset(c), 1, kCameraParams) = slope * seen->by_step.row(i);
          change(param, slope * ((*right)[i] - seen->pixel[i]));
          change(param + 1, slope * ((*ahead)[i] - seen->pixel[i]));
        }
      }
    }
  }

  static constexpr CauchyLoss kLoss{4};
  static int offset(std::size_t camera) { return static_cast<int>(camera) * kCameraParams; }

  std::span<const LensCamera> starts_;
  std::span<const RefinedCamera> cameras_;
  std::span<const PaintedCurve> curves_;
  std::span<const OverlapTie> ties_;
  const std::stop_token& stop_;
  Paint paint_;
  int rows_ = 0;
};

}  // namespace

std::vector<double> disagreements_mm(std::span<const LensCamera> cameras, std::span<const RefinedCamera> seen,
                                     std::span<const PaintedCurve> curves) {
  constexpr double kNearMm = 60;
  struct Mark {
    std::size_t curve;
    double at_mm, off_mm;
  };
  std::vector<std::vector<Mark>> marks(cameras.size());
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    for (const Sighting& sighting : seen[c].sightings) {
      const auto place = cameras[c].unproject(sighting.pixel, 0);
      if (!place) continue;
      const PaintedCurve& curve = curves[sighting.curve];
      const double at_mm = place_along(curve, sighting.place_mm.head<2>());
      const double off_mm = (*place - sighting.place_mm.head<2>()).dot(side_of(curve.direction(at_mm)));
      marks[c].push_back({sighting.curve, at_mm, off_mm});
    }
  }
  std::vector<double> out;
  for (std::size_t a = 0; a < marks.size(); ++a) {
    for (std::size_t b = a + 1; b < marks.size(); ++b) {
      for (const Mark& mark : marks[a]) {
        const Mark* nearest = nullptr;
        double min_mm = kNearMm;
        for (const Mark& other : marks[b]) {
          if (other.curve != mark.curve || std::abs(other.at_mm - mark.at_mm) >= min_mm) continue;
          min_mm = std::abs(other.at_mm - mark.at_mm);
          nearest = &other;
        }
        if (nearest != nullptr) out.push_back(mark.off_mm - nearest->off_mm);
      }
    }
  }
  return out;
}

JointCalibration refine_jointly(std::span<const RefinedCamera> cameras, std::span<const PaintedCurve> curves,
                                std::span<const OverlapTie> ties, const std::stop_token& stop) {
  JointCalibration out;
  for (const RefinedCamera& camera : cameras) out.cameras.push_back(camera.camera);
  const std::vector<double> before = disagreements_mm(out.cameras, cameras, curves);
  out.disagreement_before_mm = rms(before);
  out.overlapping_patches = static_cast<int>(before.size());

  constexpr int kRounds = 3, kMaxSteps = 25;
  Eigen::VectorXd paint;  // kept between rounds
  for (int round = 0; round < kRounds; ++round) {
    JointProblem problem(out.cameras, cameras, curves, ties, stop);
    Eigen::VectorXd x = Eigen::VectorXd::Zero(problem.inputs());
    if (paint.size() > 0) x.segment(problem.first_paint(), paint.size()) = paint;
    for (std::size_t t = 0; t < ties.size(); ++t) {
      const auto place = out.cameras[ties[t].camera_a].unproject(ties[t].pixel_a, ties[t].height_mm);
      if (place) x.segment<2>(problem.first_tie() + 2 * static_cast<int>(t)) = *place;
    }
    minimise(problem, x, kMaxSteps, 1e-9);
    if (stop.stop_requested()) break;
    std::vector<LensCamera> next;
    for (std::size_t c = 0; c < cameras.size(); ++c)
      next.push_back(
          moved(out.cameras[c], CameraStep(x.segment<kCameraParams>(static_cast<int>(c) * kCameraParams))));
    if (!std::all_of(next.begin(), next.end(), is_plausible)) break;
    out.cameras = std::move(next);
    paint = x.segment(problem.first_paint(), problem.first_tie() - problem.first_paint());
    if (x.head(problem.first_paint()).norm() < 1e-6) break;
  }
  out.disagreement_mm = rms(disagreements_mm(out.cameras, cameras, curves));
  return out;
}

}  // namespace sslv
