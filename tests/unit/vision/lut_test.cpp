// SPDX-License-Identifier: Apache-2.0
#include "vision/lut.h"

#include "base/error.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <random>
#include <utility>

#include <gmock/gmock.h>
#include <unistd.h>

namespace sslv::lut_test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

template <class Act>
std::string error_of(Act act) {
  try {
    act();
  } catch (const SettingsError& error) {
    return error.what();
  }
  return "no error";
}

class LutFile : public ::testing::Test {
 protected:
  void SetUp() override { std::filesystem::create_directories(folder_); }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  std::string write(const std::vector<std::uint8_t>& bytes) {
    const auto file = folder_ / "table.lut";
    std::ofstream(file, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    return file.string();
  }
  const std::filesystem::path folder_ =
      std::filesystem::temp_directory_path() / ("lut_test." + std::to_string(::getpid()));
};

TEST(Lut, ClassesAreHueAndSaturationALaterOneWins) {
  ColorSettings colors;
  colors.classes = {{"green", {0, 255}, {180, 270}, {10, 1000}}, {"field", {0, 100}, {180, 270}, {10, 1000}}};
  const auto lut = make_lut(colors, "/colors");
  const Yuv bright = to_yuv({60, 220, 90}), dark = to_yuv({20, 90, 40}), red = to_yuv({200, 30, 30});
  EXPECT_EQ(lut->of_yuv(bright.y, bright.u, bright.v), label::kGreen);
  EXPECT_EQ(lut->of_yuv(dark.y, dark.u, dark.v), label::kField);
  EXPECT_EQ(lut->of_yuv(red.y, red.u, red.v), label::kClear);
}

TEST(Lut, HueMayPassZero) {
  ColorSettings colors;
  colors.classes = {{"pink", {0, 255}, {350, 370}, {10, 1000}}};
  const auto lut = make_lut(colors, "/colors");
  EXPECT_EQ(lut->of_yuv(128, 168, 127), label::kPink);
  EXPECT_EQ(lut->of_yuv(128, 168, 131), label::kPink);
  EXPECT_EQ(lut->of_yuv(128, 168, 168), label::kClear);
}

TEST(Lut, RgbTableAgreesWithYuv) {
  ColorSettings colors;
  colors.classes = {{"orange", {0, 255}, {90, 160}, {30, 1000}}};
  const auto lut = make_lut(colors, "/colors");
  for (const Rgb c : {Rgb{240, 120, 20}, Rgb{20, 60, 220}, Rgb{128, 128, 128}, Rgb{120, 60, 10}}) {
    const Yuv yuv = to_yuv(c);
    EXPECT_EQ(lut->of_rgb(c.r, c.g, c.b), lut->of_yuv(yuv.y, yuv.u, yuv.v));
  }
}

TEST(Lut, NamesAnUnknownLabel) {
  ColorSettings colors;
  colors.classes = {{"orange", {}, {}, {}}, {"purple", {}, {}, {}}};
  EXPECT_THAT(error_of([&] { make_lut(colors, "/cameras/0/colors"); }),
              AllOf(HasSubstr("/cameras/0/colors/classes/1/label: \"purple\""), HasSubstr("pink")));
}

TEST(Lut, SharesAreThoseOfALabelsColours) {
  ColorSettings colors;
  colors.classes = {{"orange", {60, 255}, {108, 147}, {34, 1000}},
                    {"blue", {20, 255}, {320, 380}, {40, 1000}}};
  const auto lut = make_lut(colors, "");
  for (const Label label : {label::kOrange, label::kBlue}) {
    const auto& mean = lut->chromaticity_mean(label);
    EXPECT_NEAR(mean[0] + mean[1] + mean[2], 1, 1e-9);
  }
  EXPECT_GT(lut->chromaticity_mean(label::kOrange)[0], lut->chromaticity_mean(label::kOrange)[1]);
  EXPECT_GT(lut->chromaticity_mean(label::kOrange)[1], lut->chromaticity_mean(label::kOrange)[2]);
  EXPECT_GT(lut->chromaticity_mean(label::kBlue)[2], 0.4);
  EXPECT_GT(lut->chromaticity_spread(label::kOrange), 0.01);
  EXPECT_LT(lut->chromaticity_spread(label::kOrange), 0.2);
  for (const double share : lut->chromaticity_mean(label::kPink))
    EXPECT_NEAR(share, 1.0 / 3, 1e-9) << "a label without colours";
  EXPECT_EQ(lut->chromaticity_spread(label::kPink), 0);
}

TEST(Lut, PrintsTellMoreThanCells) {
  ColorTable table;
  for (Label& label : table.labels) label = label::kGreen;
  table.prints[label::kGreen] = PrintColor{{2000, 6000, 2000}, 900};
  const Lut lut(table);
  EXPECT_NEAR(lut.chromaticity_mean(label::kGreen)[1], 0.6, 1e-9);
  EXPECT_NEAR(lut.chromaticity_spread(label::kGreen), 0.09, 1e-9);
  EXPECT_TRUE(lut.color_table() == table);
  const CellRun erased{0, 100, label::kGreen, label::kClear};
  EXPECT_EQ(lut.with_changes({&erased, 1}).prints(), table.prints);
  const Lut forgotten = lut.with_changes({&erased, 1}, {});
  EXPECT_LT(forgotten.chromaticity_mean(label::kGreen)[1], 0.5);
  EXPECT_EQ(with_bits(std::make_shared<const Lut>(lut), 5)->prints(), table.prints);
}

TEST(Lut, SharesStayWhenTheLightChanges) {
  // One colour in all its shades, and a table with only their brighter half.
  const auto shades = [](double darkest) {
    std::vector<Label> labels(Lut::kEntries);
    for (int i = 0; i < 1000; ++i) {
      const double light = darkest + (1 - darkest) * i / 1000;
      const auto byte = [&](double value) { return static_cast<std::uint8_t>(value * light); };
      for (int near = 0; near < 27; ++near) {
        const Yuv c = to_yuv({byte(224), byte(66), byte(150)});
        const auto off = [](std::uint8_t value, int by) {
          return static_cast<std::uint8_t>(value + 2 * (by - 1));
        };
        labels[Lut::index_yuv(off(c.y, near % 3), off(c.u, near / 3 % 3), off(c.v, near / 9))] = label::kPink;
      }
    }
    return Lut(std::move(labels)).chromaticity_mean(label::kPink);
  };
  const auto all = shades(0.2), bright = shades(0.6);
  const std::array<double, 3> expected{224.0 / 440, 66.0 / 440, 150.0 / 440};
  for (std::size_t c = 0; c < 3; ++c) {
    EXPECT_NEAR(all[c], expected[c], 0.02) << c;
    EXPECT_NEAR(bright[c], expected[c], 0.02) << c;
  }
}

TEST_F(LutFile, ComesBackAsWritten) {
  ColorSettings colors;
  colors.classes = {{"orange", {0, 255}, {90, 160}, {30, 1000}}};
  const auto lut = make_lut(colors, "");
  const auto again = read_lut(write(lut_file_bytes(*lut)), "");
  EXPECT_EQ(again->yuv().labels, lut->yuv().labels);
  EXPECT_NE(again->id(), lut->id());
}

TEST_F(LutFile, ProblemsNameSettingAndFile) {
  const std::string file = write({'S', 'S', 'L', 'V', 'L', 'U', 'T', '1', 0, 0});
  EXPECT_THAT(error_of([&] { read_lut(file, "/cameras/0/colors/lut_file"); }),
              AllOf(HasSubstr("/cameras/0/colors/lut_file"), HasSubstr(file), HasSubstr("10 bytes")));
  EXPECT_THAT(error_of([&] { read_lut("/does/not/exist", "/x"); }), HasSubstr("No such file"));
}

TEST(Lut, ClassesMayHaveOwnLabels) {
  const LabelSet labels({{11, "purple", "#8020c0"}}, "/own_labels");
  ColorSettings colors;
  colors.classes = {{"purple", {0, 255}, {0, 40}, {10, 1000}}};
  const auto lut = make_lut(colors, "/colors", labels);
  const Yuv purple = to_yuv({160, 60, 200});
  EXPECT_EQ(lut->of_yuv(purple.y, purple.u, purple.v), 11);
  EXPECT_NE(lut->chromaticity_mean(11)[2], lut->chromaticity_mean(11)[1]);
  EXPECT_THAT(error_of([&] { make_lut(colors, "/colors"); }), HasSubstr("\"purple\" is not allowed"));
}

// ---- other bit depths, and changes

class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}
  unsigned below(unsigned end) { return static_cast<unsigned>(engine_() % end); }
  std::uint8_t byte() { return static_cast<std::uint8_t>(below(256)); }
  Label label() { return static_cast<Label>(below(label::kMaxCount)); }

 private:
  std::mt19937 engine_;
};

/// Boxes of any label, as real tables have, and a few random cells.
ColorTable blobs(int bits, unsigned seed) {
  ColorTable table(bits);
  Random random(seed);
  const auto side = static_cast<unsigned>(table.side());
  for (int blob = 0; blob < 12; ++blob) {
    const Label label = random.label();
    const unsigned from_u = random.below(side), from_v = random.below(side), from_y = random.below(side);
    const unsigned size = 1 + random.below(side / 2);
    for (unsigned u = from_u; u < std::min(side, from_u + size); ++u) {
      for (unsigned v = from_v; v < std::min(side, from_v + size); ++v) {
        for (unsigned y = from_y; y < std::min(side, from_y + size); ++y)
          table.labels[(u * side + v) * side + y] = label;
      }
    }
  }
  const auto count = static_cast<unsigned>(table.labels.size());
  for (int i = 0; i < 100; ++i) table.labels[random.below(count)] = random.label();
  return table;
}

void expect_same(const Lut& found, const Lut& expected) {
  for (const auto& [a, b] :
       {std::pair{&found.yuv(), &expected.yuv()}, std::pair{&found.rgb(), &expected.rgb()}}) {
    EXPECT_EQ(a->bits, b->bits);
    EXPECT_TRUE(a->labels == b->labels);
    EXPECT_TRUE(a->blocks == b->blocks);
    EXPECT_TRUE(a->chroma == b->chroma);
  }
  for (std::size_t label = 0; label < label::kMaxCount; ++label) {
    const auto value = static_cast<Label>(label);
    EXPECT_EQ(found.chromaticity_mean(value), expected.chromaticity_mean(value)) << label;
    EXPECT_EQ(found.chromaticity_spread(value), expected.chromaticity_spread(value)) << label;
  }
}

class LutOfBits : public ::testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(All, LutOfBits, ::testing::Values(5, 6, 7, 8));

TEST_P(LutOfBits, HasTheTablesLabelsInAllItsColours) {
  const ColorTable table = blobs(GetParam(), 3);
  const Lut lut(table);
  EXPECT_TRUE(lut.color_table() == table);
  EXPECT_EQ(lut.color_bits(), GetParam());
  Random random(5);
  // The RGB table has the label of the centre of its own cell.
  const unsigned half = lut.rgb().bits == 8 ? 0 : 1;
  const auto middle = [&] { return static_cast<std::uint8_t>(random.byte() | half); };
  for (int i = 0; i < 100'000; ++i) {
    const Yuv c{random.byte(), random.byte(), random.byte()};
    ASSERT_EQ(lut.of_yuv(c.y, c.u, c.v), table.of(c));
    const Rgb rgb{middle(), middle(), middle()};
    ASSERT_EQ(lut.of_rgb(rgb.r, rgb.g, rgb.b), table.of(to_yuv(rgb)));
  }
}

TEST_P(LutOfBits, ChangesGiveWhatAWholeRebuildGives) {
  ColorTable table = blobs(GetParam(), 7);
  Lut lut(table);
  Random random(static_cast<unsigned>(GetParam()));
  const auto count = static_cast<unsigned>(table.labels.size());
  for (int round = 0; round < 12; ++round) {
    std::vector<CellRun> changed;
    // Changes single cells, runs, and in the last round more than with_changes() is meant for.
    const int runs = round == 11 ? 3000 : round % 3 == 0 ? 1 : 40;
    const unsigned longest = round == 11 ? count / 3000 : round % 2 == 0 ? 1 : 30;
    for (int i = 0; i < runs; ++i) {
      const unsigned begin = random.below(count);
      const unsigned length = std::min(1 + random.below(longest), count - begin);
      const Label label = random.below(4) == 0 ? random.label() : label::kClear;
      changed.push_back({begin, length, table.labels[begin], label});
      std::fill_n(table.labels.begin() + begin, length, label);
    }
    lut = lut.with_changes(changed);
    if (GetParam() == 8 && round % 6 != 5) continue;  // building a whole table is slow
    expect_same(lut, Lut(table));
    if (HasFailure()) FAIL() << "round " << round;
  }
}

TEST(Lut, EveryCellCanBeChangedOnItsOwn) {
  // Includes corners and edges of the cube, where RGB colours with clamped chroma lie.
  Lut lut{ColorTable(5)};
  ColorTable table(5);
  std::vector<CellRun> changed;
  for (std::uint32_t cell = 0; cell < table.labels.size(); cell += 17) {
    changed.push_back({cell, 1, 0, static_cast<Label>(1 + cell % 31)});
    table.labels[cell] = changed.back().after;
    if (changed.size() < 100) continue;
    lut = lut.with_changes(changed);
    changed.clear();
  }
  expect_same(lut.with_changes(changed), Lut(table));
}

TEST(Lut, RefusesInvalidTables) {
  EXPECT_THAT(error_of([] { Lut(ColorTable(7, {1, 2, 3})); }), HasSubstr("3 labels; expected 2097152"));
  EXPECT_THAT(error_of([] { Lut(ColorTable(4)); }), HasSubstr("4 bits a channel; expected 5 .. 8"));
  ColorTable table(5);
  table.labels[9] = 32;
  EXPECT_THAT(error_of([&] { Lut{table}; }), HasSubstr("label 32; labels are 0 .. 31"));
}

// ---- summaries for fast classification of images

TEST(LutTable, BlocksAndChromasNameALabelOnlyWhenAllTheirColoursHaveIt) {
  // A random table: every summary must hold for every colour.
  std::vector<Label> labels(Lut::kEntries);
  std::mt19937 random(1);
  for (std::size_t i = 0; i < labels.size(); ++i)
    labels[i] = random() % 100 == 0 ? label::kPink : i < labels.size() / 2 ? label::kClear : label::kField;
  const Lut lut(std::move(labels));

  std::size_t uniform_blocks = 0;
  for (const LutTable* table : {&lut.yuv(), &lut.rgb()}) {
    const bool is_rgb = table == &lut.rgb();
    for (int a = 0; a < 256; ++a) {
      for (int b = 0; b < 256; ++b) {
        for (int c = 0; c < 256; ++c) {
          const auto byte = [](int value) { return static_cast<std::uint8_t>(value); };
          const Label label = table->of(byte(a), byte(b), byte(c));
          const Label block = table->blocks[static_cast<std::size_t>((a / 4 * 64 + b / 4) * 64 + c / 4)];
          // For RGB, chroma comes from byte-wise averages: a is R, b is B, c is G.
          const int chroma_a = is_rgb ? (b + (255 - c) + 1) / 2 : a,
                    chroma_b = is_rgb ? (a + (255 - c) + 1) / 2 : b;
          const Label chroma = table->chroma[static_cast<std::size_t>(chroma_a / 8 * 32 + chroma_b / 8)];
          if (block != label && block != LutTable::kMixed)
            FAIL() << "block of " << a << ", " << b << ", " << c << " in " << (is_rgb ? "RGB" : "YUV");
          if (chroma != label && chroma != LutTable::kMixed)
            FAIL() << "chroma of " << a << ", " << b << ", " << c << " in " << (is_rgb ? "RGB" : "YUV");
          uniform_blocks += block != LutTable::kMixed;
        }
      }
    }
  }
  EXPECT_GT(uniform_blocks, 0u);  // otherwise nothing was checked
}

TEST(LutTable, ATidyTableHasUniformChromas) {
  ColorSettings colors;
  colors.classes = {{"orange", {60, 255}, {108, 147}, {34, 1000}}};
  const auto lut = make_lut(colors, "");
  for (const LutTable* table : {&lut->yuv(), &lut->rgb()}) {
    EXPECT_GT(std::count(table->chroma.begin(), table->chroma.end(), label::kClear), 500);
    EXPECT_GT(std::count(table->chroma.begin(), table->chroma.end(), LutTable::kMixed), 50);
  }
}

TEST(ColorTable, OtherBitsKeepWhatCellsMean) {
  ColorTable table(6);
  std::minstd_rand random(1);
  for (Label& label : table.labels) label = static_cast<Label>(random() % label::kCount);
  EXPECT_EQ(resampled(table, 6), table);
  const ColorTable finer = resampled(table, 8);
  for (std::size_t cell = 0; cell < finer.labels.size(); cell += 997)
    ASSERT_EQ(finer.labels[cell], table.of(finer.color_of(cell)));
  EXPECT_EQ(resampled(finer, 6), table);
  // The majority label of the eight cells counts; of equally many, the lowest.
  ColorTable fine(7);
  for (const std::uint8_t y : std::array<std::uint8_t, 2>{0, 2})
    for (const std::uint8_t v : std::array<std::uint8_t, 2>{0, 2})
      fine.labels[fine.index(y, 0, v)] = label::kPink;
  EXPECT_EQ(resampled(fine, 6).of({0, 0, 0}), label::kClear);
  fine.labels[fine.index(0, 2, 0)] = label::kPink;
  EXPECT_EQ(resampled(fine, 6).of({0, 0, 0}), label::kPink);
}

}  // namespace
}  // namespace sslv::lut_test
