// SPDX-License-Identifier: Apache-2.0
#include "kit/stamp.h"

#include "base/sha256.h"

#include <fstream>
#include <iterator>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace sslv::stamp_test {
namespace {

// A stamp does not cover names, units and meanings, so this test requires a decision on every change to one
// of the kit's headers.
TEST(Stamp, KitsVersionFollowsItsHeaders) {
  std::istringstream names(SSLV_KIT_HEADERS);
  std::string all, name;
  while (std::getline(names, name, ':')) {
    std::ifstream in(std::string(SSLV_SOURCES) + "/daemon/" + name);
    ASSERT_TRUE(in) << name;
    all.append(std::istreambuf_iterator<char>(in), {});
  }
  ASSERT_GT(all.size(), 10'000U);
  EXPECT_EQ(sha256_of(all), "d76d7de3536df621edb17eefdf71939ac6ac97d92c8e041f18f022b918029a21")
      << "A header of the stage kit has changed. If a library that was built before could now be wrong "
         "although all "
         "types have the same layout, raise kKitVersion (kit/stamp.h). Then write the new sum here.";
}

struct Two {
  double a;
  int b;
};
struct OtherOrder {
  int b;
  double a;
};
struct OtherType {
  double a;
  unsigned b;
};
struct Nested {
  std::vector<Two> list;
};
struct NestedOther {
  std::vector<OtherType> list;
};

TEST(Layout, TellsStructsApart) {
  EXPECT_EQ(layout_of<Two>(), layout_of<Two>());
  EXPECT_NE(layout_of<Two>(), layout_of<OtherOrder>());
  EXPECT_NE(layout_of<Two>(), layout_of<OtherType>());
  EXPECT_NE(layout_of<Nested>(), layout_of<NestedOther>()) << "as far down as it goes";
  EXPECT_NE((layout_of<std::array<int, 3>>()), (layout_of<std::array<int, 4>>()));
}

}  // namespace
}  // namespace sslv::stamp_test
