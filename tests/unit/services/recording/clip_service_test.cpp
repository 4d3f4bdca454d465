// SPDX-License-Identifier: Apache-2.0
#include "services/recording/clip_service.h"

#include "clips/clip_reader.h"
#include "clips/clip_writer.h"
#include "recording/match_log_index.h"
#include "support/becomes.h"
#include "support/clip_images.h"
#include "support/no_cameras.h"
#include "support/temporary_folder.h"

#include <chrono>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include <fcntl.h>
#include <gmock/gmock.h>

namespace sslv::clip_service_test {
namespace {

namespace fs = std::filesystem;
using ::testing::Contains;
using ::testing::ElementsAre;

class ClipServiceTest : public ::testing::Test {
 protected:
  /// Writes a clip of this age.
  void write(const std::string& name, const std::string& kind, std::chrono::minutes ago) const {
    fs::create_directories(files_.path_of("."));
    {
      ClipWriter writer(files_.path_of(name), {.kind = kind, .why = "a test"});
      writer.finish();
    }
    fs::last_write_time(files_.path_of(name), fs::file_time_type::clock::now() - ago);
  }
  std::vector<std::string> names() const {
    std::vector<std::string> out;
    for (const RecordingFile& file : files_.list(RecordingFile::Kind::kClip)) out.push_back(file.name);
    return out;
  }
  /// Starts the service after a crash, and returns what it reports about that.
  std::string told_after_crash(std::size_t memory_bytes = 10) {
    ImageRing ring(1 << 20);
    ring.put_setup(0, {0, Json{{"settings", Json::object()}}, {}});
    const OwnedImage image = noise_image(PixelFormat::kMono8, 64, 64, 1);
    const std::vector<std::byte> memory(memory_bytes);
    ClipFrame frame;
    frame.info.times.arrived_ns = 1;
    frame.image = image.view;
    frame.memory = memory;
    ring.put(frame);
    std::vector<KeptFile> left;
    left.push_back({"last_seconds-0-1", OpenFile(::fcntl(ring.fd(), F_DUPFD_CLOEXEC, 0))});
    ClipService service(config_, files_, cameras_, referee_, std::move(left));
    std::string told;
    test::becomes([&] {
      HealthReport report;
      service.report(report);
      for (const Alert& alert : report.alerts)
        if (alert.id == "service_crashed") told = alert.title;
      return !told.empty();
    });
    state_ = Json::parse(service.routes().at(0).handle({}).body);
    return told;
  }

  test::TemporaryFolder folder_;
  RecordingFiles files_{folder_.path()};
  Snapshot<Config> config_{[] {
    Config config;
    config.recording.keep_free_mb = 0;
    return config;
  }()};
  test::NoCameras cameras_;
  RefereeListener referee_{[] {}};
  Json state_;  // of clips, after the crash was reported
};

TEST_F(ClipServiceTest, ARenamedClipIsNotACrashClip) {
  using std::chrono::minutes;
  write("2026-07-01_10-00_robot_crash.clip", "kept", minutes(50));
  write("2026-07-01_10-01_crash.clip", "kept", minutes(40));
  write("2026-07-01_10-02_goal.clip", "crash", minutes(30));  // renamed
  write("2026-07-01_10-03_crash.clip", "crash", minutes(20));
  write("2026-07-01_10-04_crash.clip", "crash", minutes(10));
  write("2026-07-01_10-05_robot_crash.clip", "kept", minutes(0));  // just written
  EXPECT_THAT(told_after_crash(), ::testing::HasSubstr("_crash.clip shows what the cameras saw before"));
  std::vector<std::string> of_crashes;
  for (const std::string& name : names()) {
    const ClipReader clip(files_.path_of(name));
    if (clip.about().kind == kCrashClip) of_crashes.push_back(name);
  }
  ASSERT_EQ(of_crashes.size(), 3U) << "the newest ones";
  EXPECT_THAT(of_crashes, Contains("2026-07-01_10-03_crash.clip"));
  EXPECT_THAT(of_crashes, Contains("2026-07-01_10-04_crash.clip"));
  for (const char* name : {"2026-07-01_10-00_robot_crash.clip", "2026-07-01_10-01_crash.clip",
                           "2026-07-01_10-05_robot_crash.clip"})
    EXPECT_THAT(names(), Contains(name));
}

TEST_F(ClipServiceTest, AnUnremovableCrashClipDoesNotPreventANewOne) {
  for (const char* name : {"a.clip", "b.clip", "c.clip"}) {
    write(name, "crash", std::chrono::minutes(10));
    fs::create_directories(index_file_of(files_.path_of(name)) / "in the way");
  }
  EXPECT_THAT(told_after_crash(), ::testing::HasSubstr("_crash.clip shows what the cameras saw before"));
}

TEST_F(ClipServiceTest, AFailedCrashClipIsNotShown) {
  EXPECT_THAT(told_after_crash(0), ::testing::HasSubstr("there is no clip of it: no camera has images"));
  EXPECT_EQ(state_["clip"]["name"], "");
  EXPECT_EQ(state_["clip"]["frames"], 0);
  EXPECT_EQ(state_["clip"]["bytes"], 0);
}

TEST_F(ClipServiceTest, ASecondCrashWithinAMinuteMakesNoClip) {
  write("2026-07-01_10-00_any_name.clip", "crash", std::chrono::minutes(0));
  EXPECT_EQ(told_after_crash(),
            "The service crashed and was restarted; a clip of a crash was made less than a minute ago");
  EXPECT_THAT(names(), ElementsAre("2026-07-01_10-00_any_name.clip"));
}

}  // namespace
}  // namespace sslv::clip_service_test
