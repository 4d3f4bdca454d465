// SPDX-License-Identifier: Apache-2.0
#include "config/backends.h"

#include "base/error.h"

#include <array>

#include <gmock/gmock.h>

namespace sslv {
namespace {

constexpr std::array<Backend, 2> kBackends{Backend{"files", "", nullptr, nullptr, nullptr, nullptr},
                                           Backend{"simulator", "", nullptr, nullptr, nullptr, nullptr}};
constexpr std::array kMissing{MissingBackend{"mycam", "libmycam-dev"}};

std::string refusal(const std::string& name) {
  try {
    find_backend(kBackends, kMissing, name, "/cameras/0/source/backend");
  } catch (const SettingsError& error) {
    return error.what();
  }
  return "no error";
}

TEST(Cameras, BackendIsFoundByName) {
  EXPECT_EQ(find_backend(kBackends, kMissing, "simulator", "").name, "simulator");
}

TEST(Cameras, UnknownBackendIsRefusedWithTheKnownOnes) {
  EXPECT_EQ(refusal("webcam"),
            "/cameras/0/source/backend: no capture backend \"webcam\"; known: files, simulator");
}

TEST(Cameras, BackendThatWasNotBuiltNamesItsPackage) {
  EXPECT_EQ(refusal("mycam"),
            "/cameras/0/source/backend: capture backend \"mycam\" is not in this program; to build it in, "
            "install libmycam-dev and build again; known: files, simulator");
}

TEST(Cameras, EveryBackendIsEitherKnownOrMissing) {
  bool known = false, missing = false;
  for (const Backend& backend : backend_table()) known |= backend.name == "dc1394";
  for (const MissingBackend& backend : missing_backends()) missing |= backend.name == "dc1394";
  EXPECT_NE(known, missing);
}

}  // namespace
}  // namespace sslv
