// SPDX-License-Identifier: Apache-2.0
#include "capture/driver_calls.h"

#include "base/json.h"
#include "capture/source.h"
#include "support/becomes.h"

#include <future>
#include <stdexcept>
#include <vector>

#include <gtest/gtest.h>

namespace sslv::driver_calls_test {
namespace {

using std::chrono::milliseconds;

/// For a camera that always answers, however late.
const DriverCalls kPatient(test::kPatience, test::kPatience);

TEST(DriverCalls, ReturnOrThrowWhatTheDriverDoes) {
  EXPECT_EQ(kPatient.run([] { return Json(7); }), 7);
  EXPECT_THROW(kPatient.run([]() -> Json { throw std::runtime_error("no"); }), std::runtime_error);
  EXPECT_EQ(kPatient.run([] { return Json(8); }), 8);
}

TEST(DriverCalls, OneThatHangsIsLeftBehindAndRefusesTheNext) {
  const DriverCalls calls(milliseconds(1), milliseconds(1));
  std::promise<void> answer;
  auto answered = answer.get_future().share();
  EXPECT_THROW(calls.run([answered] {
    answered.wait();
    return Json();
  }),
               CaptureError);
  EXPECT_THROW(calls.run([] { return Json(7); }), CaptureError) << "it still hangs";
  answer.set_value();
  EXPECT_TRUE(test::becomes([&] {
    try {
      return calls.run([] { return Json(7); }) == 7;
    } catch (const CaptureError&) {  // it has not returned yet
      return false;
    }
  }));
}

TEST(DriverCalls, PostedCallsRunInOrderAndCanBeWaitedFor) {
  std::promise<void> may_go_on;
  std::vector<int> order;
  const auto first = kPatient.post([&, go_on = may_go_on.get_future().share()] {
    go_on.wait();
    order.push_back(1);
  });
  const auto second = kPatient.post([&] { order.push_back(2); });
  const auto third = kPatient.post([] { throw std::runtime_error("no"); });
  may_go_on.set_value();
  EXPECT_THROW(kPatient.wait(third), std::runtime_error);
  kPatient.wait(second);
  kPatient.wait(first);
  EXPECT_EQ(order, (std::vector{1, 2}));
}

TEST(DriverCalls, OneThatIsRefusedIsNotRunLater) {
  const DriverCalls calls(test::kPatience, milliseconds(1));
  std::promise<void> may_go_on;
  const auto first = calls.post([go_on = may_go_on.get_future().share()] { go_on.wait(); });
  bool has_run = false;
  EXPECT_THROW(calls.run([&] { return has_run = true; }), CaptureError);
  may_go_on.set_value();
  calls.wait(first);
  calls.wait(calls.post([] {}));
  EXPECT_FALSE(has_run);
}

TEST(DriverCalls, NobodyWaitsOnceTheProgramEnds) {
  const DriverCalls calls(test::kPatience, test::kPatience);
  std::promise<void> answer;
  const auto hangs = calls.post([go_on = answer.get_future().share()] { go_on.wait(); });
  auto waiting = std::async(std::launch::async, [&] { return calls.run([] { return 7; }); });
  calls.ask_to_stop();
  EXPECT_THROW(waiting.get(), CaptureError);
  EXPECT_THROW(calls.wait(hangs), CaptureError);
  EXPECT_THROW(calls.post([] {}), CaptureError);
  answer.set_value();
}

}  // namespace
}  // namespace sslv::driver_calls_test
