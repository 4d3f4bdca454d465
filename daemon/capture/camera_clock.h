// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <optional>

namespace sslv {

/// Estimates the offset and drift of a camera's clock relative to the host's from the arrival times of
/// images. An image is never early but often late, so the class computes a low quantile of the offsets in
/// each quarter second, and fits a robust line through the quantiles of ten seconds. Restarts when the clock
/// jumps. No allocation, a fraction of a microsecond per image. For one thread.
class CameraClock {
 public:
  struct Estimate {
    double t_host_s = 0;   // estimated arrival time without random delay
    double sigma_s = 0;    // its standard deviation, estimated from the fit
    bool settled = false;  // enough data to estimate the drift, too
  };

  /// Adds an image with its time on the camera's clock and its arrival on the host's steady clock, both in
  /// seconds since an arbitrary epoch.
  Estimate add(double t_camera_s, double t_arrival_s);

  /// Seconds per second by which the camera's clock gains; 0 until settled.
  double drift() const { return -line_.slope; }

 private:
  static constexpr std::size_t kBins = 40, kMaxInBin = 64;
  struct Point {
    double t_s = 0, offset_s = 0;  // mean camera time of the bin; low quantile of host minus camera time
    double rise_s = 0;             // height of that quantile above the bin's minimum
  };
  /// The images since the last bin was closed.
  struct OpenBin {
    std::array<double, kMaxInBin> offsets_s{};  // sorted
    std::size_t count = 0;
    double start_s = 0, t_sum_s = 0;
  };
  /// One point per bin, for the newest bins.
  struct ClosedBins {
    std::array<Point, kBins> points{};  // a ring buffer
    std::size_t count = 0, next = 0;
  };
  /// The fitted offset with its drift.
  struct Line {
    double offset_s = 0, slope = 0, middle_s = 0;
    double at(double t_s) const { return offset_s + slope * (t_s - middle_s); }
  };
  /// Consecutive outliers that a clock jump would explain.
  struct Strays {
    int count = 0;
    double offset_s = 0, first_s = 0;
  };

  bool has_jumped(double t_s, double offset_s);
  void restart();
  void close_bin();
  void fit();

  double base_camera_s_ = 0, base_arrival_s_ = 0;  // reference times, subtracted for precision
  bool started_ = false;
  double last_s_ = 0;
  OpenBin bin_;
  ClosedBins bins_;
  Line line_;
  double residual_s_ = 0, rise_s_ = 0;  // spread of the points around the line; mean of the points' rise_s
  Strays strays_;
};

}  // namespace sslv
