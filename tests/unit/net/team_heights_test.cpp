// SPDX-License-Identifier: Apache-2.0
#include "net/team_heights.h"

#include <string>

#include <gmock/gmock.h>

namespace sslv::team_heights_test {
namespace {

using testing::Optional;

struct Known {
  const char* name;
  double height_mm;
};

class TeamHeights : public testing::TestWithParam<Known> {};

TEST_P(TeamHeights, IsTheTeams) {
  EXPECT_THAT(team_height_mm(GetParam().name), Optional(GetParam().height_mm)) << GetParam().name;
}

INSTANTIATE_TEST_SUITE_P(
    Names, TeamHeights,
    testing::Values(Known{"MRL", 150}, Known{"ER-Force", 148}, Known{"Immortals", 150},
                    Known{"TurtleRabbit", 150}, Known{"UMass Minutebots", 150}, Known{"AIS", 150},
                    Known{"RoboJackets", 150}, Known{"DelftMercurians", 150}, Known{"RobôCIn-B", 150},
                    Known{"NAMeC", 149}, Known{"RoboFEI", 149}, Known{"RoboIME", 149},
                    Known{"ZJUNlict", 148.725}, Known{"KIKS", 148}, Known{"MCT Susano Logics", 148},
                    Known{"GreenTea", 148}, Known{"N.R.G", 147}, Known{"OP-AmP", 147},
                    Known{"RoboTeam Twente", 145}, Known{"UBC Thunderbots", 144}, Known{"RobôCIn", 144},
                    Known{"TIGERs Mannheim", 143}, Known{"ULtron", 143}, Known{"ITAndroids", 141},
                    Known{"CMμs", 140}, Known{"NEUIslanders", 140}, Known{"luhbots", 138},
                    Known{"RoboDragons", 125}, Known{"The Bots", 110}, Known{"ibis", 90},
                    Known{"Robocup Junior SSL Team", 180}));

INSTANTIATE_TEST_SUITE_P(OtherSpellings, TeamHeights,
                         testing::Values(Known{"tigers MANNHEIM", 143}, Known{" TIGERsMannheim ", 143},
                                         Known{"ER Force", 148}, Known{"ERForce", 148}, Known{"NRG", 147},
                                         Known{"OP AMP", 147}, Known{"CMus", 140}, Known{"CM\u00B5s", 140},
                                         Known{"CM\u03BCs", 140}, Known{"cm\u039Cs", 140},
                                         Known{"RoboCin", 144}, Known{"Rob\u00F4CIn", 144},
                                         Known{"Robo\u0302CIn", 144}, Known{"ROBÔCIN", 144},
                                         Known{"RoboCIn B", 150}, Known{"\uFF2D\uFF32\uFF2C", 150}));

TEST(TeamHeight, IsUnknownForUnknownNames) {
  for (const char* name : {"", " ", "-", "TIGERs", "MRL 2", "\xFF\xFE", "MRL\xC3"}) {
    EXPECT_EQ(team_height_mm(name), std::nullopt) << name;
  }
  EXPECT_EQ(team_height_mm(std::string(60'000, 'M')), std::nullopt);
}

TEST(TeamHeight, NamesMatchDespiteDifferentSpelling) {
  EXPECT_TRUE(is_same_team("Nobody Knows Us", "nobody-knows us"));
  EXPECT_TRUE(is_same_team("---", "---"));
  EXPECT_FALSE(is_same_team("---", "!!!"));
  EXPECT_FALSE(is_same_team("Nobody", ""));
}

}  // namespace
}  // namespace sslv::team_heights_test
