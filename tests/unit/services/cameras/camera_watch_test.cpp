// SPDX-License-Identifier: Apache-2.0
#include "services/cameras/camera_watch.h"

#include "services/cameras/camera_setup.h"
#include "support/becomes.h"
#include "support/paths.h"

#include <gtest/gtest.h>

namespace sslv::camera_watch_test {
namespace {

/// Running cameras that show one image and send no packets.
class CameraWatchTest : public testing::Test {
 protected:
  std::shared_ptr<RunningCamera> start_camera() {
    NewSetup setup = *plan_setup(config_, 0, std::nullopt, {});
    setup.make_stages(config_.cameras[0]);
    auto camera = std::make_shared<RunningCamera>(config_.cameras[0], std::move(setup.setup),
                                                  std::make_shared<const Config>(config_), multicast_,
                                                  intake_.add(), totals_);
    camera->start();
    EXPECT_TRUE(test::becomes([&] { return camera->health().state == CameraState::kRunning; }));
    return camera;
  }

  const Config config_ = read_config({{"cameras",
                                       {{{"id", 3},
                                         {"stack", {"segment"}},
                                         {"source",
                                          {{"backend", "files"},
                                           {"path", source_path("/tests/golden/division_b.jpg")},
                                           {"loop", true}}}}}}});
  MulticastSender multicast_{MulticastSettings{}};
  FieldIntake intake_;
  const std::shared_ptr<CameraTotals> totals_ = std::make_shared<CameraTotals>();  // of this camera id
  CameraWatch watch_;
};

TEST_F(CameraWatchTest, LossesOfAnIdsPreviousCameraAreNotCounted) {
  auto camera = start_camera();
  watch_.look({camera});
  totals_->capture.dropped += 50;
  watch_.look({camera});
  EXPECT_GE(watch_.timeline().sum(3, 60).dropped, 50u);
  totals_->capture.dropped += 7;  // after the last look()
  camera = start_camera();
  watch_.look({camera});
  watch_.look({camera});
  EXPECT_EQ(watch_.timeline().sum(3, 60).seconds, 1u);
  EXPECT_LT(watch_.timeline().sum(3, 60).dropped, 7u);
}

}  // namespace
}  // namespace sslv::camera_watch_test
