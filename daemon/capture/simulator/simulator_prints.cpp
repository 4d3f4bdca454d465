// SPDX-License-Identifier: Apache-2.0
#include "capture/simulator/simulator_prints.h"

#include "capture/simulator/simulator_random.h"

#include <algorithm>

namespace sslv {
namespace {

/// Variants of a label's colour from other printers and papers.
struct Makers {
  Label label;
  std::array<Paint, 4> paints;
};
constexpr std::array<Makers, 5> kMakers{{
    {label::kYellow, {{{235, 215, 60}, {214, 172, 30}, {240, 224, 92}, {226, 190, 52}}}},
    {label::kBlue, {{{22, 70, 172}, {48, 118, 214}, {36, 80, 150}, {30, 104, 206}}}},
    {label::kPink, {{{240, 96, 166}, {214, 50, 122}, {234, 118, 176}, {204, 62, 160}}}},
    {label::kGreen, {{{70, 214, 94}, {62, 186, 76}, {96, 224, 110}, {122, 204, 82}}}},
    {label::kOrange, {{{242, 124, 44}, {230, 96, 26}, {246, 118, 58}, {226, 112, 40}}}},
}};

Paint paint_of(const Makers& makers, double differ, SimulatorRandom& random) {
  const Paint& other = makers.paints[random.bits() % makers.paints.size()];
  return kPrints[makers.label].mixed(other, static_cast<float>(differ * random.uniform(0.5, 1)));
}

/// Ink bleached by the sun: paler and less saturated.
Paint faded(const Paint& paint, float share) {
  constexpr float kPaper = 200;
  const float pale = 0.6F * paint.luma() + 0.4F * kPaper;
  return paint.mixed({pale, pale, pale}, share);
}

}  // namespace

SimulatedPrints::SimulatedPrints(const HallOptions& hall) : ball_(kPrints[label::kOrange]) {
  SimulatorRandom random(scatter(static_cast<std::uint64_t>(hall.seed)) + 5);
  const double differ = hall.prints.makers.value(), fading = hall.prints.fading.value();
  for (auto& team : colors_) {
    Colors of_team;
    std::copy_n(kPrints.begin(), of_team.size(), of_team.begin());
    for (const Makers& makers : kMakers) of_team[makers.label] = paint_of(makers, differ, random);
    for (Colors& robot : team) {
      const auto fade = static_cast<float>(fading * random.uniform(0, 1));
      for (std::size_t i = 0; i < robot.size(); ++i) {
        const auto light = static_cast<float>(1 + 0.06 * differ * random.uniform(-1, 1));
        const bool is_ink =
            i == label::kYellow || i == label::kBlue || i == label::kPink || i == label::kGreen;
        robot[i] = is_ink ? faded(of_team[i].scaled(light), fade) : of_team[i];
      }
    }
  }
  if (differ > 0) ball_ = paint_of(kMakers.back(), differ, random);
}

double print_height_mm(const HallOptions& hall, Team team, int id, double height_mm) {
  const auto number =
      static_cast<std::uint64_t>(team) * SimulatedPrints::kIds + static_cast<std::uint64_t>(id);
  SimulatorRandom random(scatter(scatter(static_cast<std::uint64_t>(hall.seed)) + number) + 6);
  return height_mm + hall.prints.height_spread_mm.value() * random.uniform(-1, 1);
}

}  // namespace sslv
