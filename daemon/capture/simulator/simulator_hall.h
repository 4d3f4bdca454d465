// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/params.h"

#include <array>
#include <cstdint>
#include <optional>
#include <tuple>

namespace sslv {

/// Selects the values of all hall options that are null.
enum class HallKind : std::uint8_t {
  kPlain,  // an even carpet under steady light, nothing around
  kUsual,  // like most halls
  kHard,   // like the worst halls
};
inline constexpr std::array<Choice<HallKind>, 3> kHallKindChoices{
    {{"plain", HallKind::kPlain}, {"usual", HallKind::kUsual}, {"hard", HallKind::kHard}}};

enum class HallFloor : std::uint8_t { kGrey, kDark, kWood };
inline constexpr std::array<Choice<HallFloor>, 3> kHallFloorChoices{
    {{"grey", HallFloor::kGrey}, {"dark", HallFloor::kDark}, {"wood", HallFloor::kWood}}};

// Null options depend on the hall's kind: resolved() fills them in.

struct HallCarpetOptions {
  std::optional<int> red{}, green{}, blue{};
  std::optional<double> blotches{}, blotch_mm{}, tint{}, weave{}, strip_mm{}, strip_step{}, seams{}, wear{},
      shine{};
  static constexpr auto fields() {
    using O = HallCarpetOptions;
    return std::tuple{
        number("red", &O::red, 0, 255, "",
               "its colour in light 1; null: one of several carpets, chosen by the seed"),
        number("green", &O::green, 0, 255, "", "the same"),
        number("blue", &O::blue, 0, 255, "", "the same"),
        number("blotches", &O::blotches, 0.0, 0.5, "",
               "light and dark patches: standard deviation of brightness, as a fraction"),
        number("blotch_mm", &O::blotch_mm, 30.0, 5000.0, "mm", "size of the patches"),
        number("tint", &O::tint, 0.0, 0.5, "", "coloured patches: the same for red; half as much for blue"),
        number("weave", &O::weave, 0.0, 0.5, "", "ribs: amplitude of their brightness, as a fraction"),
        number("strip_mm", &O::strip_mm, 0.0, 10'000.0, "mm", "width of its strips; 0: one piece"),
        number("strip_step", &O::strip_step, 0.0, 0.5, "",
               "largest deviation of a strip's brightness from the mean, as a fraction"),
        number("seams", &O::seams, 0.0, 1.0, "",
               "brightness difference of the seams between strips, as a fraction"),
        number("wear", &O::wear, 0.0, 1.0, "", "how pale it is where it is worn"),
        number("shine", &O::shine, 0.0, 1.0, "", "sheen where it reflects a lamp"),
    };
  }
};

struct HallLampOptions {
  std::optional<double> uneven{}, cast{}, flicker_low{}, flicker_high{}, banding{}, shadows{};
  static constexpr auto fields() {
    using O = HallLampOptions;
    return std::tuple{
        number(
            "uneven", &O::uneven, 0.0, 0.9, "",
            "several lamps: largest deviation of the brightness on the field from the mean, as a fraction"),
        number("cast", &O::cast, 0.0, 0.5, "",
               "lamps of two colours: fraction by which red is stronger and blue weaker on one side, and "
               "vice versa on the other"),
        number("flicker_low", &O::flicker_low, 0.1, 4.0, "",
               "light that differs from image to image: smallest factor; factors in between are equally "
               "likely on a logarithmic scale"),
        number("flicker_high", &O::flicker_high, 0.1, 4.0, "", "largest factor"),
        number("banding", &O::banding, 0.0, 0.9, "",
               "bands of mains light at 100 Hz across the rows: amplitude of their brightness, as a "
               "fraction; if rolling_shutter_ms is 0, they assume 10 ms"),
        number("shadows", &O::shadows, 0.0, 1.0, "", "soft shadows of robots, balls and people on the floor"),
    };
  }
};

struct HallPrintOptions {
  std::optional<double> makers{}, fading{}, height_spread_mm{};
  static constexpr auto fields() {
    using O = HallPrintOptions;
    return std::tuple{
        number("makers", &O::makers, 0.0, 1.0, "",
               "how much the colours of prints and balls differ between makers and between prints"),
        number("fading", &O::fading, 0.0, 0.9, "", "how pale the palest robot's print is"),
        number("height_spread_mm", &O::height_spread_mm, 0.0, 30.0, "mm",
               "largest deviation of a robot's height from its team's"),
    };
  }
};

struct HallSurroundOptions {
  std::optional<HallFloor> floor{};
  std::optional<double> boards{};
  std::optional<int> things{}, people{};
  static constexpr auto fields() {
    using O = HallSurroundOptions;
    return std::tuple{
        choice("floor", &O::floor, kHallFloorChoices, "floor beside the carpet; null: chosen by the seed"),
        number("boards", &O::boards, 0.0, 1.0, "", "share of the carpet's edge with advertising boards"),
        number("things", &O::things, 0, 100, "",
               "cones, cables, bags, bottles and the like around the field, never inside its lines"),
        number("people", &O::people, 0, 30, "",
               "people around the field, some leaning in, never inside its lines"),
    };
  }
};

struct HallSensorOptions {
  std::optional<double> block_noise{}, hot_pixels{};
  static constexpr auto fields() {
    using O = HallSensorOptions;
    return std::tuple{
        number("block_noise", &O::block_noise, 0.0, 30.0, "",
               "errors of blocks of 8 x 8 pixels, as JPEG causes them, new in each image: standard deviation "
               "of Y, U and V in 8-bit grey levels"),
        number("hot_pixels", &O::hot_pixels, 0.0, 1000.0, "",
               "pixels per million that are always too bright; each camera has its own"),
    };
  }
};

/// The hall around the field and its effects on the image. Things in the hall do not move.
struct HallOptions {
  HallKind kind = HallKind::kPlain;
  int seed = 1;
  HallCarpetOptions carpet;
  HallLampOptions lamps;
  HallPrintOptions prints;
  HallSurroundOptions around;
  HallSensorOptions sensor;
  static constexpr auto fields() {
    using O = HallOptions;
    return std::tuple{
        choice("kind", &O::kind, kHallKindChoices,
               "plain: an even carpet in steady light; usual, hard: textures, changing and uneven light, "
               "boards, people, faded prints. Null options follow this kind"),
        number("seed", &O::seed, 0, 1'000'000, "",
               "each seed gives another hall; all cameras of a field need the same"),
        group("carpet", &O::carpet, "its colour and texture"),
        group("lamps", &O::lamps, "distribution and changes of the light"),
        group("prints", &O::prints, "differences between robots"),
        group("around", &O::around, "surroundings of the carpet"),
        group("sensor", &O::sensor, "errors of the camera's sensor"),
    };
  }
};

/// Returns the options with all null values filled in.
HallOptions resolved(HallOptions hall);

}  // namespace sslv
