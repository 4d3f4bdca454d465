// SPDX-License-Identifier: Apache-2.0
#include "web/http.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sslv {
namespace {

TEST(HttpTest, AnOriginMustBeTheHost) {
  EXPECT_TRUE(is_same_origin("", "field-pc:8090"));
  EXPECT_TRUE(is_same_origin("http://Field-PC:8090", "field-pc:8090"));
  for (const char* origin : {"http://field-pc:8091", "http://evil.example",
                             "http://field-pc:8090.evil.example", "null", "http://", "field-pc:8090"}) {
    EXPECT_FALSE(is_same_origin(origin, "field-pc:8090")) << origin;
  }
  EXPECT_FALSE(is_same_origin("http://", ""));
}

TEST(NetworkOf, IsTheHalfOfAnIpv6Address) {
  EXPECT_EQ(network_of("192.0.2.1"), "192.0.2.1");
  EXPECT_EQ(network_of("2001:db8::1:2:3:4"), network_of("2001:db8::ffff"));
  EXPECT_NE(network_of("2001:db8:0:1::1"), network_of("2001:db8:0:2::1"));
  EXPECT_NE(network_of("::ffff:192.0.2.1"), network_of("::ffff:192.0.2.2"));
  EXPECT_EQ(network_of("nonsense"), "nonsense");
}

}  // namespace
}  // namespace sslv
