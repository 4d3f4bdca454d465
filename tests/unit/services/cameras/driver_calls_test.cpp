// SPDX-License-Identifier: Apache-2.0
#include "services/cameras/driver_calls.h"

#include "base/error.h"
#include "capture/control_memory.h"
#include "capture/source.h"
#include "services/cameras/control_change.h"
#include "support/becomes.h"

#include <atomic>
#include <future>
#include <map>
#include <stdexcept>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sslv {
namespace {

using std::chrono::milliseconds;

/// Of a camera that answers, however late.
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

/// Numbers by name. A set of "slow" waits until it is let go.
class SlowControls : public Controls {
 public:
  std::vector<Control> list() override { return {}; }
  Control get(const std::string& name) override {
    const std::lock_guard lock(mutex);
    Control control;
    control.name = name;
    control.kind = ControlKind::kInteger;
    control.value = values[name];
    return control;
  }
  Json value(const std::string& name) {
    const std::lock_guard lock(mutex);
    return values[name];
  }
  std::promise<void> let_go;

 protected:
  ControlEffect write(const Control& control, const Json& value) override {
    if (control.name == "slow" && value == 2) released.wait();
    const std::lock_guard lock(mutex);
    values[control.name] = value;
    return ControlEffect::kAtOnce;
  }

 private:
  std::shared_future<void> released{let_go.get_future()};
  std::mutex mutex;
  std::map<std::string, Json> values{{"gain", 1}, {"slow", 1}};
};

TEST(ControlChange, IsSetBackUnlessItIsKept) {
  const auto controls = std::make_shared<SlowControls>();
  {
    const ControlChange change(controls, kPatient, Json::object(), {{"gain", 5}}, "/controls");
    EXPECT_EQ(controls->value("gain"), 5);
  }
  EXPECT_EQ(controls->value("gain"), 1);
  {
    ControlChange change(controls, kPatient, Json::object(), {{"gain", 5}}, "/controls");
    change.keep();
  }
  EXPECT_EQ(controls->value("gain"), 5);
}

TEST(ControlChange, WhatIsNoLongerWantedGetsTheValueOfTheOpening) {
  const auto controls = std::make_shared<SlowControls>();
  ControlChange(controls, kPatient, Json::object(), {{"gain", 5}}, "/controls").keep();
  {
    const ControlChange dropped(controls, kPatient, {{"gain", 5}}, Json::object(), "/controls");
    EXPECT_EQ(controls->value("gain"), 1);
  }
  EXPECT_EQ(controls->value("gain"), 5);
  ControlChange(controls, kPatient, {{"gain", 5}}, Json::object(), "/controls").keep();
  EXPECT_EQ(controls->value("gain"), 1);
}

TEST(ControlChange, IsNoLongerUnsaved) {
  const auto controls = std::make_shared<SlowControls>();
  controls->memory().set_unsaved("gain", 3);
  EXPECT_EQ(controls->memory().unsaved(Json::object()).size(), 1U);
  ControlChange(controls, kPatient, Json::object(), {{"gain", 3}}, "/controls").keep();
  controls->memory().set_unsaved("gain", 7);
  controls->memory().revert({});
  EXPECT_EQ(controls->value("gain"), 3);
}

TEST(ControlChange, OfACameraThatDoesNotAnswerIsRefusedAndSetBackWhenItDoes) {
  const auto controls = std::make_shared<SlowControls>();
  const DriverCalls calls(milliseconds(1), milliseconds(1));
  try {
    const ControlChange change(controls, calls, Json::object(), {{"gain", 5}, {"slow", 2}}, "/controls");
    FAIL() << "not refused";
  } catch (const SettingsError& error) {
    EXPECT_THAT(error.what(), testing::StartsWith("/controls: not set: the camera has not answered"));
  }
  controls->let_go.set_value();
  EXPECT_TRUE(test::becomes([&] {
    try {
      calls.run([] { return Json(); });
      return true;
    } catch (const CaptureError&) {  // the driver is free again once all is set back
      return false;
    }
  }));
  EXPECT_EQ(controls->value("gain"), 1);
  EXPECT_EQ(controls->value("slow"), 1);
}

}  // namespace
}  // namespace sslv
