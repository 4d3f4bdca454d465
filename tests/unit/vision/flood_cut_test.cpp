// SPDX-License-Identifier: Apache-2.0
#include "vision/flood_cut.h"

#include "vision/find_regions.h"
#include "vision/find_runs.h"

#include <algorithm>
#include <array>
#include <map>
#include <random>
#include <tuple>
#include <utility>
#include <vector>

#include <gmock/gmock.h>

namespace sslv::flood_cut_test {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr int kBlock = FloodCut::kBlockCells;

LabelImage clear_picture(int width, int height) {
  return {width, height, 1, std::vector<Label>(static_cast<std::size_t>(width * height), label::kClear)};
}

RunList runs_of(const LabelImage& picture, int max_runs = 65'536) {
  RunList runs;
  FindRuns find_runs;
  FindRuns::Params params;
  params.max_runs = max_runs;
  find_runs.process(params, picture, runs);
  return runs;
}

std::vector<std::tuple<int, int, int, int>> as_tuples(const std::vector<Run>& runs) {
  std::vector<std::tuple<int, int, int, int>> out;
  for (const Run& run : runs) out.emplace_back(run.y, run.x_begin, run.x_end, run.label);
  return out;
}

void fill(LabelImage& picture, int x, int y, int width, int height, Label label) {
  for (int i = y; i < y + height; ++i) std::fill_n(picture.row(i) + x, width, label);
}

/// Labels every second cell of a block's first `rows` rows.
void flood(LabelImage& picture, int across, int down, int rows, Label label) {
  for (int y = down * kBlock; y < down * kBlock + rows; ++y) {
    for (int x = across * kBlock; x < (across + 1) * kBlock; x += 2) picture.row(y)[x] = label;
  }
}

TEST(FloodCut, FindsOtherRegionsBesideAFlood) {
  LabelImage picture = clear_picture(4 * kBlock, 3 * kBlock);
  flood(picture, 1, 1, kBlock, label::kGreen);
  fill(picture, kBlock + 20, kBlock + 20, 9, 9, label::kPink);
  fill(picture, 2 * kBlock + 20, 20, 9, 9, label::kGreen);
  fill(picture, 20, 2 * kBlock + 20, 9, 9, label::kGreen);
  const RunList runs = runs_of(picture);
  RegionList regions;
  FindRegions().process({}, runs, regions);
  EXPECT_EQ(regions.of(label::kGreen).size(), 2U);
  ASSERT_EQ(regions.of(label::kPink).size(), 1U);
  EXPECT_EQ(regions.of(label::kPink)[0].area_px, 81U);
  EXPECT_EQ(runs.flood.blocks, 1);
  EXPECT_EQ(runs.flood.label, label::kGreen);
  EXPECT_EQ(flood_text(runs.flood, "green"), "green floods the image between (64, 64) and (127, 127) px");
}

TEST(FloodCut, KeepsDenseBlocksBelowTheLimit) {
  LabelImage picture = clear_picture(2 * kBlock, kBlock);
  flood(picture, 0, 0, FloodCut::kMaxOfLabel / (kBlock / 2), label::kGreen);
  RunList runs = runs_of(picture);
  EXPECT_EQ(runs.runs.size(), static_cast<std::size_t>(FloodCut::kMaxOfLabel));
  EXPECT_EQ(runs.flood.blocks, 0);
  picture.row(kBlock - 1)[0] = label::kGreen;
  runs = runs_of(picture);
  EXPECT_THAT(as_tuples(runs.runs), IsEmpty());
  EXPECT_EQ(runs.flood.blocks, 1);
}

TEST(FloodCut, LeavesDotsAmongSpeckle) {
  // As in dim light: three labels, together in a tenth of a block's cells.
  LabelImage picture = clear_picture(kBlock, kBlock);
  std::mt19937 random(1);
  for (int y = 0; y < kBlock; ++y) {
    for (int x = 0; x < kBlock; ++x) {
      const auto one = random() % 30;
      if (one < 3) picture.row(y)[x] = std::array{label::kGreen, label::kBlue, label::kYellow}[one];
    }
  }
  fill(picture, 20, 20, 9, 9, label::kPink);
  const RunList runs = runs_of(picture);
  EXPECT_EQ(runs.flood.blocks, 0);
  EXPECT_GT(runs.runs.size(), 300U);
}

TEST(FloodCut, CutsAllLabelsInABlockOfNoise) {
  LabelImage picture = clear_picture(2 * kBlock, kBlock);
  std::mt19937 random(1);
  for (int y = 0; y < kBlock; ++y) {
    for (int x = 0; x < kBlock; ++x) picture.row(y)[x] = static_cast<Label>(random() % 10);
  }
  fill(picture, kBlock + 9, 9, 5, 1, label::kOrange);
  const RunList runs = runs_of(picture);
  EXPECT_THAT(as_tuples(runs.runs), ElementsAre(std::tuple(9, kBlock + 9, kBlock + 14, label::kOrange)));
  EXPECT_EQ(flood_text(runs.flood, "clear"), "every colour floods the image between (0, 0) and (63, 63) px");
}

TEST(FloodCut, CutsARunWhereItReachesIntoTheFlood) {
  LabelImage picture = clear_picture(3 * kBlock, kBlock);
  flood(picture, 1, 0, kBlock - 1, label::kGreen);
  fill(picture, 10, kBlock - 1, 3 * kBlock - 20, 1, label::kGreen);
  const RunList runs = runs_of(picture);
  EXPECT_THAT(as_tuples(runs.runs),
              ElementsAre(std::tuple(kBlock - 1, 10, kBlock, label::kGreen),
                          std::tuple(kBlock - 1, 2 * kBlock, 3 * kBlock - 10, label::kGreen)));
}

TEST(FloodCut, CutsTheFullestBlocksWhenAllTogetherAreTooMany) {
  LabelImage picture = clear_picture(3 * kBlock, kBlock);
  flood(picture, 0, 0, 5, label::kGreen);   // 160 runs
  flood(picture, 1, 0, 7, label::kYellow);  // 224
  flood(picture, 2, 0, 6, label::kGreen);   // 192
  EXPECT_EQ(runs_of(picture, 576).runs.size(), 576U);
  const RunList runs = runs_of(picture, 400);
  EXPECT_EQ(runs.runs.size(), 352U);
  EXPECT_EQ(runs.flood.label, label::kYellow);
  EXPECT_EQ(runs_of(picture, 351).runs.size(), 160U);
}

/// Reference: the definition, implemented directly.
std::vector<std::tuple<int, int, int, int>> plainly(LabelImage picture, std::size_t max_runs) {
  std::map<std::pair<int, Label>, int> counts;
  const int across = (picture.width + kBlock - 1) / kBlock;
  const auto block_of = [&](int x, int y) { return y / kBlock * across + x / kBlock; };
  for (int y = 0; y < picture.height; ++y) {
    for (int x = 0; x < picture.width; ++x) {
      const Label label = picture.row(y)[x];
      if (label != label::kClear && (x % kBlock == 0 || picture.row(y)[x - 1] != label))
        ++counts[{block_of(x, y), label}];
    }
  }
  std::map<int, int> sums, noise;
  for (const auto& [key, count] : counts) {
    sums[key.first] += std::min(count, FloodCut::kMaxOfLabel + 1);
    noise[key.first] += std::min(count, FloodCut::kMaxCounted);
  }
  const auto all_runs = [&] {
    std::vector<std::tuple<int, int, int, int>> runs;
    for (int y = 0; y < picture.height; ++y) {
      for (int x = 0; x < picture.width;) {
        const int begin = x;
        const Label label = picture.row(y)[x];
        while (x < picture.width && picture.row(y)[x] == label) ++x;
        if (label != label::kClear) runs.emplace_back(y, begin, x, label);
      }
    }
    return runs;
  };
  const auto cut = [&](auto is_cut) {
    for (int y = 0; y < picture.height; ++y) {
      for (int x = 0; x < picture.width; ++x) {
        Label& label = picture.row(y)[x];
        if (label != label::kClear && is_cut(block_of(x, y), label)) label = label::kClear;
      }
    }
  };
  const auto floods = [&](int block, Label label) {
    return counts[{block, label}] > FloodCut::kMaxOfLabel || sums[block] > FloodCut::kMaxOfAll ||
           noise[block] > FloodCut::kMaxNoise;
  };
  cut(floods);
  auto runs = all_runs();
  if (runs.size() <= max_runs) return runs;
  int most = FloodCut::kMaxOfLabel;
  for (; most > 0; --most) {
    std::size_t sum = 0;
    for (const auto& [key, count] : counts) {
      if (count <= most && !floods(key.first, key.second)) sum += static_cast<std::size_t>(count);
    }
    if (sum <= max_runs) break;
  }
  cut([&](int block, Label label) { return counts[{block, label}] > most; });
  return all_runs();
}

TEST(FloodCut, IsAsDefined) {
  std::mt19937 random(5);
  FindRuns find_runs;
  RunList runs;
  int flooded = 0;
  for (int i = 0; i < 300; ++i) {
    LabelImage picture =
        clear_picture(1 + static_cast<int>(random() % 400), 1 + static_cast<int>(random() % 200));
    // Each part has its own labels, at its own density.
    for (int part = 0; part < 8; ++part) {
      const int x = static_cast<int>(random() % static_cast<unsigned>(picture.width));
      const int y = static_cast<int>(random() % static_cast<unsigned>(picture.height));
      const int right = std::min(picture.width, x + static_cast<int>(random() % 300));
      const int bottom = std::min(picture.height, y + static_cast<int>(random() % 150));
      const std::mt19937::result_type rarity = 1U << random() % 7, labels = 1 + random() % 6,
                                      first = random() % 26;
      const bool solid = random() % 4 == 0;
      for (int py = y; py < bottom; ++py) {
        for (int px = x; px < right; ++px) {
          if (solid || random() % rarity == 0)
            picture.row(py)[px] = static_cast<Label>(first + random() % labels);
        }
      }
    }
    FindRuns::Params params;
    params.max_runs = i % 3 == 0 ? 1 + static_cast<int>(random() % 3000) : 65'536;
    find_runs.process(params, picture, runs);
    flooded += runs.flood.blocks > 0 ? 1 : 0;
    ASSERT_EQ(as_tuples(runs.runs), plainly(picture, static_cast<std::size_t>(params.max_runs))) << i;
  }
  EXPECT_GT(flooded, 100);
  EXPECT_LT(flooded, 290);
}

}  // namespace
}  // namespace sslv::flood_cut_test
