// SPDX-License-Identifier: Apache-2.0
#include "colors/swapped_labels.h"

#include "base/json.h"
#include "support/paths.h"

#include <fstream>
#include <map>

#include <gmock/gmock.h>

namespace sslv::swapped_labels_test {
namespace {

using ::testing::IsEmpty;
using ::testing::UnorderedElementsAre;

/// The demo's colour classes, with labels replaced as in `other` and all hues rotated by `by_deg`.
ColorSettings demo_colors(const std::map<std::string, std::string>& other = {}, int by_deg = 0) {
  const Json demo = Json::parse(std::ifstream(source_path("/config/demo.json")));
  ColorSettings out;
  for (const Json& json : demo["cameras"][0]["colors"]["classes"]) {
    const auto name = json["label"].get<std::string>();
    const auto found = other.find(name);
    ColorClass one;
    one.label = found == other.end() ? name : found->second;
    const auto turned = [&](const Json& deg) { return (deg.get<int>() + by_deg + 360) % 360; };
    one.hue_deg = {turned(json["hue_deg"][0]), turned(json["hue_deg"][1])};
    if (one.hue_deg[1] < one.hue_deg[0]) one.hue_deg[1] += 360;
    one.saturation_pct = {json["saturation_pct"][0], json["saturation_pct"][1]};
    one.luma = {json["luma"][0], json["luma"][1]};
    out.classes.push_back(one);
  }
  return out;
}

std::vector<std::string> swapped(const ColorSettings& colors) {
  std::vector<std::string> out;
  for (const SwappedLabel& one : swapped_labels(make_color_table(colors, "")))
    out.push_back(std::string(LabelSet::built_in().name(one.label)) + " is " +
                  std::string(LabelSet::built_in().name(one.looks_like)));
  return out;
}

TEST(SwappedLabels, AreNoneInACorrectTableUnderAnyLamp) {
  for (const int by_deg : {-40, -20, 0, 20, 40})
    EXPECT_THAT(swapped(demo_colors({}, by_deg)), IsEmpty()) << by_deg;
  EXPECT_THAT(swapped({}), IsEmpty()) << "an empty one";
}

TEST(SwappedLabels, AreLabelsWithAnotherLabelsHue) {
  EXPECT_THAT(swapped(demo_colors({{"pink", "green"}, {"green", "pink"}})),
              UnorderedElementsAre("pink is green", "green is pink"));
  EXPECT_THAT(swapped(demo_colors({{"blue", "yellow"}, {"yellow", "blue"}})),
              UnorderedElementsAre("blue is yellow", "yellow is blue"));
  EXPECT_THAT(swapped(demo_colors({{"blue", "pink"}, {"pink", "blue"}})),
              UnorderedElementsAre("blue is pink", "pink is blue"));
}

}  // namespace
}  // namespace sslv::swapped_labels_test
