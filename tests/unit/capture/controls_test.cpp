// SPDX-License-Identifier: Apache-2.0
#include "capture/controls.h"

#include "base/error.h"
#include "capture/control_queue.h"

#include <map>

#include <gmock/gmock.h>

namespace sslv::controls_test {
namespace {

using ::testing::ElementsAre;

/// A camera whose gain can be set only while automatic gain is off.
class FakeControls : public Controls {
 public:
  FakeControls() {
    Control control;
    control.name = "AutoGain";
    control.kind = ControlKind::kFlag;
    control.value = true;
    all_["AutoGain"] = control;
    control.name = "A_Gain";  // comes first by name
    control.kind = ControlKind::kInteger;
    control.least = 0;
    control.most = 20;
    control.step = 2;
    control.unit = "dB";
    control.value = 4;
    all_["A_Gain"] = control;
    control = {};
    control.name = "Mode";
    control.kind = ControlKind::kChoice;
    control.choices = {"Off", "Once"};
    control.value = "Off";
    all_["Mode"] = control;
  }
  std::vector<Control> list() override {
    std::vector<Control> out;
    for (const auto& [name, control] : all_) out.push_back(control);
    return out;
  }
  Control get(const std::string& name) override {
    if (!all_.contains(name)) throw SettingsError(name + ": no such control");
    return all_.at(name);
  }

 private:
  void write(const Control& control, const Json& value) override {
    if (control.name == "A_Gain" && all_["AutoGain"].value == true)
      throw SettingsError("A_Gain: refused while it is automatic");
    all_[control.name].value = value;
  }
  std::map<std::string, Control> all_;
};

std::string refusal(Controls& controls, const char* name, const Json& value) {
  try {
    controls.set(name, value);
  } catch (const SettingsError& error) {
    return error.what();
  }
  return "no error";
}

TEST(Controls, AreSetInAWorkingOrder) {
  FakeControls controls;
  EXPECT_THAT(controls.queue().open_with({{"A_Gain", 6}, {"AutoGain", false}}), ElementsAre());
  EXPECT_EQ(controls.get("A_Gain").value, 6);
}

TEST(Controls, RefusedControlsAreNamedAndTheRestIsSet) {
  FakeControls controls;
  EXPECT_THAT(controls.queue().open_with({{"A_Gain", 6}, {"Mode", "Once"}, {"Bright", 1}}),
              ElementsAre("A_Gain: refused while it is automatic", "Bright: no such control"));
  EXPECT_EQ(controls.get("Mode").value, "Once");
}

TEST(Controls, SayWhatTheyTake) {
  FakeControls controls;
  const std::string gain = "is not allowed; expected a whole number from 0 to 20 in steps of 2 dB";
  for (const Json& value : {Json(22), Json(-2), Json(3), Json(1.5), Json("4"), Json(nullptr), Json::array()})
    EXPECT_EQ(refusal(controls, "A_Gain", value), "A_Gain: " + value.dump() + " " + gain);
  EXPECT_EQ(refusal(controls, "AutoGain", 1), "AutoGain: 1 is not allowed; expected true or false");
  EXPECT_EQ(refusal(controls, "Mode", "Often"),
            "Mode: \"Often\" is not allowed; expected one of \"Off\", \"Once\"");
}

TEST(Controls, AsJson) {
  FakeControls controls;
  const Json json = control_json(controls.get("A_Gain"));
  EXPECT_EQ(json["kind"], "integer");
  EXPECT_EQ(json["min"], 0);
  EXPECT_EQ(json["max"], 20);
  EXPECT_EQ(json["step"], 2);
  EXPECT_EQ(json["value"], 4);
  EXPECT_EQ(json["level"], "beginner");
  EXPECT_EQ(control_json(controls.get("Mode"))["choices"], Json({"Off", "Once"}));
}

}  // namespace
}  // namespace sslv::controls_test
