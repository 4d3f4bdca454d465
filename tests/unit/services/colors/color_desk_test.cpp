// SPDX-License-Identifier: Apache-2.0
#include "services/colors/color_desk.h"

#include "settings/store.h"

#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sslv::color_desk_test {
namespace {

using testing::ElementsAre;

class ColorDeskTest : public testing::Test {
 protected:
  ColorDeskTest() { desk_.take(std::make_shared<const Lut>()); }

  TableEdit paint(Label label, int y) const {
    return PaintEdit{label, {y, 100, 100}, {1, 1, 1}, Shape::kBox, Over::kAny};
  }
  void do_edit(const TableEdit& edit, const std::string& what) {
    desk_.change(desk_.preview(std::vector{edit}), what, "me", save_);
  }
  Label at(int y) const { return desk_.table()->of_yuv(static_cast<std::uint8_t>(y), 100, 100); }

  std::vector<std::string> saved_;
  bool disk_is_full_ = false;
  ColorDesk::Save save_ = [this](const std::shared_ptr<const Lut>& lut, const std::string& what) {
    if (disk_is_full_) throw StorageError("the disk is full");
    in_force_ = lut;
    saved_.push_back(what);
  };
  std::shared_ptr<const Lut> in_force_;
  ColorDesk desk_;
};

TEST_F(ColorDeskTest, EditsAreSavedUndoneAndDoneAgain) {
  do_edit(paint(label::kPink, 50), "painted pink");
  do_edit(paint(label::kBlue, 90), "painted blue");
  EXPECT_EQ(at(50), label::kPink);
  EXPECT_EQ(at(90), label::kBlue);
  EXPECT_EQ(in_force_, desk_.table());

  EXPECT_TRUE(desk_.undo(save_));
  EXPECT_EQ(at(90), label::kClear);
  EXPECT_EQ(at(50), label::kPink);
  EXPECT_EQ(in_force_, desk_.table());
  EXPECT_TRUE(desk_.redo(save_));
  EXPECT_EQ(at(90), label::kBlue);
  EXPECT_FALSE(desk_.redo(save_));
  EXPECT_THAT(saved_, ElementsAre("painted pink", "painted blue", "undone: painted blue", "painted blue"));
}

TEST_F(ColorDeskTest, PrintsAreDroppedWhenTheirLabelGrows) {
  ColorTable learnt;
  learnt.labels[7] = label::kPink;
  learnt.prints[label::kPink] = PrintColor{{4500, 2000, 3500}, 900};
  desk_.replace(std::make_shared<const Lut>(learnt), "learnt", "me", save_);
  EXPECT_EQ(in_force_->prints(), learnt.prints);
  do_edit(EraseEdit{{50, 100, 100}, {9, 9, 9}, Shape::kBall, {}}, "erased");
  EXPECT_EQ(in_force_->prints(), learnt.prints);
  do_edit(paint(label::kPink, 50), "painted pink");
  EXPECT_EQ(in_force_->prints(), Prints{}) << "its cells tell more now";
  EXPECT_TRUE(desk_.undo(save_));
  EXPECT_EQ(in_force_->prints(), learnt.prints);
  EXPECT_TRUE(desk_.redo(save_));
  EXPECT_EQ(in_force_->prints(), Prints{});
  EXPECT_TRUE(desk_.undo(save_));
  EXPECT_TRUE(desk_.undo(save_));
  EXPECT_EQ(in_force_->prints(), Prints{}) << "of before it was learnt";
}

TEST_F(ColorDeskTest, APreviewChangesNothing) {
  const auto before = desk_.table();
  const auto revision = desk_.revision();
  const TableChange change = desk_.preview(std::vector{paint(label::kPink, 50)});
  EXPECT_GT(change.cells.size(), 0U);
  EXPECT_EQ(desk_.table(), before);
  EXPECT_EQ(desk_.revision(), revision);
  EXPECT_THAT(cells_before(change.cells), ElementsAre(testing::Pair(label::kClear, testing::Gt(0U))));
}

TEST_F(ColorDeskTest, CountsWhatClustersLeaveToASurface) {
  ColorCluster cluster{{{60, 100, 100}}, {}};
  AddClusterEdit edit{label::kPink, cluster, Over::kAny};
  const std::size_t all = cells_before(desk_.preview(std::vector<TableEdit>{edit}).cells).front().second;
  edit.stays_clear = [](Yuv color) { return color.y < 60; };
  const TableChange change = desk_.preview(std::vector<TableEdit>{edit});
  EXPECT_GT(change.left_clear, 0U);
  EXPECT_EQ(cells_before(change.cells).front().second, all - change.left_clear);
  EXPECT_EQ(desk_.preview(std::vector<TableEdit>{edit, edit}).left_clear, 2 * change.left_clear);
}

TEST_F(ColorDeskTest, AFailedSaveChangesNothing) {
  do_edit(paint(label::kPink, 50), "painted pink");
  const auto before = desk_.table();
  disk_is_full_ = true;
  EXPECT_THROW(do_edit(paint(label::kBlue, 50), "painted blue"), StorageError);
  EXPECT_THROW(desk_.undo(save_), StorageError);
  EXPECT_EQ(desk_.table(), before);
  EXPECT_EQ(at(50), label::kPink);
  disk_is_full_ = false;
  EXPECT_TRUE(desk_.undo(save_)) << "it can still be undone";
  EXPECT_EQ(at(50), label::kClear);
  disk_is_full_ = true;
  EXPECT_THROW(desk_.redo(save_), StorageError);
  disk_is_full_ = false;
  EXPECT_TRUE(desk_.redo(save_));
  EXPECT_EQ(at(50), label::kPink);
}

TEST_F(ColorDeskTest, SeveralEditsAreOneStep) {
  desk_.change(
      desk_.preview(std::vector{paint(label::kPink, 50), paint(label::kBlue, 50), paint(label::kPink, 90)}),
      "painted", "me", save_);
  EXPECT_EQ(at(50), label::kBlue);
  EXPECT_EQ(desk_.history().done().size(), 1U);
  desk_.undo(save_);
  EXPECT_EQ(at(50), label::kClear);
  EXPECT_EQ(at(90), label::kClear);
}

TEST_F(ColorDeskTest, AnotherTableOnTheDeskHasNoHistory) {
  do_edit(paint(label::kPink, 50), "painted pink");
  // A table with the same content keeps the history.
  desk_.take(std::make_shared<const Lut>(desk_.table()->color_table()));
  EXPECT_TRUE(desk_.history().can_undo());
  const auto revision = desk_.revision();
  desk_.take(std::make_shared<const Lut>());
  EXPECT_FALSE(desk_.history().can_undo());
  EXPECT_GT(desk_.revision(), revision);
  EXPECT_FALSE(desk_.undo(save_));
}

TEST_F(ColorDeskTest, AWholeTableIsAStepOfItsOwn) {
  do_edit(paint(label::kPink, 50), "painted pink");
  desk_.replace(std::make_shared<const Lut>(), "imported", "me", save_);
  EXPECT_EQ(at(50), label::kClear);
  desk_.undo(save_);
  EXPECT_EQ(at(50), label::kPink);
  // With another bit depth, the cells are different ones.
  desk_.replace(std::make_shared<const Lut>(ColorTable(6)), "imported", "me", save_);
  EXPECT_FALSE(desk_.history().can_undo());
  EXPECT_EQ(desk_.table()->color_bits(), 6);
}

TEST_F(ColorDeskTest, CountsLabelsAndWhereTheyTouch) {
  EXPECT_EQ(desk_.statistics().cells[label::kClear], Lut::kEntries);
  do_edit(PaintEdit{label::kPink, {50, 100, 100}, {3, 3, 3}, Shape::kBox, Over::kAny}, "pink");
  do_edit(PaintEdit{label::kOrange, {56, 100, 100}, {3, 3, 3}, Shape::kBox, Over::kAny}, "orange");
  const auto& statistics = desk_.statistics();
  EXPECT_GT(statistics.cells[label::kPink], 0U);
  ASSERT_EQ(statistics.conflicts.size(), 1U);
  EXPECT_EQ(statistics.conflicts[0].a, label::kOrange);
  EXPECT_EQ(statistics.conflicts[0].b, label::kPink);
}

}  // namespace
}  // namespace sslv::color_desk_test
