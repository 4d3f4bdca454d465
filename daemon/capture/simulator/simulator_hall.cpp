// SPDX-License-Identifier: Apache-2.0
#include "capture/simulator/simulator_hall.h"

#include "capture/simulator/simulator_random.h"

#include <cstddef>

namespace sslv {
namespace {

/// Carpet colours of real fields, as seen by cameras.
constexpr std::array<std::array<int, 3>, 6> kCarpets{
    {{34, 98, 48}, {30, 92, 62}, {44, 108, 50}, {26, 80, 44}, {52, 104, 66}, {36, 112, 62}}};

HallOptions plain() {
  HallOptions h;
  h.carpet = {.red = 30,
              .green = 92,
              .blue = 62,
              .blotches = 0,
              .blotch_mm = 220,
              .tint = 0,
              .weave = 0,
              .strip_mm = 0,
              .strip_step = 0,
              .seams = 0,
              .wear = 0,
              .shine = 0};
  h.lamps = {.uneven = 0, .cast = 0, .flicker_low = 1, .flicker_high = 1, .banding = 0, .shadows = 0};
  h.prints = {.makers = 0, .fading = 0, .height_spread_mm = 0};
  h.around = {.floor = HallFloor::kGrey, .boards = 0, .things = 0, .people = 0};
  h.sensor = {.block_noise = 0, .hot_pixels = 0};
  return h;
}

/// Chooses carpet and floor by the seed.
void furnish(HallOptions& hall, int seed) {
  SimulatorRandom random(scatter(static_cast<std::uint64_t>(seed)) + 1);
  const auto& carpet = kCarpets[random.bits() % kCarpets.size()];
  hall.carpet.red = carpet[0], hall.carpet.green = carpet[1], hall.carpet.blue = carpet[2];
  hall.around.floor = kHallFloorChoices[random.bits() % kHallFloorChoices.size()].value;
}

HallOptions usual(int seed) {
  HallOptions h;
  h.carpet = {.blotches = 0.1,
              .blotch_mm = 220,
              .tint = 0.12,
              .weave = 0.06,
              .strip_mm = 2000,
              .strip_step = 0.03,
              .seams = 0.15,
              .wear = 0.25,
              .shine = 0.15};
  h.lamps = {.uneven = 0.2,
             .cast = 0.04,
             .flicker_low = 0.75,
             .flicker_high = 1.33,
             .banding = 0.03,
             .shadows = 0.35};
  h.prints = {.makers = 0.6, .fading = 0.15, .height_spread_mm = 2};
  h.around = {.boards = 0.5, .things = 12, .people = 4};
  h.sensor = {.block_noise = 0.7, .hot_pixels = 5};
  furnish(h, seed);
  return h;
}

HallOptions hard(int seed) {
  HallOptions h;
  h.carpet = {.blotches = 0.13,
              .blotch_mm = 160,
              .tint = 0.13,
              .weave = 0.12,
              .strip_mm = 1500,
              .strip_step = 0.08,
              .seams = 0.35,
              .wear = 0.5,
              .shine = 0.4};
  h.lamps = {
      .uneven = 0.3, .cast = 0.1, .flicker_low = 0.6, .flicker_high = 1.6, .banding = 0.08, .shadows = 0.6};
  h.prints = {.makers = 1, .fading = 0.35, .height_spread_mm = 4};
  h.around = {.boards = 0.9, .things = 30, .people = 10};
  h.sensor = {.block_noise = 1.5, .hot_pixels = 30};
  furnish(h, seed);
  return h;
}

template <class P>
void fill(P& params, const P& from);

template <class P, class Field>
void fill_field(P& params, const P& from, const Field& field) {
  if (!(params.*field.member)) params.*field.member = from.*field.member;
}
template <class P, class S>
void fill_field(P& params, const P& from, const GroupField<P, S>& field) {
  fill(params.*field.member, from.*field.member);
}
/// Options of HallOptions itself, which are never null.
template <class E, std::size_t N>
void fill_field(HallOptions&, const HallOptions&, const ChoiceField<HallOptions, E, E, N>&) {}
template <class Limit>
void fill_field(HallOptions&, const HallOptions&, const NumberField<HallOptions, int, Limit>&) {}

template <class P>
void fill(P& params, const P& from) {
  std::apply([&](const auto&... field) { (fill_field(params, from, field), ...); }, P::fields());
}

}  // namespace

HallOptions resolved(HallOptions hall) {
  switch (hall.kind) {
    case HallKind::kPlain: fill(hall, plain()); break;
    case HallKind::kUsual: fill(hall, usual(hall.seed)); break;
    case HallKind::kHard: fill(hall, hard(hall.seed)); break;
  }
  return hall;
}

}  // namespace sslv
