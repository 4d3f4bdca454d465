// SPDX-License-Identifier: Apache-2.0
#include "services/field/agreement_now.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace sslv {
namespace {

/// Older differences are dropped, because a camera may have moved since. Robots cross each part of the field
/// more often than this.
constexpr double kForgotten_s = 600;

constexpr float kMinSamples = 30;  // in a part of the field
constexpr std::size_t kMinParts = 3;

}  // namespace

void write_now(CameraAgreement& agreement, double now_s, AgreementNow& out) noexcept {
  agreement.forget_differences(now_s - kForgotten_s);
  out.t_s = now_s;
  out.difference_count = 0;
  agreement.for_differences([&](const CameraAgreement::Difference& one) {
    if (out.difference_count == AgreementNow::kMaxDifferences) return;
    out.differences[out.difference_count++] = {one.camera,
                                               one.other,
                                               static_cast<float>(one.place_mm.x()),
                                               static_cast<float>(one.place_mm.y()),
                                               static_cast<float>(one.off_mm.x()),
                                               static_cast<float>(one.off_mm.y()),
                                               static_cast<float>(one.samples),
                                               one.t_s};
  });
  out.camera_count = 0;
  agreement.for_cameras([&](int id) {
    if (out.camera_count == AgreementNow::kMaxCameras) return;
    double squares = 0;
    int places = 0;
    for (std::size_t i = 0; i < out.difference_count; ++i) {
      const auto& one = out.differences[i];
      if (one.camera != id && one.other != id) continue;
      squares += agreement.error_of(id, {one.x_mm, one.y_mm}).squaredNorm();
      ++places;
    }
    out.cameras[out.camera_count++] = {id, agreement.time_offset_s(id),
                                       places > 0 ? std::sqrt(squares / places) : 0,
                                       agreement.evenness_of(id)};
  });
  out.height_count = 0;
  agreement.for_heights([&](const RobotName& name, const CameraAgreement::Height& height) {
    if (out.height_count == AgreementNow::kMaxRobots) return;
    out.heights[out.height_count++] = {static_cast<int>(name.team), name.id, height.more_mm, height.sigma_mm};
  });
}

std::vector<CameraPairNow> pairs_of(const AgreementNow& agreement) {
  std::map<std::pair<int, int>, std::vector<const AgreementNow::Difference*>> parts;
  for (std::size_t i = 0; i < agreement.difference_count; ++i) {
    const AgreementNow::Difference& one = agreement.differences[i];
    if (one.samples >= kMinSamples) parts[{one.camera, one.other}].push_back(&one);
  }
  const auto length = [](const AgreementNow::Difference* one) {
    return static_cast<double>(std::hypot(one->off_x_mm, one->off_y_mm));
  };
  std::vector<CameraPairNow> out;
  std::map<int, double> worst_of;  // by camera: sum over its pairs
  for (auto& [cameras, places] : parts) {
    if (places.size() < kMinParts) continue;
    std::sort(places.begin(), places.end(),
              [&](const auto* a, const auto* b) { return length(a) < length(b); });
    const auto* worst = places.back();
    out.push_back({.camera = cameras.first,
                   .other = cameras.second,
                   .off_mm = length(places[places.size() / 2]),
                   .parts = places.size(),
                   .worst_mm = {worst->x_mm, worst->y_mm}});
    worst_of[cameras.first] += out.back().off_mm;
    worst_of[cameras.second] += out.back().off_mm;
  }
  // List first the camera that differs more from all cameras together.
  for (CameraPairNow& pair : out) {
    if (worst_of[pair.other] > worst_of[pair.camera]) std::swap(pair.camera, pair.other);
  }
  return out;
}

Json to_json(const AgreementNow& now) {
  Json out{{"time", now.t_s},
           {"part_mm", CameraAgreement::kPartMm},
           {"cameras", Json::array()},
           {"heights", Json::array()},
           {"differences", Json::array()}};
  for (std::size_t i = 0; i < now.camera_count; ++i) {
    const auto& one = now.cameras[i];
    out["cameras"].push_back({{"camera", one.id},
                              {"time_offset_ms", to_hundredths(one.time_offset_s * 1e3)},
                              {"error_mm", to_hundredths(one.error_mm)},
                              {"evenness", to_hundredths(one.evenness)}});
  }
  for (std::size_t i = 0; i < now.height_count; ++i) {
    const auto& one = now.heights[i];
    out["heights"].push_back({{"team", name_of(static_cast<Team>(one.team))},
                              {"id", one.id},
                              {"more_mm", to_hundredths(one.more_mm)},
                              {"sigma_mm", to_hundredths(one.sigma_mm)}});
  }
  for (std::size_t i = 0; i < now.difference_count; ++i) {
    const auto& one = now.differences[i];
    out["differences"].push_back({{"cameras", {one.camera, one.other}},
                                  {"x", one.x_mm},
                                  {"y", one.y_mm},
                                  {"off_x_mm", to_hundredths(static_cast<double>(one.off_x_mm))},
                                  {"off_y_mm", to_hundredths(static_cast<double>(one.off_y_mm))},
                                  {"samples", static_cast<int>(one.samples)},
                                  {"time", one.t_s}});
  }
  return out;
}

}  // namespace sslv
