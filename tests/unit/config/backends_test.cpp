// SPDX-License-Identifier: Apache-2.0
#include "config/backends.h"

#include "base/error.h"

#include <array>

#include <gmock/gmock.h>

namespace sslv::backends_test {
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

TEST(Cameras, ACameraIsKnownByAllNamesOfItsDevice) {
  using ::testing::UnorderedElementsAre;
  const std::vector<FoundCamera> found{
      {"a webcam", {{"backend", "v4l2"}, {"camera", "/dev/video0"}}},
      {.name = "left", .source = {{"backend", "aravis"}, {"camera", "SN1"}}, .other_names = {"192.0.2.7"}},
      {.name = "right", .source = {{"backend", "aravis"}, {"camera", "SN2"}}, .other_names = {"192.0.2.8"}}};
  const auto names = [&](const char* camera) {
    return names_of_camera({{"backend", "aravis"}, {"camera", camera}}, found);
  };
  EXPECT_THAT(names("192.0.2.8"), UnorderedElementsAre("SN2", "192.0.2.8"));
  EXPECT_THAT(names("SN1"), UnorderedElementsAre("SN1", "192.0.2.7"));
  EXPECT_THAT(names(""), UnorderedElementsAre("SN1", "192.0.2.7")) << "it opens the first one";
  EXPECT_THAT(names("192.0.2.9"), UnorderedElementsAre("192.0.2.9"));
}

TEST(Cameras, EveryBackendIsEitherKnownOrMissing) {
  bool known = false, missing = false;
  for (const Backend& backend : backend_table()) known |= backend.name == "dc1394";
  for (const MissingBackend& backend : missing_backends()) missing |= backend.name == "dc1394";
  EXPECT_NE(known, missing);
}

}  // namespace
}  // namespace sslv::backends_test
