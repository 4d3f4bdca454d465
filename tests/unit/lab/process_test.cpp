// SPDX-License-Identifier: Apache-2.0
#include "lab/process.h"

#include "support/temporary_folder.h"

#include <sstream>
#include <string>
#include <vector>

#include <gmock/gmock.h>

namespace sslv::process_test {
namespace {

using testing::DoubleNear;
using testing::ElementsAre;

/// The capture times that stages get for three raw frames.
std::vector<double> times_of(const Json& source) {
  const test::TemporaryFolder folder;
  for (const char* name : {"a.raw", "b.raw", "c.raw"}) folder.write(name, std::string(64 * 48, '\x40'));
  Config config;
  config.cameras.emplace_back();
  config.cameras[0].source = source;
  std::vector<double> times_s;
  std::ostringstream problems;
  const int unreadable = process_recording(
      config, 0, {.input = folder.path().string(), .pixel_format = "bayer_rg8", .width = 64, .height = 48},
      [&](const std::string&, const Frame& frame) { times_s.push_back(frame.info.times.t_capture_s); },
      problems);
  EXPECT_EQ(unreadable, 0) << problems.str();
  return times_s;
}

TEST(Process, FramesWithoutTimesAreAsFarApartEachTime) {
  const auto is = [](double time_s) { return DoubleNear(time_s, 1e-9); };
  EXPECT_THAT(times_of({{"backend", "simulator"}, {"frame_rate_hz", 50}}),
              ElementsAre(is(1), is(1.02), is(1.04)));
  EXPECT_THAT(times_of({{"backend", "files"}}), ElementsAre(is(1), is(1.004), is(1.008)));
  EXPECT_THAT(times_of({{"backend", "aravis"}, {"frame_rate_hz", nullptr}}),
              ElementsAre(is(1), is(1.004), is(1.008)));
}

}  // namespace
}  // namespace sslv::process_test
