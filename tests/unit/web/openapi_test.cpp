// SPDX-License-Identifier: Apache-2.0
#include "base/json.h"
#include "routes.h"

#include <cctype>
#include <fstream>
#include <regex>
#include <set>
#include <string>

#include <gtest/gtest.h>

namespace sslv {
namespace {

std::string upper(std::string text) {
  for (char& letter : text) letter = static_cast<char>(std::toupper(static_cast<unsigned char>(letter)));
  return text;
}

TEST(OpenApi, NamesEveryRouteAndNoOther) {
  const Json file = Json::parse(std::ifstream(SSLV_SOURCE_DIR "/docs/openapi.json"));
  std::set<const Route*> documented;
  for (const auto& [path, methods] : file.at("paths").items()) {
    if (path == "/api/openapi.json") continue;  // a file of the panel
    const std::string example = std::regex_replace(path, std::regex(R"(\{\w+\})"), "7");
    for (const auto& [method, operation] : methods.items()) {
      const Route* found = nullptr;
      for (const Route& route : routes()) {
        if (upper(method) == route.method && std::regex_match(example, std::regex(route.pattern))) {
          found = &route;
          break;
        }
      }
      ASSERT_NE(found, nullptr) << method << " " << path << " is no route";
      EXPECT_TRUE(documented.insert(found).second) << method << " " << path;
    }
  }
  for (const Route& route : routes())
    EXPECT_TRUE(documented.contains(&route)) << route.method << " " << route.pattern << " is not documented";
}

}  // namespace
}  // namespace sslv
