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
  double drift() const { return -line_.slope; }

 private:
  static constexpr std::size_t kBins = 40, kMaxInBin = 64;
  struct Point {
    double t_s = 0, offset_s = 0;  // host less camera: the low quantile
    double rise_s = 0;             // of that above the least
  };
  /// Of the images since the last bin was closed.
  struct OpenBin {
    std::array<double, kMaxInBin> offsets_s{};  // sorted
    std::size_t count = 0;
    double start_s = 0, t_sum_s = 0;
  };
  /// One point of each, of the newest ones.
  struct ClosedBins {
    std::array<Point, kBins> points{};  // a ring
    std::size_t count = 0, next = 0;
  };
  /// The offset and its drift.
  struct Line {
    double offset_s = 0, slope = 0, middle_s = 0;
    double at(double t_s) const { return offset_s + slope * (t_s - middle_s); }
  };
  /// Images in a row that a jump would explain.
  struct Strays {
    int count = 0;
    double offset_s = 0, first_s = 0;
  };

  bool has_jumped(double t_s, double offset_s);
  void restart();
  void close_bin();
  void fit();

  double base_camera_s_ = 0, base_arrival_s_ = 0;  // so that numbers stay small
  bool started_ = false;
  double last_s_ = 0;
  OpenBin bin_;
  ClosedBins bins_;
  Line line_;
  double residual_s_ = 0, rise_s_ = 0;  // of the points off the line; their mean rise
  Strays strays_;
};

}  // namespace sslv
