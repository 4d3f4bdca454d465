// SPDX-License-Identifier: Apache-2.0
#include "services/calibration/calibration_jobs.h"

#include "support/becomes.h"
#include "support/fake_cameras.h"

#include <stdexcept>
#include <vector>

#include <gmock/gmock.h>

namespace sslv::calibration_jobs_test {
namespace {

using testing::AllOf;
using testing::HasSubstr;

CalibrationOrder order(const std::string& request) {
  return {read_calibration_request(Json::parse(request)), FieldSize{}, {}, "192.0.2.7", 0};
}

// In a grey image, a search with these points finds nothing; because the points have names, it ends soon.
constexpr const char* kPoints = R"([
  {"x": 5, "y": 5, "name": "corner left top"}, {"x": 50, "y": 5, "name": "corner right top"},
  {"x": 50, "y": 40, "name": "corner right bottom"}, {"x": 5, "y": 40, "name": "corner left bottom"}])";

std::string request(int frames) {
  return Json{{"points", Json::parse(kPoints)}, {"frames", frames}}.dump();
}

class CalibrationJobsTest : public testing::Test {
 protected:
  /// Delivers frames until the job is in this state; throws if it never is.
  CalibrationJobs::Job deliver_until(int camera_id, JobState state) {
    return wait(camera_id, state, [&] { cameras_.deliver(camera_id); });
  }
  CalibrationJobs::Job wait_until(int camera_id, JobState state) {
    return wait(camera_id, state, [] {});
  }

  FakeCameras cameras_;
  CalibrationJobs jobs_ = make_calibration_jobs(cameras_.wait_frame(), test::kPatience);

 private:
  template <class Meanwhile>
  CalibrationJobs::Job wait(int camera_id, JobState state, Meanwhile meanwhile) {
    CalibrationJobs::Job job;
    const bool is_so = test::becomes([&] {
      job = jobs_.job(camera_id);
      if (job.state != state) meanwhile();
      return job.state == state;
    });
    if (!is_so)
      throw std::runtime_error(std::string("the job stays ") + name_of(job.state) + ": " + job.problem);
    return job;
  }
};

TEST_F(CalibrationJobsTest, IsIdleBeforeTheFirstOrder) {
  EXPECT_EQ(jobs_.job(0).state, JobState::kIdle);
  EXPECT_FALSE(jobs_.cancel(0));
  EXPECT_FALSE(jobs_.forget(0, nullptr));
}

TEST_F(CalibrationJobsTest, TakesItsFramesAndReports) {
  ASSERT_TRUE(jobs_.start(0, order(request(3))));
  const auto job = deliver_until(0, JobState::kDone);
  EXPECT_EQ(job.frames, 3);
  EXPECT_EQ(job.order->who, "192.0.2.7");
  ASSERT_TRUE(job.report);
  EXPECT_FALSE(job.report->found);
  EXPECT_FALSE(jobs_.forget(0, nullptr));
  EXPECT_TRUE(jobs_.forget(0, job.report.get()));
  EXPECT_EQ(jobs_.job(0).state, JobState::kIdle);
}

TEST_F(CalibrationJobsTest, ACameraHasOneJobAtATime) {
  ASSERT_TRUE(jobs_.start(0, order(request(1))));
  EXPECT_FALSE(jobs_.start(0, order(request(1))));
  EXPECT_FALSE(jobs_.forget(0, nullptr));
  EXPECT_TRUE(jobs_.cancel(0));
  EXPECT_EQ(jobs_.job(0).state, JobState::kCancelled);
  EXPECT_FALSE(jobs_.cancel(0));
  // The next job is not affected by the cancelled one.
  ASSERT_TRUE(jobs_.start(0, order(request(2))));
  EXPECT_EQ(deliver_until(0, JobState::kDone).frames, 2);
}

TEST_F(CalibrationJobsTest, FailsWhenTheCameraShowsSomethingElse) {
  invalidate(jobs_, {0});
  EXPECT_EQ(jobs_.job(0).state, JobState::kIdle);
  ASSERT_TRUE(jobs_.start(0, order(request(1))));
  deliver_until(0, JobState::kDone);
  invalidate(jobs_, {1});
  EXPECT_EQ(jobs_.job(0).state, JobState::kDone);
  invalidate(jobs_, {0});
  EXPECT_EQ(jobs_.job(0).state, JobState::kFailed);
  EXPECT_FALSE(jobs_.job(0).report);
  EXPECT_THAT(jobs_.job(0).problem, HasSubstr("has changed since"));

  ASSERT_TRUE(jobs_.start(0, order(request(100))));
  invalidate(jobs_, {0});
  EXPECT_EQ(jobs_.job(0).state, JobState::kFailed);
  ASSERT_TRUE(jobs_.start(0, order(request(2)))) << "it need not be cancelled";
  EXPECT_EQ(deliver_until(0, JobState::kDone).frames, 2);
}

TEST_F(CalibrationJobsTest, CamerasTakeTurns) {
  ASSERT_TRUE(jobs_.start(0, order(request(1))));
  ASSERT_TRUE(jobs_.start(1, order(request(1))));
  EXPECT_EQ(jobs_.job(1).state, JobState::kCollecting);
  deliver_until(0, JobState::kDone);
  deliver_until(1, JobState::kDone);
}

TEST_F(CalibrationJobsTest, ACancelledOneLetsTheNextCameraHaveItsTurn) {
  ASSERT_TRUE(jobs_.start(0, order(request(1))));
  ASSERT_TRUE(jobs_.start(1, order(request(1))));
  EXPECT_TRUE(jobs_.cancel(0));
  deliver_until(1, JobState::kDone);
  EXPECT_EQ(jobs_.job(0).state, JobState::kCancelled);
}

TEST_F(CalibrationJobsTest, AnEnginesRefusalIsTheProblem) {
  ASSERT_TRUE(
      jobs_.start(0, order(R"({"frames": 1, "points": [{"x": 5, "y": 5, "name": "moon"}, {"x": 9, "y": 5},
                                       {"x": 9, "y": 9}, {"x": 5, "y": 9}]})")));
  EXPECT_THAT(deliver_until(0, JobState::kFailed).problem, HasSubstr("moon"));
}

TEST_F(CalibrationJobsTest, PointsOutsideThePictureAreNamed) {
  ASSERT_TRUE(jobs_.start(0, order(R"({"frames": 1, "points": [{"x": 5, "y": 48}]})")));
  EXPECT_THAT(deliver_until(0, JobState::kFailed).problem,
              AllOf(HasSubstr("/points/0/y: 48 is not allowed"), HasSubstr("0 .. 47 px")));
}

TEST_F(CalibrationJobsTest, PicturesThatCannotBeUsedAreNamed) {
  ASSERT_TRUE(jobs_.start(0, order(request(2))));
  EXPECT_TRUE(test::becomes([&] {
    cameras_.deliver(0, FakeCameras::kWidth, PixelFormat::kMono8);
    return jobs_.job(0).state != JobState::kCollecting;
  }));
  EXPECT_THAT(wait_until(0, JobState::kFailed).problem, HasSubstr("no colours (mono8)"));

  ASSERT_TRUE(jobs_.start(0, order(request(100))));
  EXPECT_TRUE(test::becomes([&] {
    cameras_.deliver(0);
    return jobs_.job(0).frames > 0;
  }));
  cameras_.deliver(0, FakeCameras::kWidth / 2);
  EXPECT_THAT(wait_until(0, JobState::kFailed).problem, HasSubstr("have changed in the meantime"));
}

TEST(CalibrationJobs, ACameraThatIsGoneFailsWithoutWaitingForIt) {
  FakeCameras cameras;
  CalibrationJobs jobs = make_calibration_jobs(cameras.wait_frame(), std::chrono::hours(1));
  ASSERT_TRUE(jobs.start(0, order(request(1))));
  cameras.remove(0);
  EXPECT_TRUE(test::becomes([&] { return !is_running(jobs.job(0).state); }));
  EXPECT_EQ(jobs.job(0).problem, "no such camera");
}

TEST(CalibrationJobs, ASilentCameraFailsEvenThoughItHasAnOldFrame) {
  FakeCameras cameras;
  cameras.deliver(0);
  CalibrationJobs jobs = make_calibration_jobs(cameras.wait_frame(), std::chrono::milliseconds(1));
  ASSERT_TRUE(jobs.start(0, order(request(1))));
  EXPECT_TRUE(test::becomes([&] { return jobs.job(0).state == JobState::kFailed; }));
  EXPECT_THAT(jobs.job(0).problem, HasSubstr("no image for 0.001 s"));
}

TEST(CalibrationJobs, EndWithoutWaitingForACamera) {
  FakeCameras cameras;
  CalibrationJobs jobs = make_calibration_jobs(cameras.wait_frame(), std::chrono::hours(1));
  ASSERT_TRUE(jobs.start(0, order(request(1))));
  ASSERT_TRUE(jobs.start(1, order(request(1))));
}

}  // namespace
}  // namespace sslv::calibration_jobs_test
