// SPDX-License-Identifier: Apache-2.0
#include "services/field/running_field.h"

#include <gtest/gtest.h>

namespace sslv::running_field_test {
namespace {

TEST(CountOverRestarts, NeverFalls) {
  CountOverRestarts count;
  for (const std::uint64_t now : {0U, 2U, 2U, 5U}) count.add(now);
  EXPECT_EQ(count.total(), 5U);
  count.add(0);  // a new stack
  EXPECT_EQ(count.total(), 5U);
  for (const std::uint64_t now : {1U, 3U}) count.add(now);
  EXPECT_EQ(count.total(), 8U);
}

}  // namespace
}  // namespace sslv::running_field_test
