// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <optional>

namespace sslv {

/// Learns how a camera's own clock runs against the host's, from when its images arrive: late arrivals say
/// little, since an image is never early but often late. The low quantile of quarters of a second is
/// followed by a robust straight line (offset and drift) over ten seconds. A clock that jumps is learnt
/// again. No allocation, a fraction of a microsecond an image. For one thread.
class CameraClock {
 public:
  struct Estimate {
    double t_host_s = 0;   // when the image would have arrived without any delay by chance
    double sigma_s = 0;    // standard deviation of that, as far as the fit can tell
    bool settled = false;  // enough was seen to know the drift too
  };

  /// An image with its time on the camera's clock and that of its arrival on a steady clock of the host,
  /// both in seconds since any moment.
  Estimate add(double t_camera_s, double t_arrival_s);

  /// Seconds that the camera's clock gains in a second; 0 until it is settled.
  double drift() const { return -slope_; }

 private:
  static constexpr std::size_t kBins = 40, kMaxInBin = 64;
  struct Point {
    double t_s = 0, offset_s = 0;  // host less camera: the low quantile
    double rise_s = 0;             // of that above the least
  };

  bool has_jumped(double t_camera_s, double offset_s);
  void restart();
  void close_bin();
  void fit();
  double predicted_offset_s(double t_s) const { return offset_s_ + slope_ * (t_s - middle_s_); }

  double base_camera_s_ = 0, base_arrival_s_ = 0;  // so that numbers stay small
  bool started_ = false;
  double last_s_ = 0;

  std::array<double, kMaxInBin> in_bin_{};  // offsets, sorted
  std::size_t in_bin_count_ = 0;
  double bin_start_s_ = 0, bin_sum_s_ = 0;
  std::array<Point, kBins> bins_{};  // a ring
  std::size_t bin_count_ = 0, next_bin_ = 0;

  double offset_s_ = 0, slope_ = 0, middle_s_ = 0;  // the line
  double residual_s_ = 0, rise_s_ = 0;              // of the points off the line; their mean rise
  int strays_ = 0;                                  // images in a row that a jump would explain
  double stray_offset_s_ = 0, first_stray_s_ = 0;
};

}  // namespace sslv
