// SPDX-License-Identifier: Apache-2.0
#include "colors/table_history.h"

#include "colors/table_edit.h"

#include <random>

#include <gmock/gmock.h>

namespace sslv::table_history_test {
namespace {

TableEdit random_edit(std::mt19937& random) {
  const auto level = [&] { return static_cast<int>(random() % 256); };
  const Levels at{level(), level(), level()};
  const Levels radius{level() / 4, level() / 4, level() / 4};
  const auto label = static_cast<Label>(random() % 6), other = static_cast<Label>(random() % 12);
  switch (random() % 8) {
    case 0: return EraseEdit{at, radius, Shape::kBox, {}};
    case 1: return FillEdit{label, at, false};
    case 2: return GrowEdit{label, 1 + level() % 3, Over::kAny};
    case 3: return ShrinkEdit{label, 1 + level() % 3};
    case 4: return SmoothEdit{label};
    case 5: return ReplaceEdit{label, other};
    default: return PaintEdit{label, at, radius};
  }
}

TEST(TableHistory, UndoAndRedoRestoreEveryState) {
  std::mt19937 random(1);
  ColorTable table(5);
  for (auto& print : table.prints) print = PrintColor{{3000, 3000, 4000}, 500};
  TableHistory history;
  std::vector<ColorTable> states{table};  // after each done step, then after each redoable one
  std::size_t at = 0;
  for (int i = 0; i < 400; ++i) {
    const ColorTable before = table;
    std::optional<std::vector<CellRun>> changed;
    switch (random() % 4) {
      case 0: {
        changed = history.undo(table);
        EXPECT_EQ(changed.has_value(), at > 0);
        at -= changed ? 1 : 0;
        break;
      }
      case 1: {
        changed = history.redo(table);
        EXPECT_EQ(changed.has_value(), at + 1 < states.size());
        at += changed ? 1 : 0;
        break;
      }
      default: {
        changed = apply_edit(table, random_edit(random));
        if (changed->empty()) break;
        history.add({"edit", "me", i, *changed, before.prints, table.prints});
        states.resize(++at);
        states.push_back(table);
        break;
      }
    }
    ASSERT_TRUE(table == states[at]) << i;
    if (changed) {
      // The reported runs are the actual changes.
      ColorTable again = before;
      for (const CellRun& run : *changed)
        std::fill_n(again.labels.begin() + run.begin, run.length, run.after);
      ASSERT_TRUE(again.labels == table.labels) << i;
    }
    ASSERT_EQ(history.done().size(), at);
    ASSERT_EQ(history.can_redo(), at + 1 < states.size());
  }
}

TEST(TableHistory, UndoKeepsCellsThatChangedMeanwhile) {
  ColorTable table(5);
  TableHistory history;
  history.add({"painted pink", "me", 1, apply_edit(table, PaintEdit{label::kPink, {0, 0, 0}, {40, 0, 0}})});
  table.labels[2] = label::kBlue;
  EXPECT_THAT(*history.undo(table), ::testing::ElementsAre(CellRun{0, 2, label::kPink, label::kClear},
                                                           CellRun{3, 3, label::kPink, label::kClear}));
  EXPECT_EQ(table.labels[2], label::kBlue);
}

TEST(TableHistory, ANewStepClearsRedo) {
  ColorTable table(5);
  TableHistory history;
  history.add({"one", "me", 1, {{0, 1, 0, 1}}});
  history.undo(table);
  EXPECT_EQ(history.undone().back().what, "one");
  history.add({"two", "me", 2, {{1, 1, 0, 1}}});
  EXPECT_FALSE(history.can_redo());
  EXPECT_FALSE(history.redo(table));
}

TEST(TableHistory, ForgetsTheOldestBeyondItsBounds) {
  TableHistory history;
  for (int i = 0; i < 700; ++i) history.add({std::to_string(i), "me", i, {{0, 1, 0, 1}}});
  EXPECT_EQ(history.done().size(), TableHistory::kMaxSteps);
  EXPECT_EQ(history.done().front().what, "200");

  const std::vector<CellRun> large(1'000'000, {0, 1, 0, 1});
  for (int i = 0; i < 4; ++i) history.add({std::to_string(i), "me", i, large});
  EXPECT_EQ(history.done().size(), TableHistory::kMaxBytes / (large.size() * sizeof(CellRun)));
  history.clear();
  EXPECT_FALSE(history.can_undo());
}

}  // namespace
}  // namespace sslv::table_history_test
