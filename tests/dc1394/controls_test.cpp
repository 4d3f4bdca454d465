// SPDX-License-Identifier: Apache-2.0
#include "capture/controls.h"

#include "dc1394/iidc_camera.h"

#include <algorithm>

namespace sslv {
namespace {

using fake_iidc::Feature;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class IidcControls : public IidcCamera {
 protected:
  void SetUp() override {
    IidcCamera::SetUp();
    source_ = open();
    controls_ = source_->controls();
  }
  void TearDown() override {
    source_.reset();
    IidcCamera::TearDown();
  }

  static Feature feature(dc1394feature_t id) { return fake_iidc::state_of(kGuid).features.at(id); }
  void change(const std::function<void(fake_iidc::Camera&)>& how) {
    source_.reset();
    fake_iidc::Camera camera = fake_iidc::league_camera(kGuid);
    how(camera);
    fake_iidc::clear();
    fake_iidc::plug_in(camera);
    source_ = open();
    controls_ = source_->controls();
  }
  std::string refusal(const std::string& name, const Json& value) {
    try {
      controls_->set(name, value);
    } catch (const SettingsError& error) {
      return error.what();
    } catch (const CaptureError& error) {
      return std::string("lost: ") + error.what();
    }
    return "no error";
  }
  bool has(const std::string& name) {
    const std::vector<Control> all = controls_->list();
    return std::any_of(all.begin(), all.end(), [&](const Control& c) { return c.name == name; });
  }

  std::unique_ptr<Source> source_;
  std::shared_ptr<Controls> controls_;
};

TEST_F(IidcControls, AreWhatTheCameraSaysItHas) {
  std::vector<std::string> names;
  for (const Control& control : controls_->list()) names.push_back(control.name);
  EXPECT_THAT(names,
              ElementsAre("shutter_mode", "shutter", "shutter_absolute", "gain_mode", "gain", "exposure",
                          "brightness", "gamma_on", "gamma", "white_balance_mode", "white_balance_blue_u",
                          "white_balance_red_v", "white_shading_red", "white_shading_green",
                          "white_shading_blue", "frame_rate", "frame_rate_absolute", "trigger_delay_on",
                          "trigger_delay", "trigger_on", "trigger_mode", "trigger_source", "trigger_polarity",
                          "trigger_software", "temperature", "temperature_now", "memory_load_0",
                          "memory_load_1", "memory_save_1", "memory_load_2", "memory_save_2"));
}

TEST_F(IidcControls, ValuesHaveTheirRange) {
  const Control shutter = controls_->get("shutter");
  EXPECT_EQ(shutter.kind, ControlKind::kInteger);
  EXPECT_EQ(shutter.value, 200);
  EXPECT_EQ(shutter.least, 1);
  EXPECT_EQ(shutter.most, 4095);
  EXPECT_EQ(refusal("shutter", 5000), "shutter: 5000 is not allowed; expected a whole number from 1 to 4095");
  EXPECT_EQ(refusal("shutter", 300), "no error");
  EXPECT_EQ(feature(DC1394_FEATURE_SHUTTER).values[0], 300U);
  EXPECT_FALSE(feature(DC1394_FEATURE_SHUTTER).absolute_on);
}

TEST_F(IidcControls, AbsoluteValuesHaveTheirUnit) {
  const Control shutter = controls_->get("shutter_absolute");
  EXPECT_EQ(shutter.kind, ControlKind::kNumber);
  EXPECT_EQ(shutter.unit, "s");
  EXPECT_NEAR(shutter.value.get<double>(), 0.004, 1e-6);
  EXPECT_NEAR(shutter.most.value(), 0.1, 1e-6);
  EXPECT_EQ(refusal("shutter_absolute", 0.002), "no error");
  EXPECT_FLOAT_EQ(feature(DC1394_FEATURE_SHUTTER).absolute_value, 0.002F);
  EXPECT_TRUE(feature(DC1394_FEATURE_SHUTTER).absolute_on);
}

TEST_F(IidcControls, ModesAreWhatTheFeatureOffers) {
  EXPECT_THAT(controls_->get("gain_mode").choices, ElementsAre("manual", "auto", "one_push"));
  EXPECT_EQ(controls_->get("gain_mode").value, "auto");
  EXPECT_FALSE(controls_->get("gain").writable);
  EXPECT_EQ(refusal("gain", 10), "gain: 10 refused: gain_mode is auto");
  EXPECT_EQ(refusal("gain_mode", "manual"), "no error");
  EXPECT_EQ(refusal("gain", 10), "no error");
  EXPECT_EQ(feature(DC1394_FEATURE_GAIN).values[0], 10U);
  EXPECT_EQ(refusal("gain_mode", "one_push"), "no error");
  EXPECT_EQ(controls_->get("gain").value, 77);
  EXPECT_FALSE(has("brightness_mode"));  // it has only one mode
}

TEST_F(IidcControls, SwitchesAreFlags) {
  EXPECT_EQ(controls_->get("gamma_on").value, true);
  EXPECT_EQ(refusal("gamma_on", false), "no error");
  EXPECT_FALSE(feature(DC1394_FEATURE_GAMMA).on);
  EXPECT_EQ(refusal("gamma", 1), "gamma: 1 refused: gamma_on is false");
}

TEST_F(IidcControls, WhiteBalanceHasTwoValuesAndShadingThree) {
  EXPECT_EQ(controls_->get("white_balance_blue_u").value, 284);
  EXPECT_EQ(controls_->get("white_balance_red_v").value, 230);
  EXPECT_EQ(refusal("white_balance_red_v", 240), "no error");
  EXPECT_THAT(feature(DC1394_FEATURE_WHITE_BALANCE).values, ElementsAre(284, 240, 0));
  EXPECT_EQ(refusal("white_balance_blue_u", 100), "no error");
  EXPECT_THAT(feature(DC1394_FEATURE_WHITE_BALANCE).values, ElementsAre(100, 240, 0));
  EXPECT_EQ(refusal("white_shading_green", 9), "no error");
  EXPECT_EQ(refusal("white_shading_blue", 8), "no error");
  EXPECT_THAT(feature(DC1394_FEATURE_WHITE_SHADING).values, ElementsAre(0, 9, 8));
}

TEST_F(IidcControls, TemperatureHasATargetAndIsMeasured) {
  EXPECT_EQ(controls_->get("temperature").value, 100);
  EXPECT_EQ(controls_->get("temperature_now").value, 312);
  EXPECT_EQ(refusal("temperature", 120), "no error");
  EXPECT_EQ(feature(DC1394_FEATURE_TEMPERATURE).values[0], 120U);
  EXPECT_EQ(refusal("temperature_now", 1), "temperature_now: 1 refused: measured, read-only");
}

TEST_F(IidcControls, TriggerHasAllItsParts) {
  EXPECT_THAT(controls_->get("trigger_mode").choices, ElementsAre("mode_0", "mode_1", "mode_15"));
  EXPECT_THAT(controls_->get("trigger_source").choices, ElementsAre("source_0", "software"));
  EXPECT_EQ(controls_->get("trigger_polarity").value, "active_low");
  EXPECT_EQ(refusal("trigger_mode", "mode_15"), "no error");
  EXPECT_EQ(refusal("trigger_source", "software"), "no error");
  EXPECT_EQ(refusal("trigger_polarity", "active_high"), "no error");
  EXPECT_EQ(refusal("trigger_on", true), "no error");
  const Feature trigger = feature(DC1394_FEATURE_TRIGGER);
  EXPECT_EQ(trigger.trigger_mode, DC1394_TRIGGER_MODE_15);
  EXPECT_EQ(trigger.source, DC1394_TRIGGER_SOURCE_SOFTWARE);
  EXPECT_EQ(trigger.polarity, DC1394_TRIGGER_ACTIVE_HIGH);
  EXPECT_TRUE(trigger.on);
  EXPECT_FALSE(feature(DC1394_FEATURE_TRIGGER_DELAY).on);  // unaffected, despite its similar name
}

TEST_F(IidcControls, SoftwareTriggerTakesAPicture) {
  controls_->set("trigger_software", nullptr);
  next_picture(*source_);
}

TEST_F(IidcControls, MemoryIsLoadedAndSaved) {
  controls_->set("memory_save_2", nullptr);
  EXPECT_EQ(fake_iidc::state_of(kGuid).saved_channel, 2);
  controls_->set("memory_load_0", nullptr);
  EXPECT_EQ(fake_iidc::state_of(kGuid).loaded_channel, 0);
}

TEST_F(IidcControls, WhatCannotBeReadIsNull) {
  change([](fake_iidc::Camera& camera) { camera.features[DC1394_FEATURE_FOCUS].readable = false; });
  EXPECT_TRUE(controls_->get("focus").value.is_null());
  EXPECT_EQ(refusal("focus", 4), "no error");
}

TEST_F(IidcControls, EveryFeatureOfIidcIsThere) {
  change([](fake_iidc::Camera& camera) {
    for (int id = DC1394_FEATURE_MIN; id <= DC1394_FEATURE_MAX; ++id)
      camera.features.try_emplace(static_cast<dc1394feature_t>(id));
  });
  for (const char* name : {"brightness",
                           "exposure",
                           "sharpness",
                           "white_balance_blue_u",
                           "hue",
                           "saturation",
                           "gamma",
                           "shutter",
                           "gain",
                           "iris",
                           "focus",
                           "temperature",
                           "trigger_on",
                           "trigger_delay",
                           "white_shading_red",
                           "frame_rate",
                           "zoom",
                           "pan",
                           "tilt",
                           "optical_filter",
                           "capture_size",
                           "capture_quality"}) {
    EXPECT_TRUE(has(name)) << name;
  }
}

TEST_F(IidcControls, TheCamerasRefusalIsTold) {
  change([](fake_iidc::Camera& camera) {
    camera.features[DC1394_FEATURE_IRIS].refusal = DC1394_REQ_VALUE_OUTSIDE_RANGE;
  });
  EXPECT_EQ(refusal("iris", 4), "iris: refused: Requested value is out of range");
  EXPECT_EQ(refusal("zoom", 4), "zoom: the camera has no such control");
}

TEST_F(IidcControls, AreSetInAnyOrderWhenOpened) {
  source_.reset();
  source_ = open(
      {{"controls", {{"gain", 33}, {"gamma", 1}, {"zoom", 3}, {"gain_mode", "manual"}, {"gamma_on", true}}}});
  EXPECT_EQ(feature(DC1394_FEATURE_GAIN).values[0], 33U);
  EXPECT_THAT(source_->warnings(), ElementsAre("zoom: the camera has no such control"));
}

TEST_F(IidcControls, LiveOnWhenTheCameraIsClosed) {
  source_.reset();
  EXPECT_EQ(refusal("gain_mode", "manual"), "lost: camera \"000a470112345678\": is closed");
  EXPECT_THROW(controls_->list(), CaptureError);
}

TEST_F(IidcControls, AnUnpluggedCameraDoesNotAnswer) {
  fake_iidc::unplug(kGuid);
  EXPECT_EQ(refusal("brightness", 1), "lost: camera \"000a470112345678\": no longer answers");
  EXPECT_THROW(controls_->list(), CaptureError);
}

}  // namespace
}  // namespace sslv
