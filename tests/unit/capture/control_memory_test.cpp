// SPDX-License-Identifier: Apache-2.0
#include "capture/control_memory.h"

#include <algorithm>

#include <gmock/gmock.h>

namespace sslv {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

/// Its automatic exposure measures whenever somebody reads and locks the time; setting the gain ends the
/// automatic gain; a width needs the camera reopened; the position goes on by itself.
class MeasuringCamera : public Controls {
 public:
  MeasuringCamera() {
    add("ExposureAuto", ControlKind::kChoice, "Off").choices = {"Off", "Continuous"};
    add("ExposureTime", ControlKind::kNumber, 1000.0);
    add("Gain", ControlKind::kInteger, 4).most = 20;
    add("GainAuto", ControlKind::kFlag, true);
    add("Position", ControlKind::kInteger, 1).moves = true;
    add("Reset", ControlKind::kAction, nullptr);
    add("Width", ControlKind::kInteger, 640);
  }
  std::vector<Control> list() override {
    measure();
    return all_;
  }
  Control get(const std::string& name) override {
    if (answers_ == 0) throw SettingsError("busy");
    if (answers_ > 0) --answers_;
    measure();
    return of(name);
  }
  Json value(const std::string& name) { return of(name).value; }
  void put(const std::string& name, const Json& value) { of(name).value = value; }
  void answer_only(int count) { answers_ = count; }

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
  ControlEffect write(const Control& control, const Json& value) override {
    if (control.name == "Width") return ControlEffect::kWhenOpened;
    if (!of(control.name).writable) throw SettingsError(control.name + ": locked");
    of(control.name).value = value;
    if (control.name == "Gain") of("GainAuto").value = false;
    return ControlEffect::kAtOnce;
  }
  std::vector<Control> all_;
  int answers_ = -1;  // that still come to get(); negative: all
};

const Json kNothing = Json::object();

std::vector<std::string> unsaved(Controls& camera, const Json& saved = kNothing) {
  std::vector<std::string> out;
  for (const auto& one : camera.memory().unsaved(saved)) out.push_back(one.control.name);
  return out;
}

TEST(ControlMemory, KnowsWhatIsSetAndNotSavedAndSetsItBack) {
  MeasuringCamera camera;
  EXPECT_THAT(unsaved(camera), IsEmpty());
  EXPECT_EQ(camera.memory().set_unsaved("ExposureTime", 2000.0).value, 2000);
  camera.memory().set_unsaved("ExposureTime", 3000.0);
  ASSERT_THAT(unsaved(camera), ElementsAre("ExposureTime"));
  EXPECT_EQ(camera.memory().unsaved(kNothing)[0].before, 1000) << "what it had first, not last";
  EXPECT_THAT(unsaved(camera, {{"ExposureTime", 3000.1}}), IsEmpty()) << "the camera rounds";
  camera.memory().revert({});
  EXPECT_EQ(camera.value("ExposureTime"), 1000);
  EXPECT_THAT(unsaved(camera), IsEmpty());
}

TEST(ControlMemory, AnAutomaticTakesWithItWhatItHasChanged) {
  MeasuringCamera camera;
  camera.memory().set_unsaved("ExposureAuto", "Continuous");
  camera.list();
  ASSERT_GT(camera.value("ExposureTime"), 1100);
  camera.memory().revert({});
  EXPECT_EQ(camera.value("ExposureAuto"), "Off");
  EXPECT_EQ(camera.value("ExposureTime"), 1000);
}

TEST(ControlMemory, AValueThatWasSetUnderAnAutomaticEndsWithIt) {
  MeasuringCamera camera;
  camera.memory().set_unsaved("ExposureAuto", "Continuous");
  camera.memory().forget({{"ExposureAuto", "Continuous"}});  // saved
  camera.memory().set_unsaved("ExposureAuto", "Off");
  camera.memory().set_unsaved("ExposureTime", 500.0);
  EXPECT_THAT(unsaved(camera), ElementsAre("ExposureAuto", "ExposureTime"));
  camera.memory().revert({});
  EXPECT_EQ(camera.value("ExposureAuto"), "Continuous");
  EXPECT_THAT(unsaved(camera), IsEmpty());
}

TEST(ControlMemory, AModeThatTheCameraChangesWithAValueIsUnsavedToo) {
  MeasuringCamera camera;
  camera.memory().set_unsaved("Gain", 9);
  EXPECT_THAT(unsaved(camera), ElementsAre("Gain", "GainAuto"));
  camera.memory().revert({});
  EXPECT_EQ(camera.value("GainAuto"), true);
  EXPECT_EQ(camera.value("Gain"), 4);
}

TEST(ControlMemory, OneOfSeveralGoesBack) {
  MeasuringCamera camera;
  camera.memory().set_unsaved("ExposureTime", 2000.0);
  camera.memory().set_unsaved("Gain", 9);
  camera.memory().revert({"ExposureTime"});
  EXPECT_EQ(camera.value("ExposureTime"), 1000);
  EXPECT_EQ(camera.value("Gain"), 9);
  EXPECT_THAT(unsaved(camera), ElementsAre("Gain", "GainAuto"));
}

TEST(ControlMemory, WhatWasSavedIsNotSetBackWithTheRest) {
  MeasuringCamera camera;
  camera.memory().set_unsaved("ExposureTime", 2000.0);
  camera.memory().set_unsaved("GainAuto", false);
  camera.memory().forget({{"ExposureTime", 2000.0}});
  EXPECT_THAT(unsaved(camera, {{"ExposureTime", 2000.0}}), ElementsAre("GainAuto"));
  camera.memory().revert({});
  EXPECT_EQ(camera.value("ExposureTime"), 2000);
  EXPECT_EQ(camera.value("GainAuto"), true);
}

TEST(ControlMemory, OneThatIsLockedIsNotSaidToBeSetBack) {
  MeasuringCamera camera;
  camera.memory().set_unsaved("ExposureTime", 2000.0);
  camera.memory().set_unsaved("ExposureAuto", "Continuous");
  EXPECT_THROW(camera.memory().revert({"ExposureTime"}), SettingsError);
  camera.memory().revert({"ExposureAuto"});
  EXPECT_THAT(unsaved(camera), ElementsAre("ExposureTime"));
  camera.memory().revert({"ExposureTime"});
  EXPECT_EQ(camera.value("ExposureTime"), 1000);
}

TEST(ControlMemory, OneThatWasSetIsRememberedAlsoWhenItCannotBeRead) {
  MeasuringCamera camera;
  camera.answer_only(2);  // before it is set
  EXPECT_ANY_THROW(camera.memory().set_unsaved("ExposureTime", 2000.0));
  camera.answer_only(-1);
  EXPECT_EQ(camera.value("ExposureTime"), 2000);
  EXPECT_THAT(unsaved(camera), ElementsAre("ExposureTime"));
  camera.memory().revert({});
  EXPECT_EQ(camera.value("ExposureTime"), 1000);
}

/// The camera was closed and opened again with its saved controls, and has the values of `before` else.
void reopen(MeasuringCamera& camera, MeasuringCamera& before, const Json& saved) {
  for (const Control& control : before.list()) {
    if (control.kind != ControlKind::kAction && control.name != "Width" && control.writable)
      camera.put(control.name, control.value);
  }
  EXPECT_THAT(apply_controls(camera, saved), IsEmpty());
  camera.memory().inherit(before.memory());
}

TEST(ControlMemory, ACameraThatIsReopenedAndKeptItsValuesHasThemUnsavedStill) {
  MeasuringCamera first, second;
  first.memory().set_unsaved("Gain", 9);
  reopen(second, first, kNothing);
  EXPECT_THAT(unsaved(second), ElementsAre("Gain", "GainAuto"));
  second.memory().revert({});
  EXPECT_EQ(second.value("Gain"), 4);
  EXPECT_EQ(second.value("GainAuto"), true);
}

TEST(ControlMemory, ACameraThatLostItsValuesHasNothingUnsaved) {
  MeasuringCamera first, second;
  first.memory().set_unsaved("Gain", 9);
  second.memory().inherit(first.memory());
  EXPECT_THAT(unsaved(second), IsEmpty());
  EXPECT_EQ(second.value("Gain"), 4);
}

TEST(ControlMemory, KnowsWhatTheCameraHadBeforeItWasSavedAtAnEarlierOpening) {
  MeasuringCamera first, second, reset;
  first.set("ExposureTime", 2000.0);
  reopen(second, first, {{"ExposureTime", 2000.0}});
  EXPECT_EQ(second.memory().when_opened("ExposureTime"), Json(1000.0));
  reset.put("ExposureTime", 500.0);  // it lost its power
  EXPECT_THAT(apply_controls(reset, {{"ExposureTime", 2000.0}}), IsEmpty());
  reset.memory().inherit(second.memory());
  EXPECT_EQ(reset.memory().when_opened("ExposureTime"), Json(500.0));
}

TEST(ControlMemory, ActionsAndWhatGoesOnByItselfAreNeverUnsaved) {
  MeasuringCamera camera;
  camera.memory().set_unsaved("Reset", nullptr);
  camera.memory().set_unsaved("Position", 50);
  EXPECT_THAT(unsaved(camera), IsEmpty());
}

TEST(ControlMemory, WhatNeedsTheCameraReopenedIsRefused) {
  MeasuringCamera camera;
  EXPECT_THROW(camera.memory().set_unsaved("Width", 320), NeedsReopening);
  EXPECT_THAT(unsaved(camera), IsEmpty());
}

TEST(ControlMemory, KnowsWhatTheCameraHadAtTheOpening) {
  MeasuringCamera camera;
  EXPECT_EQ(camera.memory().when_opened("Gain"), std::nullopt);
  camera.set("Gain", 6);  // as the settings say, at the opening
  camera.set("Gain", 8);
  EXPECT_EQ(camera.memory().when_opened("Gain"), Json(4));
  camera.memory().read_once();
  EXPECT_EQ(camera.memory().when_opened("ExposureTime"), Json(1000.0));
}

}  // namespace
}  // namespace sslv
