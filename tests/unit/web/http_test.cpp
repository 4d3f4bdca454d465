// SPDX-License-Identifier: Apache-2.0
#include "web/http.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sslv::http_test {
namespace {

TEST(HttpTest, AnOriginMustBeTheHost) {
  EXPECT_TRUE(is_same_origin("", "field-pc:8090"));
  EXPECT_TRUE(is_same_origin("http://Field-PC:8090", "field-pc:8090"));
  for (const char* origin : {"http://field-pc:8091", "http://evil.example",
                             "http://field-pc:8090.evil.example", "null", "http://", "field-pc:8090"}) {
    EXPECT_FALSE(is_same_origin(origin, "field-pc:8090")) << origin;
  }
  EXPECT_TRUE(is_same_origin("https://field-pc:8090", "field-pc:8090")) << "a proxy with TLS";
  for (const char* origin : {"x://field-pc:8090", "file://field-pc:8090", "chrome-extension://field-pc:8090",
                             "://field-pc:8090", "nonsense http://field-pc:8090"}) {
    EXPECT_FALSE(is_same_origin(origin, "field-pc:8090")) << origin;
  }
  EXPECT_FALSE(is_same_origin("http://", ""));
}

TEST(HttpTest, AHostIsANameOrAnAddressAndNothingElse) {
  const std::vector<std::string> names{"Panel.Example"};
  for (const char* host :
       {"", "localhost", "LOCALHOST:8090", "127.0.0.1", "192.0.2.1:8090", "[::1]", "[::1]:8090",
        "[2001:DB8::1]:80", "panel.example", "PANEL.example:8090", "panel.example:"}) {
    EXPECT_TRUE(is_own_name(host, names)) << host;
  }
  for (const std::string& host :
       {std::string("[::1]evil.com"), std::string("[::1].evil.com:80"), std::string("[::1"),
        std::string("[]"), std::string("[127.0.0.1]"), std::string("[::1%evil.com]"),
        std::string("[::1]:evil"), std::string("::1"), std::string("127.0.0.1:80:evil.com"),
        std::string("127.0.0.1:evil.com"), std::string("127.0.0.1\0.evil.com", 19),
        std::string("127.0.0.1 evil.com"), std::string("evil.com"), std::string("localhost:123456"),
        std::string("localhost@evil.com"), std::string(":8090"), std::string("localhost/"),
        std::string("localh\xc3\xb6st")}) {
    EXPECT_FALSE(is_own_name(host, names)) << host;
  }
}

TEST(NetworkOf, IsTheHalfOfAnIpv6Address) {
  EXPECT_EQ(network_of("192.0.2.1"), "192.0.2.1");
  EXPECT_EQ(network_of("2001:db8::1:2:3:4"), network_of("2001:db8::ffff"));
  EXPECT_NE(network_of("2001:db8:0:1::1"), network_of("2001:db8:0:2::1"));
  EXPECT_NE(network_of("::ffff:192.0.2.1"), network_of("::ffff:192.0.2.2"));
  EXPECT_EQ(network_of("fe80::1%eth0"), network_of("fe80::2%eth0"));
  EXPECT_EQ(network_of("nonsense"), "nonsense");
}

}  // namespace
}  // namespace sslv::http_test
