// SPDX-License-Identifier: Apache-2.0
#include "colors/pixels_json.h"

#include "base/base64.h"

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

namespace sslv {
namespace {

constexpr std::size_t kMaxCells = 16'384;  // larger blocks are sent without the cells' colours and labels

template <class Numbers>
Json array_json(const Numbers& numbers) {
  Json out = Json::array();
  for (const auto& number : numbers) out.push_back(number);
  return out;
}

}  // namespace

Json pixels_json(const PixelBlock& block, const PixelFigures& figures, std::uint32_t frame_number,
                 const LabelSet& labels) {
  std::vector<std::pair<std::size_t, Label>> counts;
  for (std::size_t i = 0; i < figures.cells.size(); ++i) {
    if (figures.cells[i] > 0) counts.emplace_back(figures.cells[i], static_cast<Label>(i));
  }
  std::stable_sort(counts.begin(), counts.end(),
                   [](const auto& a, const auto& b) { return a.first > b.first; });
  Json shares = Json::array();
  for (const auto& [count, label] : counts) {
    shares.push_back({{"label", labels.name(label)},
                      {"share", static_cast<double>(count) / static_cast<double>(figures.count)}});
  }
  Json yuv, cell_labels;
  if (!block.colors.empty() && block.colors.size() <= kMaxCells) {
    std::vector<std::uint8_t> bytes;
    for (const Yuv c : block.colors) bytes.insert(bytes.end(), {c.y, c.u, c.v});
    yuv = to_base64(bytes);
    cell_labels = to_base64(block.labels);
  }
  return {{"frame", frame_number},
          {"x", block.box.x},
          {"y", block.box.y},
          {"width", block.box.width},
          {"height", block.box.height},
          {"cell_px", block.cell_px},
          {"columns", block.columns},
          {"rows", block.rows},
          {"count", figures.count},
          {"yuv", std::move(yuv)},
          {"labels", std::move(cell_labels)},
          {"mean", array_json(figures.mean)},
          {"spread", array_json(figures.spread)},
          {"shares", std::move(shares)},
          {"histogram",
           {{"y", array_json(figures.histogram[0])},
            {"u", array_json(figures.histogram[1])},
            {"v", array_json(figures.histogram[2])}}}};
}

}  // namespace sslv
