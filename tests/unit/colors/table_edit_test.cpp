// SPDX-License-Identifier: Apache-2.0
#include "colors/table_edit.h"

#include "base/error.h"

#include <algorithm>
#include <random>

#include <gmock/gmock.h>

namespace sslv::table_edit_test {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

// Tables of 5 bits: a cell is 8 levels wide, so cell n begins at level 8 n.
constexpr int kStep = 8;

Label& at(ColorTable& table, int y, int u, int v) {
  return table.labels[static_cast<std::size_t>((u * table.side() + v) * table.side() + y)];
}
Levels level(int y, int u, int v) {
  return {y * kStep, u * kStep, v * kStep};
}
std::size_t count(const ColorTable& table, Label label) {
  return static_cast<std::size_t>(std::count(table.labels.begin(), table.labels.end(), label));
}
ColorTable with_box(Label label, int from, int to) {
  ColorTable table(5);
  for (int u = from; u <= to; ++u) {
    for (int v = from; v <= to; ++v) {
      for (int y = from; y <= to; ++y) at(table, y, u, v) = label;
    }
  }
  return table;
}

/// Applies the edit and compares the returned runs with the actual changes.
void edit(ColorTable& table, const TableEdit& edit) {
  const ColorTable before = table;
  const std::vector<CellRun> runs = apply_edit(table, edit);
  ColorTable again = before;
  std::uint32_t end = 0;
  for (const CellRun& run : runs) {
    ASSERT_TRUE(run.length > 0 && run.begin >= end && run.before != run.after);
    for (std::uint32_t cell = run.begin; cell < run.begin + run.length; ++cell) {
      ASSERT_EQ(again.labels[cell], run.before);
      again.labels[cell] = run.after;
    }
    end = run.begin + run.length;
  }
  EXPECT_TRUE(again.labels == table.labels);
}

TEST(TableEdit, AClusterKeepsASurfacesClearCells) {
  const ColorCluster cluster{{},
                             ColorCluster::Spread{{100, 120, 140}, {{{16, 0, 0}, {0, 16, 0}, {0, 0, 16}}}}};
  ColorTable whole(7), table(7);
  edit(whole, AddClusterEdit{label::kPink, cluster});
  const auto is_surface = [](Yuv color) { return color.y <= 100; };
  table.labels[table.index(90, 120, 140)] = label::kBlue;
  AddClusterEdit spared{label::kPink, cluster, Over::kAny, is_surface};
  EXPECT_GT(cells_left_clear(table, spared), 100U);
  edit(table, spared);
  EXPECT_EQ(table.of({110, 120, 140}), label::kPink);
  EXPECT_EQ(table.of({96, 120, 140}), label::kClear);
  EXPECT_EQ(table.of({90, 120, 140}), label::kPink) << "it was no clear cell";
  EXPECT_EQ(count(table, label::kPink) + cells_left_clear(table, spared), count(whole, label::kPink));
  const ColorTable once = table;
  edit(table, spared);
  EXPECT_TRUE(table == once) << "a second click takes no more";

  ColorTable pointed_at(7);
  edit(pointed_at, AddClusterEdit{label::kPink, cluster, Over::kAny, [](Yuv) { return true; }});
  EXPECT_TRUE(pointed_at == whole) << "who points at a surface means it";
}

/// Carpet of one colour; floor of another.
std::shared_ptr<const SurfaceColors> flat_surfaces(Rgb carpet, Rgb floor) {
  auto out = std::make_shared<SurfaceColors>();
  for (int i = 0; i < 1000; ++i) {
    out->add(SurfaceKind::kCarpet, to_yuv(carpet));
    out->add(SurfaceKind::kFloor, to_yuv(floor));
  }
  out->noise_sigma = {1, 1, 1};
  return out;
}

TEST(TableEdit, WideningMarginsKeepsALabelsTypicalColours) {
  constexpr Rgb kCarpet{40, 90, 50}, kFloor{120, 118, 116};
  const auto at_rgb = [](const ColorTable& table, Rgb color) { return table.of(to_yuv(color)); };
  constexpr Rgb kGreyish{116, 122, 112};
  ColorTable table(6);
  // Most green cells have dots' colours; some have the carpet's, and some are nearly grey.
  for (std::size_t cell = 0; cell < table.labels.size(); ++cell) {
    const Rgb c = to_rgb(table.color_of(cell));
    const bool is_greyish =
        std::abs(c.r - kGreyish.r) + std::abs(c.g - kGreyish.g) + std::abs(c.b - kGreyish.b) < 20;
    if ((c.g > 1.5 * std::max(c.r, c.b) && c.g > 30) || is_greyish) table.labels[cell] = label::kGreen;
  }
  ASSERT_EQ(at_rgb(table, kCarpet), label::kGreen);
  ASSERT_EQ(at_rgb(table, kGreyish), label::kGreen);
  edit(table, WidenMarginsEdit{flat_surfaces(kCarpet, kGreyish)});
  EXPECT_EQ(at_rgb(table, kCarpet), label::kClear);
  EXPECT_EQ(at_rgb(table, {56, 126, 70}), label::kClear) << "1.4 times as bright";
  EXPECT_EQ(at_rgb(table, {28, 63, 35}), label::kClear) << "0.7 times as bright";
  EXPECT_EQ(at_rgb(table, {90, 202, 112}), label::kGreen) << "beyond the range";
  EXPECT_EQ(at_rgb(table, kGreyish), label::kClear) << "grey is not typical of green";

  ColorTable board = table;
  edit(board, WidenMarginsEdit{flat_surfaces(kCarpet, {90, 202, 112})});
  EXPECT_EQ(at_rgb(board, {90, 202, 112}), label::kGreen) << "a floor of the dots' very green";
  edit(board, WidenMarginsEdit{flat_surfaces({90, 202, 112}, kFloor)});
  EXPECT_EQ(at_rgb(board, {90, 202, 112}), label::kClear) << "the carpet takes from any label";
  const auto again = apply_edit(board, WidenMarginsEdit{flat_surfaces({90, 202, 112}, kFloor)});
  EXPECT_TRUE(again.empty());
}

TEST(TableEdit, ABallIsAnEllipsoidOfLevels) {
  ColorTable table(7);
  edit(table, PaintEdit{label::kPink, {100, 120, 140}, {8, 4, 0}});
  EXPECT_EQ(table.of({100, 120, 140}), label::kPink);
  EXPECT_EQ(table.of({108, 120, 140}), label::kPink);
  EXPECT_EQ(table.of({110, 120, 140}), label::kClear);
  EXPECT_EQ(table.of({100, 124, 140}), label::kPink);
  EXPECT_EQ(table.of({100, 126, 140}), label::kClear);
  EXPECT_EQ(table.of({108, 124, 140}), label::kClear) << "not a box";
  EXPECT_EQ(table.of({100, 120, 142}), label::kClear);
  // Radii: 4 cells in Y, 2 in U. Cells: 9 on the Y axis, 7 at U +-1, 1 at U +-2.
  EXPECT_EQ(count(table, label::kPink), 9u + 2 * 7 + 2 * 1);
}

TEST(TableEdit, ABoxHasItsCorners) {
  ColorTable table(7);
  edit(table, PaintEdit{label::kPink, {100, 120, 140}, {8, 4, 2}, Shape::kBox});
  EXPECT_EQ(count(table, label::kPink), 9u * 5 * 3);
  EXPECT_EQ(table.of({108, 124, 142}), label::kPink);
}

TEST(TableEdit, ABrushEndsAtTheCubesFaces) {
  ColorTable table(5);
  edit(table, PaintEdit{label::kPink, {0, 255, 0}, {16, 16, 16}, Shape::kBox});
  EXPECT_EQ(count(table, label::kPink), 3u * 3 * 3);
}

TEST(TableEdit, PaintMayLeaveOtherLabelsAlone) {
  ColorTable table = with_box(label::kBlue, 0, 4);
  edit(table, PaintEdit{label::kPink, level(4, 4, 4), {8, 8, 8}, Shape::kBox, Over::kClear});
  EXPECT_EQ(count(table, label::kBlue), 125u);
  EXPECT_EQ(count(table, label::kPink), 27u - 8);
  edit(table, PaintEdit{label::kPink, level(4, 4, 4), {8, 8, 8}, Shape::kBox, Over::kAny});
  EXPECT_EQ(count(table, label::kPink), 27u);
}

TEST(TableEdit, EraseMayTakeOnlyOneLabel) {
  ColorTable table = with_box(label::kBlue, 0, 4);
  at(table, 2, 2, 2) = label::kPink;
  edit(table, EraseEdit{level(2, 2, 2), {8, 8, 8}, Shape::kBox, label::kBlue});
  EXPECT_EQ(at(table, 2, 2, 2), label::kPink);
  EXPECT_EQ(count(table, label::kBlue), 125u - 27);
  edit(table, EraseEdit{level(2, 2, 2), {8, 8, 8}});
  EXPECT_EQ(count(table, label::kPink), 0u);
}

TEST(TableEdit, FillStaysWithinConnectedCellsOfOneLabel) {
  ColorTable table = with_box(label::kBlue, 2, 4);
  at(table, 5, 5, 5) = label::kBlue;  // touches only at a corner
  edit(table, FillEdit{label::kPink, level(3, 3, 3)});
  EXPECT_EQ(count(table, label::kPink), 9u) << "one slice";
  EXPECT_EQ(at(table, 3, 2, 4), label::kPink);
  edit(table, FillEdit{label::kOrange, level(2, 3, 3), true});
  EXPECT_EQ(count(table, label::kOrange), 9u) << "the filled slice parts it";
  edit(table, FillEdit{label::kPink, level(3, 3, 3), true});
  EXPECT_EQ(count(table, label::kPink), 9u) << "there already";
  EXPECT_EQ(at(table, 5, 5, 5), label::kBlue);
}

TEST(TableEdit, GrowReachesAllWithinSoManyCells) {
  for (const int cells : {1, 2, 5}) {
    ColorTable table(5);
    at(table, 16, 16, 16) = label::kPink;
    edit(table, GrowEdit{label::kPink, cells});
    for (int u = 0; u < 32; ++u) {
      for (int v = 0; v < 32; ++v) {
        for (int y = 0; y < 32; ++y) {
          const int distance2 = (u - 16) * (u - 16) + (v - 16) * (v - 16) + (y - 16) * (y - 16);
          ASSERT_EQ(at(table, y, u, v) == label::kPink, distance2 <= cells * cells) << y << u << v;
        }
      }
    }
  }
}

TEST(TableEdit, GrowTakesOthersCellsOnlyWhenAsked) {
  ColorTable table(5);
  at(table, 16, 16, 16) = label::kPink;
  at(table, 17, 16, 16) = label::kBlue;
  ColorTable other = table;
  edit(table, GrowEdit{label::kPink, 1, Over::kClear});
  EXPECT_EQ(count(table, label::kPink), 6u);
  EXPECT_EQ(at(table, 17, 16, 16), label::kBlue);
  edit(other, GrowEdit{label::kPink, 1, Over::kAny});
  EXPECT_EQ(count(other, label::kPink), 7u);
}

TEST(TableEdit, ShrinkTakesTheRimButNotAtTheCubesFaces) {
  ColorTable table = with_box(label::kPink, 10, 16);
  edit(table, ShrinkEdit{label::kPink, 2});
  EXPECT_TRUE(table == with_box(label::kPink, 12, 14));
  ColorTable corner = with_box(label::kPink, 0, 4);
  edit(corner, ShrinkEdit{label::kPink, 1});
  EXPECT_TRUE(corner == with_box(label::kPink, 0, 3));
  edit(corner, ShrinkEdit{label::kPink, 16});
  EXPECT_EQ(count(corner, label::kPink), 0u);
}

TEST(TableEdit, SmoothDropsSpecksAndClosesHoles) {
  ColorTable table = with_box(label::kPink, 10, 16);
  at(table, 13, 13, 13) = label::kClear;
  at(table, 14, 14, 14) = label::kBlue;
  at(table, 25, 25, 25) = label::kPink;
  edit(table, SmoothEdit{label::kPink});
  EXPECT_EQ(at(table, 13, 13, 13), label::kPink);
  EXPECT_EQ(at(table, 14, 14, 14), label::kBlue) << "another's";
  EXPECT_EQ(at(table, 25, 25, 25), label::kClear);
  EXPECT_EQ(at(table, 10, 13, 13), label::kPink) << "a face stays";
  EXPECT_EQ(at(table, 10, 10, 10), label::kClear) << "a corner does not";
  ColorTable whole(5, std::vector<Label>(32768, label::kPink));
  EXPECT_TRUE(apply_edit(whole, SmoothEdit{label::kPink}).empty()) << "the cube's corners are no corners";
}

TEST(TableEdit, ReplaceAndRemoveTakeAllOfALabel) {
  ColorTable table = with_box(label::kPink, 10, 16);
  at(table, 0, 0, 0) = label::kPink;
  at(table, 1, 0, 0) = label::kBlue;
  edit(table, ReplaceEdit{label::kPink, label::kOrange});
  EXPECT_EQ(count(table, label::kOrange), 344u);
  edit(table, RemoveEdit{label::kOrange});
  EXPECT_EQ(count(table, label::kClear), table.labels.size() - 1);
}

TEST(TableEdit, ClustersReachBeyondTheirPixelsButNotToOutliers) {
  std::mt19937 random(1);
  std::normal_distribution<double> noise;
  ColorCluster cluster;
  for (int i = 0; i < 400; ++i) {
    // Brightness correlates with U, as in shades.
    const double y = 10 * noise(random);
    const auto byte = [](double value) { return static_cast<std::uint8_t>(value + 0.5); };
    cluster.pixels.push_back(
        {byte(120 + y + noise(random)), byte(140 + 0.5 * y + noise(random)), byte(200 + 2 * noise(random))});
  }
  const std::vector<Yuv> good = cluster.pixels;
  for (int i = 0; i < 60; ++i) cluster.pixels.push_back({30, 128, 128});
  ColorTable table(7);
  edit(table, AddClusterEdit{label::kPink, cluster});
  const auto within =
      std::count_if(good.begin(), good.end(), [&](const Yuv& c) { return table.of(c) == label::kPink; });
  EXPECT_GT(within, 388);
  EXPECT_EQ(table.of({30, 128, 128}), label::kClear);
  EXPECT_EQ(table.of({60, 134, 180}), label::kClear) << "between";
  EXPECT_EQ(table.of({140, 130, 200}), label::kClear) << "in the box, not in the ellipsoid";
  // An ellipsoid of 3 standard deviations: 10, 5 and 2 levels, and narrow across the correlation.
  EXPECT_GT(count(table, label::kPink), 200u);
  EXPECT_LT(count(table, label::kPink), 6000u);

  edit(table, RemoveClusterEdit{label::kBlue, cluster});
  EXPECT_GT(count(table, label::kPink), 200u);
  edit(table, RemoveClusterEdit{label::kPink, cluster});
  EXPECT_EQ(count(table, label::kPink), 0u);
}

TEST(TableEdit, OnePixelReachesItsCellsNeighbours) {
  for (const int bits : {5, 6, 7, 8}) {
    ColorTable table(bits);
    const int step = 256 >> bits;
    edit(table, AddClusterEdit{label::kPink, {{Yuv{100, 100, 100}}}});
    for (const int off : {-step, 0, step}) {
      const auto byte = static_cast<std::uint8_t>(100 + off);
      EXPECT_EQ(table.of({byte, 100, 100}), label::kPink) << bits;
      EXPECT_EQ(table.of({100, byte, 100}), label::kPink) << bits;
      EXPECT_EQ(table.of({100, 100, byte}), label::kPink) << bits;
    }
    EXPECT_EQ(table.of({100, 120, 100}), label::kClear) << bits;
  }
}

TEST(TableEdit, AClusterMayBeGivenAsWhatItIsLike) {
  ColorTable table(8);
  ColorCluster cluster;
  cluster.spread = ColorCluster::Spread{{128, 128, 128}, {{{100, 0, 0}, {0, 4, 0}, {0, 0, 4}}}};
  edit(table, AddClusterEdit{label::kPink, cluster, Over::kClear});
  EXPECT_EQ(table.of({128 + 29, 128, 128}), label::kPink);
  EXPECT_EQ(table.of({128 + 33, 128, 128}), label::kClear);
  EXPECT_EQ(table.of({128, 128 + 6, 128}), label::kPink);
  EXPECT_EQ(table.of({128, 128 + 9, 128}), label::kClear);
}

TEST(TableEdit, AWholeTableTakesTheOthersPlace) {
  ColorTable table = with_box(label::kPink, 3, 9), other = with_box(label::kBlue, 8, 20);
  EXPECT_TRUE(apply_edit(table, SetTableEdit{table, "again"}).empty());
  edit(table, SetTableEdit{other, "copied from camera 1"});
  EXPECT_TRUE(table == other);
  EXPECT_THROW(apply_edit(table, SetTableEdit{ColorTable(6), ""}), SettingsError);
}

TEST(TableEdit, SaysWhatItDid) {
  EXPECT_EQ(what_it_did(PaintEdit{label::kPink, {}, {}}), "painted pink");
  EXPECT_EQ(what_it_did(EraseEdit{{}, {}, Shape::kBall, {}}), "erased");
  EXPECT_EQ(what_it_did(EraseEdit{{}, {}, Shape::kBall, label::kBlue}), "erased blue");
  EXPECT_EQ(what_it_did(GrowEdit{label::kPink, 2}), "grew pink by 2 cells");
  EXPECT_EQ(what_it_did(ShrinkEdit{label::kPink, 1}), "shrank pink by 1 cell");
  EXPECT_EQ(what_it_did(ReplaceEdit{label::kPink, 17}), "replaced pink with label 17");
  EXPECT_EQ(what_it_did(WidenMarginsEdit{}), "widened the margins to carpet and floor");
  EXPECT_EQ(what_it_did(SetTableEdit{ColorTable(5), "imported robots.lut"}), "imported robots.lut");
}

// ---- JSON

TableEdit read(const std::string& json) {
  return read_table_edit(Json::parse(json), "/edits/0", LabelSet(std::vector<OwnLabel>{{10, "purple"}}, ""));
}

TEST(TableEditJson, ReadsEveryEdit) {
  const auto paint = std::get<PaintEdit>(
      read(R"({"op": "paint", "label": "pink", "shape": "box", "at": [131, 148, 216], "radius": [8, 4, 2],
               "over": "clear"})"));
  EXPECT_EQ(paint.label, label::kPink);
  EXPECT_EQ(paint.shape, Shape::kBox);
  EXPECT_EQ(paint.over, Over::kClear);
  EXPECT_THAT(paint.at, ElementsAre(131, 148, 216));
  EXPECT_THAT(paint.radius, ElementsAre(8, 4, 2));
  const auto short_paint = std::get<PaintEdit>(
      read(R"({"op": "paint", "label": "purple", "at": [1, 2, 3], "radius": [0, 0, 0]})"));
  EXPECT_EQ(short_paint.label, 10);
  EXPECT_EQ(short_paint.shape, Shape::kBall);
  EXPECT_EQ(short_paint.over, Over::kAny);
  const auto erase =
      std::get<EraseEdit>(read(R"({"op": "erase", "at": [1, 2, 3], "radius": [4, 5, 6], "label": "blue"})"));
  EXPECT_EQ(erase.only, label::kBlue);
  EXPECT_TRUE(
      std::get<FillEdit>(read(R"({"op": "fill", "label": "pink", "at": [1, 2, 3], "all_lumas": true})"))
          .all_lumas);
  EXPECT_EQ(std::get<GrowEdit>(read(R"({"op": "grow", "label": "pink", "cells": 16, "over": "any"})")).cells,
            16);
  EXPECT_EQ(std::get<ShrinkEdit>(read(R"({"op": "shrink", "label": "pink"})")).cells, 1);
  EXPECT_EQ(std::get<SmoothEdit>(read(R"({"op": "smooth", "label": "white"})")).label, label::kWhite);
  const auto replace = std::get<ReplaceEdit>(read(R"({"op": "replace", "from": "pink", "to": "clear"})"));
  EXPECT_EQ(replace.from, label::kPink);
  EXPECT_EQ(replace.to, label::kClear);
  EXPECT_EQ(std::get<RemoveEdit>(read(R"({"op": "remove", "label": "black"})")).label, label::kBlack);
  const auto add = std::get<AddClusterEdit>(
      read(R"({"op": "add_cluster", "label": "pink", "pixels": [[1, 2, 3], [4, 5, 6]]})"));
  EXPECT_THAT(add.cluster.pixels, ElementsAre(Yuv{1, 2, 3}, Yuv{4, 5, 6}));
  const auto remove = std::get<RemoveClusterEdit>(read(R"({"op": "remove_cluster", "mean": [1, 2, 3.5],
               "covariance": [[4, 1, 0], [1, 4, 0], [0, 0, 9]]})"));
  EXPECT_FALSE(remove.only);
  EXPECT_EQ(remove.cluster.spread->mean[2], 3.5);
  EXPECT_EQ(remove.cluster.spread->covariance[0][1], 1);
}

std::string error_of(const std::string& json) {
  try {
    read(json);
  } catch (const SettingsError& error) {
    return error.what();
  }
  return "no error";
}

TEST(TableEditJson, NamesWhatIsNotAllowed) {
  EXPECT_THAT(error_of("[]"), HasSubstr("/edits/0: [] is not allowed; expected an object"));
  EXPECT_THAT(error_of("{}"), HasSubstr("/edits/0/op: is missing"));
  EXPECT_THAT(error_of(R"({"op": "burn"})"),
              AllOf(HasSubstr("/edits/0/op: \"burn\""), HasSubstr("\"paint\"")));
  EXPECT_THAT(error_of(R"({"op": "set_table"})"), HasSubstr("/edits/0/op: \"set_table\" is not allowed"));
  EXPECT_THAT(error_of(R"({"op": "remove", "label": "lime"})"),
              AllOf(HasSubstr("/edits/0/label: \"lime\""), HasSubstr("black, purple")));
  EXPECT_THAT(error_of(R"({"op": "remove"})"), HasSubstr("/edits/0/label: is missing"));
  EXPECT_THAT(error_of(R"({"op": "remove", "label": "pink", "cells": 3})"),
              HasSubstr("/edits/0/cells: no such parameter; known: op, label"));
  EXPECT_THAT(error_of(R"({"op": "grow", "label": "pink", "cells": 17})"),
              HasSubstr("/edits/0/cells: 17 is not allowed; expected a whole number 1 .. 16"));
  const std::string paint = R"({"op": "paint", "label": "pink", "radius": [1, 1, 1], )";
  EXPECT_THAT(error_of(paint + R"("at": [1, 2]})"), HasSubstr("/edits/0/at: [1,2] is not allowed"));
  EXPECT_THAT(error_of(paint + R"("at": [1, 2, 256]})"), HasSubstr("/edits/0/at/2: 256 is not allowed"));
  EXPECT_THAT(error_of(paint + R"("at": [1, 2, 3], "shape": "star"})"),
              HasSubstr("/edits/0/shape: \"star\" is not allowed; expected one of \"ball\" \"box\""));
  EXPECT_THAT(error_of(paint + R"("at": [1, 2, 3], "over": 1})"), HasSubstr("/edits/0/over: 1"));
  EXPECT_THAT(error_of(R"({"op": "fill", "label": "pink", "at": [1, 2, 3], "all_lumas": 1})"),
              HasSubstr("/edits/0/all_lumas: 1 is not allowed; expected true or false"));
  const std::string add = R"({"op": "add_cluster", "label": "pink", )";
  EXPECT_THAT(error_of(add + R"("over": "any"})"), HasSubstr("expected pixels, or mean and covariance"));
  EXPECT_THAT(error_of(add + R"("pixels": [[1, 2, 3]], "mean": [1, 2, 3]})"),
              HasSubstr("expected pixels, or"));
  EXPECT_THAT(error_of(add + R"("pixels": []})"), HasSubstr("/edits/0/pixels: [] is not allowed"));
  EXPECT_THAT(error_of(add + R"("pixels": [[1, 2, 3], [1, 2, "x"]]})"),
              HasSubstr("/edits/0/pixels/1/2: \"x\""));
  EXPECT_THAT(error_of(add + R"("mean": [1, 2, 3], "covariance": [[1, 0, 0], [0, -1, 0], [0, 0, 1]]})"),
              HasSubstr("expected a covariance"));
  EXPECT_THAT(error_of(add + R"("mean": [1, 2, 3], "covariance": [[1, 0, 0], [0, 1, 0]]})"),
              HasSubstr("/edits/0/covariance"));
}

// ---- statistics

TEST(TableStatistics, CountsCellsAndWhereColoursMeet) {
  ColorTable table(5);
  for (int y = 0; y < 32; ++y) at(table, y, 10, 10) = y < 20 ? label::kOrange : label::kYellow;
  at(table, 5, 11, 10) = label::kField;  // not a colour
  at(table, 6, 10, 11) = label::kYellow;
  at(table, 0, 0, 0) = 12;
  at(table, 31, 31, 31) = label::kPink;
  const TableStatistics found = table_statistics(table);
  EXPECT_EQ(found.cells[label::kOrange], 20u);
  EXPECT_EQ(found.cells[label::kYellow], 13u);
  EXPECT_EQ(found.cells[12], 1u);
  ASSERT_EQ(found.conflicts.size(), 1u);
  EXPECT_EQ(found.conflicts[0].a, label::kOrange);
  EXPECT_EQ(found.conflicts[0].b, label::kYellow);
  EXPECT_EQ(found.conflicts[0].cells, 4u) << "two of either";
  EXPECT_THAT(found.conflicts[0].places, ElementsAre(Yuv{6 * 8 + 4, 84, 84}, Yuv{19 * 8 + 4, 84, 84}));
  EXPECT_EQ(table_statistics(table, 1).conflicts[0].places.size(), 1u);
}

}  // namespace
}  // namespace sslv::table_edit_test
