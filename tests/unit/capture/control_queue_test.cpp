// SPDX-License-Identifier: Apache-2.0
#include "capture/control_queue.h"

#include "capture/source.h"
#include "support/patience.h"

#include <algorithm>
#include <atomic>
#include <functional>
#include <future>
#include <mutex>
#include <thread>

#include <gmock/gmock.h>

namespace sslv::control_queue_test {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::Pair;

/// A camera that counts calls. Automatic exposure locks the exposure time and changes it on each read;
/// setting the gain ends automatic gain; a new width requires reopening; the position changes on each read.
class MeasuringCamera : public Controls {
 public:
  MeasuringCamera() {
    add("ExposureAuto", ControlKind::kChoice, "Off").choices = {"Off", "Continuous"};
    add("ExposureTime", ControlKind::kNumber, 1000.0).most = 30000;
    add("Gain", ControlKind::kInteger, 4).most = 20;
    add("GainAuto", ControlKind::kFlag, true);
    add("Position", ControlKind::kInteger, 1).moves = true;
    add("Reset", ControlKind::kAction, nullptr);
    add("Width", ControlKind::kInteger, 640).reopens = true;
  }
  std::vector<Control> list() override {
    const std::lock_guard lock(mutex_);
    ++reads;
    measure();
    return all_;
  }
  Control get(const std::string& name) override {
    const std::lock_guard lock(mutex_);
    ++reads;
    if (name == silent) throw CaptureError("does not answer");
    if (answers_ == 0) throw SettingsError("busy");
    if (answers_ > 0) --answers_;
    measure();
    return of(name);
  }
  Json value(const std::string& name) {
    const std::lock_guard lock(mutex_);
    return of(name).value;
  }
  void put(const std::string& name, const Json& value) {
    const std::lock_guard lock(mutex_);
    of(name).value = value;
  }
  void limit(const std::string& name, double most) {
    const std::lock_guard lock(mutex_);
    of(name).most = most;
  }
  void answer_only(int count) { answers_ = count; }

  std::atomic<int> reads{0}, writes{0}, resets{0};
  std::function<void()> on_write = [] {};
  std::string silent;  // a control that does not answer; empty: none

 private:
  Control& add(const char* name, ControlKind kind, const Json& value) {
    Control control;
    control.name = name;
    control.kind = kind;
    control.value = value;
    all_.push_back(control);
    return all_.back();
  }
  Control& of(const std::string& name) {
    const auto found = std::ranges::find(all_, name, &Control::name);
    if (found == all_.end()) throw SettingsError(name + ": no such control");
    return *found;
  }
  bool is_automatic() { return of("ExposureAuto").value == "Continuous"; }
  void measure() {
    if (is_automatic()) of("ExposureTime").value = of("ExposureTime").value.get<double>() + 100;
    of("ExposureTime").writable = !is_automatic();
    of("Position").value = of("Position").value.get<int>() + 1;
  }
  void write(const Control& control, const Json& value) override {
    on_write();
    const std::lock_guard lock(mutex_);
    ++writes;
    if (control.name == "Reset") ++resets;
    if (!of(control.name).writable) throw SettingsError(control.name + ": locked");
    of(control.name).value = value;
    if (control.name == "Gain") of("GainAuto").value = false;
  }
  std::mutex mutex_;
  std::vector<Control> all_;
  std::atomic<int> answers_ = -1;  // number of calls of get() that still succeed; negative: all
};

const Json kNothing = Json::object();

class ControlQueueTest : public testing::Test {
 protected:
  ControlQueueTest() {
    queue_.begin(nullptr);
    queue_.list();  // waits until begin() has read all
  }

  std::vector<std::string> unsaved(const Json& saved = kNothing) const {
    std::vector<std::string> out;
    for (const auto& one : queue_.unsaved(saved)) out.push_back(one.control.name);
    return out;
  }
  /// Saves settings. Returns what the camera refuses.
  ControlQueue::Refusals save(const Json& before, const Json& wanted) {
    queue_.plan(before, wanted, "/controls");
    return queue_.apply(before, wanted)();
  }
  std::string refusal(const Json& wanted) const {
    try {
      queue_.plan(kNothing, wanted, "/controls");
    } catch (const SettingsError& error) {
      return error.what();
    }
    return "";
  }

  const std::shared_ptr<MeasuringCamera> camera_ = std::make_shared<MeasuringCamera>();
  ControlQueue& queue_ = camera_->queue();
};

TEST_F(ControlQueueTest, ListsAndRevertsUnsavedControls) {
  EXPECT_THAT(unsaved(), IsEmpty());
  EXPECT_EQ(queue_.set("ExposureTime", 2000.0).value, 2000);
  queue_.set("ExposureTime", 3000.0);
  ASSERT_THAT(unsaved(), ElementsAre("ExposureTime"));
  EXPECT_EQ(queue_.unsaved(kNothing)[0].before, 1000) << "what it had first, not last";
  EXPECT_THAT(unsaved({{"ExposureTime", 3000.1}}), IsEmpty()) << "the camera rounds";
  queue_.revert({}, kNothing);
  EXPECT_EQ(camera_->value("ExposureTime"), 1000);
  EXPECT_THAT(unsaved(), IsEmpty());
}

TEST_F(ControlQueueTest, RevertingAnAutomaticRestoresTheValuesItChanged) {
  queue_.set("ExposureAuto", "Continuous");
  queue_.list();
  ASSERT_GT(camera_->value("ExposureTime"), 1100);
  queue_.revert({}, kNothing);
  EXPECT_EQ(camera_->value("ExposureAuto"), "Off");
  EXPECT_EQ(camera_->value("ExposureTime"), 1000);
}

TEST_F(ControlQueueTest, RestoringAnAutomaticDropsTheValueSetMeanwhile) {
  const Json saved{{"ExposureAuto", "Continuous"}};
  save(kNothing, saved);
  queue_.set("ExposureAuto", "Off");
  queue_.set("ExposureTime", 500.0);
  EXPECT_THAT(unsaved(saved), ElementsAre("ExposureAuto", "ExposureTime"));
  queue_.revert({}, saved);
  EXPECT_EQ(camera_->value("ExposureAuto"), "Continuous");
  EXPECT_THAT(unsaved(saved), IsEmpty());
}

TEST_F(ControlQueueTest, AModeThatTheCameraChangesWithAValueIsUnsavedToo) {
  queue_.set("Gain", 9);
  EXPECT_THAT(unsaved(), ElementsAre("Gain", "GainAuto"));
  queue_.revert({}, kNothing);
  EXPECT_EQ(camera_->value("GainAuto"), true);
  EXPECT_EQ(camera_->value("Gain"), 4);
}

TEST_F(ControlQueueTest, RevertsASingleControl) {
  queue_.set("ExposureTime", 2000.0);
  queue_.set("Gain", 9);
  queue_.revert({"ExposureTime"}, kNothing);
  EXPECT_EQ(camera_->value("ExposureTime"), 1000);
  EXPECT_EQ(camera_->value("Gain"), 9);
  EXPECT_THAT(unsaved(), ElementsAre("Gain", "GainAuto"));
}

TEST_F(ControlQueueTest, KeepsSavedControlsWhenRevertingAll) {
  queue_.set("ExposureTime", 2000.0);
  queue_.set("GainAuto", false);
  const Json saved{{"ExposureTime", 2000.0}};
  save(kNothing, saved);
  EXPECT_THAT(unsaved(saved), ElementsAre("GainAuto"));
  queue_.revert({}, saved);
  EXPECT_EQ(camera_->value("ExposureTime"), 2000);
  EXPECT_EQ(camera_->value("GainAuto"), true);
}

TEST_F(ControlQueueTest, RevertingALockedControlFails) {
  queue_.set("ExposureTime", 2000.0);
  queue_.set("ExposureAuto", "Continuous");
  EXPECT_THROW(queue_.revert({"ExposureTime"}, kNothing), SettingsError);
  queue_.revert({"ExposureAuto"}, kNothing);
  EXPECT_THAT(unsaved(), ElementsAre("ExposureTime"));
  queue_.revert({"ExposureTime"}, kNothing);
  EXPECT_EQ(camera_->value("ExposureTime"), 1000);
}

TEST_F(ControlQueueTest, AControlThatCannotBeReadAfterSettingIsUnsaved) {
  camera_->answer_only(1);  // the read before setting
  EXPECT_ANY_THROW(queue_.set("ExposureTime", 2000.0));
  camera_->answer_only(-1);
  EXPECT_EQ(camera_->value("ExposureTime"), 2000);
  EXPECT_THAT(unsaved(), ElementsAre("ExposureTime"));
  queue_.revert({}, kNothing);
  EXPECT_EQ(camera_->value("ExposureTime"), 1000);
}

TEST_F(ControlQueueTest, ActionsAndSelfChangingControlsAreNeverUnsaved) {
  queue_.set("Reset", nullptr);
  queue_.set("Position", 50);
  EXPECT_EQ(camera_->resets, 1);
  EXPECT_THAT(unsaved(), IsEmpty());
}

TEST_F(ControlQueueTest, ControlsThatNeedReopeningAreNotSetDirectly) {
  EXPECT_THROW(queue_.set("Width", 320), NeedsReopening);
  EXPECT_EQ(camera_->writes, 0);
  EXPECT_THAT(unsaved(), IsEmpty());
  EXPECT_TRUE(queue_.plan(kNothing, {{"Width", 320}}, "").reopens);
  EXPECT_FALSE(queue_.plan(kNothing, {{"Gain", 5}}, "").reopens);
  EXPECT_TRUE(queue_.plan({{"Width", 320}}, kNothing, "").reopens);
}

TEST_F(ControlQueueTest, APlanAsksTheCameraNothingAndRunsNoAction) {
  queue_.set("Gain", 9);
  const int reads = camera_->reads, writes = camera_->writes;
  const Json wanted{{"ExposureTime", 2000.0}, {"Reset", true}, {"ExposureAuto", "Continuous"}};
  EXPECT_THAT(queue_.plan({{"Gain", 9}}, wanted, "/controls").unsaid, ElementsAre(Pair("Gain", 4)));
  EXPECT_NE(refusal({{"Gain", 99}}), "");
  unsaved();
  queue_.refused();
  EXPECT_EQ(camera_->reads, reads);
  EXPECT_EQ(camera_->writes, writes);
  EXPECT_EQ(camera_->resets, 0);
}

TEST_F(ControlQueueTest, PlansBesideChangesLeaveNothingOnTheCamera) {
  std::atomic<bool> ends{false};
  const auto try_out = [&] {
    while (!ends) queue_.plan({{"Gain", 6}}, {{"Gain", 17}, {"Reset", true}}, "/controls");
  };
  std::thread one(try_out), other(try_out);
  Json saved = kNothing;
  for (int gain = 1; gain <= 50; ++gain) {
    const Json next{{"Gain", gain % 10}};
    save(saved, next);
    saved = next;
    EXPECT_EQ(camera_->value("Gain"), gain % 10);
  }
  ends = true;
  one.join();
  other.join();
  EXPECT_EQ(camera_->resets, 0);
}

TEST_F(ControlQueueTest, APlanRefusesWhatTheCameraDoesNotTake) {
  EXPECT_EQ(refusal({{"Colour", 1}}), "/controls/Colour: the camera has no such control");
  EXPECT_EQ(refusal({{"Gain", 99}}), "/controls/Gain: 99 is not allowed; expected a whole number to 20");
  EXPECT_EQ(refusal({{"ExposureAuto", "Often"}, {"Gain", 5}}),
            "/controls/ExposureAuto: \"Often\" is not allowed; expected one of \"Off\", \"Continuous\"");
  EXPECT_EQ(refusal({{"Gain", "much"}, {"GainAuto", false}}),
            "/controls/Gain: \"much\" is not allowed; expected a whole number");
  EXPECT_EQ(refusal({{"Gain", 99}, {"GainAuto", false}}), "")
      << "with another mode it may have another range";
}

TEST_F(ControlQueueTest, APlanBeforeTheFirstListRefusesNothing) {
  const auto opening = std::make_shared<MeasuringCamera>();
  const Json wanted{{"Colour", 1}, {"Gain", 5}};
  opening->queue().plan(kNothing, wanted, "/controls");
  EXPECT_THAT(opening->queue().apply(kNothing, wanted)(), ElementsAre("Colour: no such control"));
  EXPECT_EQ(opening->value("Gain"), 5);
}

TEST_F(ControlQueueTest, RefusedControlsAreReportedUntilAccepted) {
  save(kNothing, {{"ExposureAuto", "Continuous"}});
  const Json both{{"ExposureAuto", "Continuous"}, {"ExposureTime", 2000.0}};
  EXPECT_THAT(save({{"ExposureAuto", "Continuous"}}, both), ElementsAre("ExposureTime: locked"));
  EXPECT_THAT(queue_.refused(), ElementsAre("ExposureTime: locked"));
  save(both, {{"ExposureTime", 2000.0}});
  EXPECT_EQ(camera_->value("ExposureAuto"), "Off") << "what it had";
  EXPECT_EQ(camera_->value("ExposureTime"), 2000);
  EXPECT_THAT(queue_.refused(), IsEmpty());
}

TEST_F(ControlQueueTest, ControlsRemovedFromTheSettingsAreRestored) {
  const Json saved{{"ExposureAuto", "Continuous"}, {"Gain", 9}};
  save(kNothing, saved);
  queue_.list();
  EXPECT_THAT(save(saved, kNothing), IsEmpty());
  EXPECT_EQ(camera_->value("ExposureAuto"), "Off");
  EXPECT_EQ(camera_->value("ExposureTime"), 1000) << "the automatic had changed it";
  EXPECT_EQ(camera_->value("Gain"), 4);
  EXPECT_EQ(camera_->value("GainAuto"), true) << "the gain had ended it";
}

TEST_F(ControlQueueTest, ValuesComeBeforeModesAndAreSetAgainWhereModesLockedThem) {
  save(kNothing, {{"ExposureAuto", "Continuous"}});
  const Json wanted{{"ExposureAuto", "Off"}, {"ExposureTime", 500.0}, {"Gain", 9}, {"GainAuto", true}};
  EXPECT_THAT(save({{"ExposureAuto", "Continuous"}}, wanted), IsEmpty());
  EXPECT_EQ(camera_->value("ExposureTime"), 500);
  EXPECT_EQ(camera_->value("Gain"), 9);
  EXPECT_EQ(camera_->value("GainAuto"), true) << "it was ended by the gain, and is set again";
}

TEST_F(ControlQueueTest, ASliderMayMoveWhileAnotherBrowserSaves) {
  queue_.set("Gain", 9);
  // The other browser saves while the camera is being set.
  std::function<ControlQueue::Refusals()> saved;
  std::once_flag once;
  camera_->on_write = [&] { std::call_once(once, [&] { saved = queue_.apply(kNothing, {{"Gain", 9}}); }); };
  queue_.set("Gain", 10);
  EXPECT_THAT(saved(), IsEmpty());
  EXPECT_EQ(camera_->value("Gain"), 9) << "one after the other";
  EXPECT_THAT(unsaved({{"Gain", 9}}), ElementsAre("GainAuto"));
}

TEST_F(ControlQueueTest, AnUnresponsiveCameraDoesNotBlockSaving) {
  std::promise<void> answer;
  camera_->on_write = [answered = answer.get_future().share()] { answered.wait(); };
  const auto outcome = queue_.apply(kNothing, {{"Gain", 9}});  // does not wait
  queue_.ask_to_stop();
  EXPECT_THROW(outcome(), CaptureError);
  answer.set_value();
}

/// Makes `camera` the reopened `before`, with the saved controls and otherwise the values of `before`.
void reopen(MeasuringCamera& camera, MeasuringCamera& before, const Json& saved) {
  for (const Control& control : before.list()) {
    if (control.kind != ControlKind::kAction && !control.reopens && control.writable)
      camera.put(control.name, control.value);
  }
  EXPECT_THAT(camera.queue().open_with(saved), IsEmpty());
  camera.queue().begin(before.shared_from_this());
  camera.queue().list();  // begun
}

TEST_F(ControlQueueTest, UnsavedControlsStayUnsavedIfTheCameraKeptThem) {
  const auto first = std::make_shared<MeasuringCamera>();
  first->queue().set("Gain", 9);
  reopen(*camera_, *first, kNothing);
  EXPECT_THAT(unsaved(), IsEmpty()) << "only where it begins";
  const auto second = std::make_shared<MeasuringCamera>();
  reopen(*second, *first, kNothing);
  EXPECT_EQ(second->queue().unsaved(kNothing).size(), 2u);
  second->queue().revert({}, kNothing);
  EXPECT_EQ(second->value("Gain"), 4);
  EXPECT_EQ(second->value("GainAuto"), true);
}

TEST_F(ControlQueueTest, ACameraThatLostItsValuesHasNothingUnsaved) {
  queue_.set("Gain", 9);
  const auto second = std::make_shared<MeasuringCamera>();
  second->queue().begin(camera_);
  second->queue().list();
  EXPECT_THAT(second->queue().unsaved(kNothing), IsEmpty());
  EXPECT_EQ(second->value("Gain"), 4);
}

TEST_F(ControlQueueTest, KnowsWhatTheCameraHadBeforeItWasSavedAtAnEarlierOpening) {
  const Json saved{{"ExposureTime", 2000.0}};
  const auto goes_back_to = [&](MeasuringCamera& camera) {
    return camera.queue().plan(saved, kNothing, "").unsaid.at("ExposureTime");
  };
  save(kNothing, saved);
  const auto second = std::make_shared<MeasuringCamera>();
  reopen(*second, *camera_, saved);
  EXPECT_EQ(goes_back_to(*second), 1000);
  const auto reset = std::make_shared<MeasuringCamera>();
  reset->put("ExposureTime", 500.0);  // after a power loss
  EXPECT_THAT(reset->queue().open_with(saved), IsEmpty());
  reset->queue().begin(second);
  reset->queue().list();
  EXPECT_EQ(goes_back_to(*reset), 500);
}

TEST_F(ControlQueueTest, RefusalsOfRemovedControlsAreForgotten) {
  const Json unknown = {{"Colour", 1}};
  EXPECT_THAT(queue_.apply(kNothing, unknown)(), ElementsAre("Colour: no such control"));
  EXPECT_THAT(queue_.refused(), ElementsAre("Colour: no such control"));
  EXPECT_THAT(queue_.apply(unknown, kNothing)(), IsEmpty());
  EXPECT_THAT(queue_.refused(), IsEmpty());
}

TEST_F(ControlQueueTest, AnUnresponsiveControlDoesNotBlockOthers) {
  camera_->silent = "ExposureTime";
  const Json wanted = {{"ExposureTime", 2000.0}, {"Gain", 5}};
  EXPECT_THAT(queue_.open_with(wanted), ElementsAre("ExposureTime: does not answer"));
  EXPECT_EQ(camera_->value("Gain"), 5);
  EXPECT_THAT(save(kNothing, {{"ExposureTime", 2000.0}, {"Gain", 6}}),
              ElementsAre("ExposureTime: does not answer"));
  EXPECT_EQ(camera_->value("Gain"), 6);
}

TEST_F(ControlQueueTest, AnOutdatedRangeRefusesNothing) {
  for (const int gain : {5, 6, 7}) queue_.set("Gain", gain);
  camera_->limit("ExposureTime", 60000);
  EXPECT_EQ(refusal({{"ExposureTime", 50000.0}}), "");
  queue_.list();
  EXPECT_EQ(refusal({{"ExposureTime", 50000.0}}), "");
  EXPECT_NE(refusal({{"ExposureTime", 70000.0}}), "");
}

}  // namespace
}  // namespace sslv::control_queue_test
