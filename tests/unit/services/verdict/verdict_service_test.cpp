// SPDX-License-Identifier: Apache-2.0
#include "services/verdict/verdict_service.h"

#include "base/clock.h"
#include "ssl_gc_referee_message.pb.h"
#include "support/becomes.h"
#include "vision/mask.h"

#include <atomic>
#include <cmath>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <string>
#include <vector>

#include <gmock/gmock.h>

namespace sslv::verdict_service_test {
namespace {

using ::testing::Contains;
using ::testing::Field;
using ::testing::Not;

/// Camera 0, whose frames have robots but no pixels.
class OneCamera final : public Cameras {
 public:
  explicit OneCamera(MaskSettings mask = {}) {
    auto setup = std::make_shared<CameraSetup>();
    setup->context.scene = std::make_shared<const Scene>();
    setup->context.mask = std::make_shared<const Mask>(mask);
    now_.setup = std::move(setup);
    CameraSettings settings;
    settings.source = {{"backend", "simulator"}};
    now_.settings = std::make_shared<const CameraSettings>(std::move(settings));
    now_.health.state = CameraState::kRunning;
  }
  void set_size(int width, int height) {
    const std::lock_guard lock(mutex_);
    now_.health.width = width;
    now_.health.height = height;
  }
  int looks() const { return looks_; }

  const std::vector<Robot> robots{
      {Team::kBlue, 1, 4650, 1000, 0, 140, 0, 0, 1},  // Division B's goal line is at 4500 mm
      {Team::kBlue, 2, 0, 0, 0, 140, 0, 0, 1},
      {Team::kYellow, 3, 4650, -1000, 0, 140, 0, 0, 1},
  };

  std::vector<CameraNow> all() const override {
    const std::lock_guard lock(mutex_);
    return {now_};
  }
  std::optional<LentFrame> wait_frame(int, std::uint64_t newer_than, std::chrono::milliseconds) override {
    ++looks_;
    LentFrame frame;
    frame.version = newer_than + 1;
    frame.robots = robots;
    return frame;
  }
  CameraNow get(int) const override { throw std::logic_error("not asked for"); }
  bool change_light(int, const std::shared_ptr<const Lut>&, std::shared_ptr<const Lut>) override {
    return false;
  }
  std::map<int, std::shared_ptr<RecordedCamera>> recorded() const override { return {}; }
  void add_observer(CameraObserver&) override {}
  std::string hanging() const override { return {}; }
  std::string missing() const override { return {}; }

 private:
  mutable std::mutex mutex_;
  CameraNow now_;
  std::atomic<int> looks_{0};
};

HealthReport report_of(const VerdictService& service) {
  HealthReport report;
  service.report(report);
  return report;
}

TEST(Coverage, TheMiddleOfUncoveredPlacesIsOneOfThem) {
  std::vector<Eigen::Vector2d> ends;  // both ends of the field, and a larger part of one side
  for (const double y : {-375.0, -125.0, 125.0, 375.0}) {
    for (const double x : {-4375.0, 4375.0, 4125.0}) ends.emplace_back(x, y);
  }
  const Eigen::Vector2d middle = middle_of_largest(ends);
  EXPECT_GT(middle.x(), 4000);
  EXPECT_LT(std::abs(middle.y()), 200);
  EXPECT_EQ(middle_of_largest({{125, 125}}), Eigen::Vector2d(125, 125));
}

TEST(VerdictService, AMaskThatHidesSmallerImagesIsReported) {
  const Snapshot<Config> config{Config{}};
  const RefereeListener referee([] {});
  MaskSettings right_side;
  right_side.include.push_back({{{650, 0}, {800, 0}, {800, 600}, {650, 600}}});
  OneCamera cameras(right_side);
  VerdictService service(config, cameras, referee);
  const auto hides_all = Contains(Field(&Alert::id, "mask_hides_all"));
  cameras.set_size(780, 580);
  service.each_second();
  EXPECT_THAT(report_of(service).alerts, Not(hides_all));
  cameras.set_size(640, 480);
  service.each_second();
  EXPECT_THAT(report_of(service).alerts, hides_all);
}

TEST(VerdictService, CountsRobotsAsTheGameControllerDoes) {
  const Snapshot<Config> config{Config{}};
  RefereeListener referee([] {});
  OneCamera cameras;
  const VerdictService service(config, cameras, referee);
  // When the third frame is requested, the first one has been added.
  ASSERT_TRUE(test::becomes([&] { return cameras.looks() >= 3; }));
  const auto robots = [&](std::optional<bool> blue_at_positive_x) {
    Referee message;
    message.mutable_yellow()->set_name("MRL");
    message.mutable_blue()->set_name("KIKS");
    if (blue_at_positive_x) message.set_blue_team_on_positive_half(*blue_at_positive_x);
    const std::string datagram = message.SerializeAsString();
    referee.receive(std::as_bytes(std::span(datagram)), {}, steady_s());
    for (const Check& check : report_of(service).checks) {
      if (check.id == "robots") return check.value;
    }
    return std::string("no check");
  };
  EXPECT_EQ(robots(true), "1 / 1");
  EXPECT_EQ(robots(false), "0 / 2");
  EXPECT_EQ(robots({}), "0 / 1");
}

}  // namespace
}  // namespace sslv::verdict_service_test
