// SPDX-License-Identifier: Apache-2.0
#include "services/calibration/joint_calibration_jobs.h"

#include "support/becomes.h"
#include "support/fake_cameras.h"

#include <stdexcept>

#include <gmock/gmock.h>

namespace sslv::joint_calibration_jobs_test {
namespace {

using testing::HasSubstr;

JointCalibrationOrder order(const JointCalibrationRequest& request) {
  CameraCalibration calibration;
  calibration.q3 = 0;
  calibration.q0 = 1;
  calibration.tz = 4000;
  calibration.pixel_image_width = FakeCameras::kWidth;
  calibration.pixel_image_height = FakeCameras::kHeight;
  return {request, {{0, calibration}, {1, calibration}}, FieldSize{}, "192.0.2.7", 0};
}

class JointCalibrationJobsTest : public testing::Test {
 protected:
  /// Delivers frames until good(job) holds; throws if it never does.
  template <class Good>
  JointCalibrationJobs::Job deliver_until(Good good, PixelFormat of_camera_1 = PixelFormat::kRgb24) {
    JointCalibrationJobs::Job job;
    const bool is_so = test::becomes([&] {
      job = jobs_.job(kJointKey);
      if (good(job)) return true;
      cameras_.deliver(0);
      cameras_.deliver(1, FakeCameras::kWidth, of_camera_1);
      return false;
    });
    if (!is_so)
      throw std::runtime_error(std::string("the job stays ") + name_of(job.state) + ": " + job.problem);
    return job;
  }
  static auto is(JobState state) {
    return [state](const JointCalibrationJobs::Job& job) { return job.state == state; };
  }

  FakeCameras cameras_;
  JointCalibrationJobs jobs_ = make_joint_calibration_jobs(cameras_.wait_frame(), test::kPatience);
};

TEST_F(JointCalibrationJobsTest, TakesFramesOfEachCameraAndReports) {
  EXPECT_EQ(jobs_.job(kJointKey).state, JobState::kIdle);
  EXPECT_FALSE(jobs_.cancel(kJointKey));
  EXPECT_FALSE(jobs_.forget(kJointKey, nullptr));
  ASSERT_TRUE(jobs_.start(kJointKey, order({{}, 3, 0})));
  const auto job = deliver_until(is(JobState::kDone));
  EXPECT_EQ(job.frames, 3);
  EXPECT_EQ(job.order->who, "192.0.2.7");
  ASSERT_TRUE(job.report);
  EXPECT_FALSE(job.report->found) << "a grey picture has no lines";
  EXPECT_FALSE(jobs_.forget(kJointKey, nullptr));
  EXPECT_TRUE(jobs_.forget(kJointKey, job.report.get()));
  EXPECT_EQ(jobs_.job(kJointKey).state, JobState::kIdle);
}

TEST_F(JointCalibrationJobsTest, LooksForRobotsAsLongAsItShould) {
  ASSERT_TRUE(jobs_.start(kJointKey, order({{}, 1, 600})));
  deliver_until([](const auto& job) { return job.ties == 1 && job.frames == 1; });
  EXPECT_EQ(jobs_.job(kJointKey).state, JobState::kCollecting);
  EXPECT_FALSE(jobs_.start(kJointKey, order({{}, 1, 0})));
  EXPECT_TRUE(jobs_.cancel(kJointKey));
  EXPECT_EQ(jobs_.job(kJointKey).state, JobState::kCancelled);
  // The next job is not affected by the cancelled one.
  ASSERT_TRUE(jobs_.start(kJointKey, order({{}, 2, 0})));
  EXPECT_EQ(deliver_until(is(JobState::kDone)).frames, 2);
}

TEST_F(JointCalibrationJobsTest, FailsWhenOneOfItsCamerasShowsSomethingElse) {
  const auto expect_invalid = [&] {
    EXPECT_EQ(jobs_.job(kJointKey).state, JobState::kFailed);
    EXPECT_FALSE(jobs_.job(kJointKey).report);
    EXPECT_THAT(jobs_.job(kJointKey).problem, HasSubstr("has changed since"));
  };
  ASSERT_TRUE(jobs_.start(kJointKey, order({{}, 1, 600})));
  invalidate(jobs_, {2, 3});
  EXPECT_EQ(jobs_.job(kJointKey).state, JobState::kCollecting);
  invalidate(jobs_, {1, 2});
  expect_invalid();

  ASSERT_TRUE(jobs_.start(kJointKey, order({{}, 1, 0}))) << "it need not be cancelled";
  deliver_until(is(JobState::kDone));
  invalidate(jobs_, {0});
  expect_invalid();
}

TEST_F(JointCalibrationJobsTest, PicturesThatCannotBeUsedAreNamed) {
  ASSERT_TRUE(jobs_.start(kJointKey, order({{}, 5, 0})));
  EXPECT_THAT(deliver_until(is(JobState::kFailed), PixelFormat::kMono8).problem,
              HasSubstr("camera 1: the camera's images have no colours (mono8)"));
}

TEST(JointCalibrationJobs, ACameraThatIsGoneFailsWithoutWaitingForIt) {
  FakeCameras cameras;
  JointCalibrationJobs jobs = make_joint_calibration_jobs(cameras.wait_frame(), std::chrono::hours(1));
  ASSERT_TRUE(jobs.start(kJointKey, order({{}, 1, 0})));
  cameras.remove(1);
  EXPECT_TRUE(test::becomes([&] { return !is_running(jobs.job(kJointKey).state); }));
  EXPECT_EQ(jobs.job(kJointKey).problem, "camera 1: no such camera");
}

TEST(JointCalibrationJobs, ASilentCameraFails) {
  FakeCameras cameras;
  cameras.deliver(0);
  JointCalibrationJobs jobs = make_joint_calibration_jobs(cameras.wait_frame(), std::chrono::milliseconds(1));
  ASSERT_TRUE(jobs.start(kJointKey, order({{}, 1, 0})));
  EXPECT_TRUE(test::becomes([&] { return !is_running(jobs.job(kJointKey).state); }));
  EXPECT_EQ(jobs.job(kJointKey).state, JobState::kFailed);
  EXPECT_THAT(jobs.job(kJointKey).problem, HasSubstr("camera 0: no image for 0.001 s"));
}

TEST(JointCalibrationJobs, EndWithoutWaitingForACamera) {
  FakeCameras cameras;
  JointCalibrationJobs jobs = make_joint_calibration_jobs(cameras.wait_frame(), std::chrono::hours(1));
  ASSERT_TRUE(jobs.start(kJointKey, order({{}, 1, 0})));
}

}  // namespace
}  // namespace sslv::joint_calibration_jobs_test
