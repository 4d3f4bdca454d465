// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/error.h"
#include "capture/dc1394/dc1394.h"
#include "support/fake_dc1394.h"

#include <memory>
#include <string>

#include <gmock/gmock.h>

namespace sslv {

inline constexpr std::uint64_t kGuid = 0x000a470112345678, kOtherGuid = 0x00b09d0100112233;
inline constexpr const char* kGuidText = "000a470112345678";

/// Opens `kGuid`'s camera and reads frames of its simulated sensor.
class IidcCamera : public testing::Test {
 protected:
  void SetUp() override {
    fake_iidc::clear();
    fake_iidc::plug_in(fake_iidc::league_camera(kGuid));
  }
  void TearDown() override {
    EXPECT_EQ(fake_iidc::counts().handles, 0) << "cameras left open";
    EXPECT_EQ(fake_iidc::counts().captures, 0) << "captures left set up";
  }

  static std::unique_ptr<Source> open(const Json& options = Json::object()) {
    return dc1394_backend().open(dc1394_backend().complete(options, ""), {});
  }
  static std::string refusal(const Json& options) {
    try {
      open(options);
    } catch (const CaptureError& error) {
      return error.what();
    } catch (const SettingsError& error) {
      return error.what();
    }
    return "no error";
  }
  /// Does not wait: the frames have already been sent.
  static CaptureStatus next(Source& source, CapturedImage& image, std::string& problem) {
    image = {};
    return source.next(image, problem, std::chrono::milliseconds(0));
  }
  static CapturedImage next_picture(Source& source) {
    CapturedImage image;
    std::string problem;
    EXPECT_EQ(next(source, image, problem), CaptureStatus::kImage) << problem;
    return image;
  }
};

}  // namespace sslv
