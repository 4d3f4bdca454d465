// SPDX-License-Identifier: Apache-2.0
#include "capture/dc1394/dc1394_controls.h"

#include "base/error.h"
#include "capture/source.h"

#include <algorithm>
#include <array>
#include <utility>

#include <fmt/format.h>

namespace sslv::iidc {
namespace {

struct FeatureRow {
  dc1394feature_t id;
  std::string_view name, title, category;
  std::string_view unit;  // unit of the absolute value (IIDC 1.31, table 4.11)
  ControlLevel level;
  std::string_view help;
};

constexpr ControlLevel kBeginner = ControlLevel::kBeginner, kExpert = ControlLevel::kExpert;

constexpr std::array kFeatures{
    FeatureRow{DC1394_FEATURE_SHUTTER, "shutter", "Shutter", "Light", "s", kBeginner, "exposure time"},
    FeatureRow{DC1394_FEATURE_GAIN, "gain", "Gain", "Light", "dB", kBeginner, ""},
    FeatureRow{DC1394_FEATURE_IRIS, "iris", "Iris", "Light", "F", kBeginner, ""},
    FeatureRow{DC1394_FEATURE_EXPOSURE, "exposure", "Automatic exposure", "Light", "EV", kBeginner,
               "target brightness of automatic shutter, gain and iris"},
    FeatureRow{DC1394_FEATURE_BRIGHTNESS, "brightness", "Brightness", "Light", "%", kBeginner,
               "the black level"},
    FeatureRow{DC1394_FEATURE_GAMMA, "gamma", "Gamma", "Light", "", kExpert, ""},
    FeatureRow{DC1394_FEATURE_WHITE_BALANCE, "white_balance", "White balance", "Colour", "K", kBeginner, ""},
    FeatureRow{DC1394_FEATURE_SATURATION, "saturation", "Saturation", "Colour", "%", kBeginner, ""},
    FeatureRow{DC1394_FEATURE_HUE, "hue", "Hue", "Colour", "deg", kExpert, ""},
    FeatureRow{DC1394_FEATURE_WHITE_SHADING, "white_shading", "White shading", "Colour", "", kExpert, ""},
    FeatureRow{DC1394_FEATURE_SHARPNESS, "sharpness", "Sharpness", "Image", "", kExpert, ""},
    FeatureRow{DC1394_FEATURE_FOCUS, "focus", "Focus", "Lens", "m", kExpert, ""},
    FeatureRow{DC1394_FEATURE_ZOOM, "zoom", "Zoom", "Lens", "x", kExpert, ""},
    FeatureRow{DC1394_FEATURE_PAN, "pan", "Pan", "Lens", "deg", kExpert, ""},
    FeatureRow{DC1394_FEATURE_TILT, "tilt", "Tilt", "Lens", "deg", kExpert, ""},
    FeatureRow{DC1394_FEATURE_OPTICAL_FILTER, "optical_filter", "Optical filter", "Lens", "", kExpert, ""},
    FeatureRow{DC1394_FEATURE_FRAME_RATE, "frame_rate", "Frame rate", "Timing", "Hz", kExpert, ""},
    FeatureRow{DC1394_FEATURE_TRIGGER_DELAY, "trigger_delay", "Trigger delay", "Timing", "s", kExpert, ""},
    FeatureRow{DC1394_FEATURE_TRIGGER, "trigger", "Trigger", "Timing", "", kExpert, ""},
    FeatureRow{DC1394_FEATURE_TEMPERATURE, "temperature", "Temperature", "Image", "", kExpert,
               "target temperature of the sensor"},
    FeatureRow{DC1394_FEATURE_CAPTURE_SIZE, "capture_size", "Capture size", "Image", "", kExpert, ""},
    FeatureRow{DC1394_FEATURE_CAPTURE_QUALITY, "capture_quality", "Capture quality", "Image", "", kExpert,
               ""},
};

constexpr std::array kFeatureModes{
    Named<dc1394feature_mode_t>{"manual", DC1394_FEATURE_MODE_MANUAL},
    Named<dc1394feature_mode_t>{"auto", DC1394_FEATURE_MODE_AUTO},
    Named<dc1394feature_mode_t>{"one_push", DC1394_FEATURE_MODE_ONE_PUSH_AUTO},
};
constexpr std::array kTriggerModes{
    Named<dc1394trigger_mode_t>{"mode_0", DC1394_TRIGGER_MODE_0},
    Named<dc1394trigger_mode_t>{"mode_1", DC1394_TRIGGER_MODE_1},
    Named<dc1394trigger_mode_t>{"mode_2", DC1394_TRIGGER_MODE_2},
    Named<dc1394trigger_mode_t>{"mode_3", DC1394_TRIGGER_MODE_3},
    Named<dc1394trigger_mode_t>{"mode_4", DC1394_TRIGGER_MODE_4},
    Named<dc1394trigger_mode_t>{"mode_5", DC1394_TRIGGER_MODE_5},
    Named<dc1394trigger_mode_t>{"mode_14", DC1394_TRIGGER_MODE_14},
    Named<dc1394trigger_mode_t>{"mode_15", DC1394_TRIGGER_MODE_15},
};
constexpr std::array kTriggerSources{
    Named<dc1394trigger_source_t>{"source_0", DC1394_TRIGGER_SOURCE_0},
    Named<dc1394trigger_source_t>{"source_1", DC1394_TRIGGER_SOURCE_1},
    Named<dc1394trigger_source_t>{"source_2", DC1394_TRIGGER_SOURCE_2},
    Named<dc1394trigger_source_t>{"source_3", DC1394_TRIGGER_SOURCE_3},
    Named<dc1394trigger_source_t>{"software", DC1394_TRIGGER_SOURCE_SOFTWARE},
};
constexpr std::array kPolarities{
    Named<dc1394trigger_polarity_t>{"active_low", DC1394_TRIGGER_ACTIVE_LOW},
    Named<dc1394trigger_polarity_t>{"active_high", DC1394_TRIGGER_ACTIVE_HIGH},
};

template <class Table>
auto value_in(const Table& table, const Json& name) {
  return std::find_if(table.begin(), table.end(),
                      [&](const auto& row) { return row.name == name.get_ref<const std::string&>(); })
      ->value;
}

constexpr std::string_view kLoad = "memory_load_", kSave = "memory_save_";

bool answers(dc1394camera_t* camera) {
  dc1394switch_t on{};
  return dc1394_video_get_transmission(camera, &on) == DC1394_SUCCESS;
}

dc1394switch_t switch_of(const Json& flag) {
  return flag.get<bool>() ? DC1394_ON : DC1394_OFF;
}

class IidcControls final : public Controls {
 public:
  explicit IidcControls(std::shared_ptr<Link> link) : link_(std::move(link)) {}

  std::vector<Control> list() override {
    const std::lock_guard lock(link_->mutex);
    std::vector<Control> out;
    for (const FeatureRow& row : kFeatures) append_feature(out, row);
    append_memory(out);
    return out;
  }

  Control get(const std::string& name) override {
    const std::lock_guard lock(link_->mutex);
    std::vector<Control> some;
    for (const FeatureRow& row : kFeatures) {
      if (name.starts_with(row.name)) append_feature(some, row);
    }
    append_memory(some);
    const auto found =
        std::find_if(some.begin(), some.end(), [&](const Control& c) { return c.name == name; });
    if (found == some.end()) throw SettingsError(fmt::format("{}: the camera has no such control", name));
    return *found;
  }

 protected:
  void write(const Control& control, const Json& value) override {
    const std::lock_guard lock(link_->mutex);
    if (!control.writable) {
      throw SettingsError(fmt::format("{}: {} refused: {}", control.name, json_text(value),
                                      control.help.empty() ? "it cannot be set now" : control.help));
    }
    if (control.name.starts_with(kLoad) || control.name.starts_with(kSave)) return use_memory(control);
    // Find the longest matching name: "trigger_delay" also begins with "trigger".
    const FeatureRow* row = nullptr;
    for (const FeatureRow& one : kFeatures) {
      if (control.name.starts_with(one.name) && (row == nullptr || one.name.size() > row->name.size()))
        row = &one;
    }
    const std::string_view part = std::string_view(control.name).substr(row->name.size());
    must(row->id == DC1394_FEATURE_TRIGGER ? set_trigger(part, value) : set_feature(row->id, part, value),
         control.name);
    if (row->id == DC1394_FEATURE_SHUTTER || row->id == DC1394_FEATURE_TRIGGER)
      link_->exposure_s = exposure_s_of(camera()).value_or(0);
  }

 private:
  dc1394camera_t* camera() const {
    if (link_->camera == nullptr) throw CaptureError(fmt::format("camera \"{}\": is closed", link_->label));
    return link_->camera;
  }

  void must(dc1394error_t error, std::string_view name) const {
    if (error == DC1394_SUCCESS) return;
    if (!answers(camera())) throw CaptureError(fmt::format("camera \"{}\": no longer answers", link_->label));
    throw SettingsError(fmt::format("{}: refused: {}", name, dc1394_error_get_string(error)));
  }

  // ---- reading

  void append_feature(std::vector<Control>& out, const FeatureRow& row) const {
    dc1394feature_info_t info{};
    info.id = row.id;
    must(dc1394_feature_get(camera(), &info), row.name);
    if (info.available != DC1394_TRUE) return;
    if (info.on_off_capable == DC1394_TRUE)
      add(out, row, "_on", ControlKind::kFlag).value = info.is_on == DC1394_ON;
    if (row.id == DC1394_FEATURE_TRIGGER) return append_trigger(out, row, info);
    if (info.modes.num > 1) {
      Control& mode = add(out, row, "_mode", ControlKind::kChoice);
      mode.value = name_in(kFeatureModes, info.current_mode);
      for (std::uint32_t i = 0; i < info.modes.num; ++i)
        mode.choices.emplace_back(name_in(kFeatureModes, info.modes.modes[i]));
    }
    append_values(out, row, info);
    if (info.absolute_capable != DC1394_TRUE) return;
    Control& absolute = add(out, row, "_absolute", ControlKind::kNumber);
    absolute.unit = row.unit;
    absolute.least = info.abs_min;
    absolute.most = info.abs_max;
    if (info.readout_capable == DC1394_TRUE) absolute.value = info.abs_value;
    lock_if_automatic(absolute, row, info);
  }

  void append_values(std::vector<Control>& out, const FeatureRow& row,
                     const dc1394feature_info_t& info) const {
    std::uint32_t a = 0, b = 0, c = 0;
    const auto value = [&](std::string_view part, std::uint32_t now) -> Control& {
      Control& control = add(out, row, part, ControlKind::kInteger);
      control.least = info.min;
      control.most = info.max;
      if (info.readout_capable == DC1394_TRUE) control.value = now;
      lock_if_automatic(control, row, info);
      return control;
    };
    switch (row.id) {
      case DC1394_FEATURE_WHITE_BALANCE:
        must(dc1394_feature_whitebalance_get_value(camera(), &a, &b), row.name);
        value("_blue_u", a);
        value("_red_v", b);
        return;
      case DC1394_FEATURE_WHITE_SHADING:
        must(dc1394_feature_whiteshading_get_value(camera(), &a, &b, &c), row.name);
        value("_red", a);
        value("_green", b);
        value("_blue", c);
        return;
      case DC1394_FEATURE_TEMPERATURE: {
        must(dc1394_feature_temperature_get_value(camera(), &a, &b), row.name);
        value("", a);
        Control& now = value("_now", b);
        now.help = "measured, read-only";
        now.writable = false;
        return;
      }
      default: value("", info.value);
    }
  }

  void append_trigger(std::vector<Control>& out, const FeatureRow& row,
                      const dc1394feature_info_t& info) const {
    if (info.trigger_modes.num > 0) {
      Control& mode = add(out, row, "_mode", ControlKind::kChoice);
      mode.help = "mode_0 exposes for the shutter's time, mode_1 for as long as the pulse";
      mode.value = name_in(kTriggerModes, info.trigger_mode);
      for (std::uint32_t i = 0; i < info.trigger_modes.num; ++i)
        mode.choices.emplace_back(name_in(kTriggerModes, info.trigger_modes.modes[i]));
    }
    bool by_software = false;
    if (info.trigger_sources.num > 0) {
      Control& source = add(out, row, "_source", ControlKind::kChoice);
      source.value = name_in(kTriggerSources, info.trigger_source);
      for (std::uint32_t i = 0; i < info.trigger_sources.num; ++i) {
        source.choices.emplace_back(name_in(kTriggerSources, info.trigger_sources.sources[i]));
        by_software |= info.trigger_sources.sources[i] == DC1394_TRIGGER_SOURCE_SOFTWARE;
      }
    }
    if (info.polarity_capable == DC1394_TRUE) {
      dc1394trigger_polarity_t polarity{};  // dc1394_feature_get() numbers polarities differently
      must(dc1394_external_trigger_get_polarity(camera(), &polarity), row.name);
      Control& control = add(out, row, "_polarity", ControlKind::kChoice);
      control.value = name_in(kPolarities, polarity);
      for (const auto& [name, value] : kPolarities) control.choices.emplace_back(name);
    }
    if (by_software) add(out, row, "_software", ControlKind::kAction).help = "take one image now";
  }

  void append_memory(std::vector<Control>& out) const {
    const auto action = [&](std::string_view name, int channel, std::string help) {
      Control control;
      control.name = fmt::format("{}{}", name, channel);
      control.title = fmt::format("{} settings {}", name == kLoad ? "Load" : "Save", channel);
      control.category = "Memory";
      control.help = std::move(help);
      control.kind = ControlKind::kAction;
      control.level = ControlLevel::kGuru;
      out.push_back(std::move(control));
    };
    const int most = camera()->max_mem_channel;
    if (most <= 0) return;
    action(kLoad, 0, "the factory settings; reopens the camera");
    for (int channel = 1; channel <= most; ++channel) {
      action(kLoad, channel, "reopens the camera");
      action(kSave, channel, "wears out the camera's memory slightly");
    }
  }

  static Control& add(std::vector<Control>& out, const FeatureRow& row, std::string_view part,
                      ControlKind kind) {
    Control control;
    control.name = fmt::format("{}{}", row.name, part);
    control.title = row.title;
    for (const char c : part) control.title += c == '_' ? ' ' : c;
    control.category = row.category;
    if (part.empty() || part == "_absolute") control.help = row.help;
    control.kind = kind;
    control.level = row.level;
    return out.emplace_back(std::move(control));
  }

  /// Locks a value that the camera sets automatically or does not use.
  static void lock_if_automatic(Control& control, const FeatureRow& row, const dc1394feature_info_t& info) {
    const bool off = info.on_off_capable == DC1394_TRUE && info.is_on != DC1394_ON;
    const bool automatic = info.modes.num > 0 && info.current_mode == DC1394_FEATURE_MODE_AUTO;
    if (!off && !automatic) return;
    control.writable = false;
    control.help = off ? fmt::format("{}_on is false", row.name) : fmt::format("{}_mode is auto", row.name);
  }

  // ---- writing

  dc1394error_t set_feature(dc1394feature_t id, std::string_view part, const Json& value) const {
    if (part == "_on") return dc1394_feature_set_power(camera(), id, switch_of(value));
    if (part == "_mode") return dc1394_feature_set_mode(camera(), id, value_in(kFeatureModes, value));
    // A register selects whether the camera uses the absolute or the raw value.
    const bool absolute = part == "_absolute";
    dc1394bool_t has_absolute = DC1394_FALSE;
    dc1394error_t error = dc1394_feature_has_absolute_control(camera(), id, &has_absolute);
    if (error == DC1394_SUCCESS && has_absolute == DC1394_TRUE)
      error = dc1394_feature_set_absolute_control(camera(), id, absolute ? DC1394_ON : DC1394_OFF);
    if (error != DC1394_SUCCESS) return error;
    if (absolute) return dc1394_feature_set_absolute_value(camera(), id, value.get<float>());
    const auto number = value.get<std::uint32_t>();
    std::uint32_t a = 0, b = 0, c = 0;
    switch (id) {
      case DC1394_FEATURE_WHITE_BALANCE:
        error = dc1394_feature_whitebalance_get_value(camera(), &a, &b);
        if (error != DC1394_SUCCESS) return error;
        (part == "_blue_u" ? a : b) = number;
        return dc1394_feature_whitebalance_set_value(camera(), a, b);
      case DC1394_FEATURE_WHITE_SHADING:
        error = dc1394_feature_whiteshading_get_value(camera(), &a, &b, &c);
        if (error != DC1394_SUCCESS) return error;
        (part == "_red" ? a : part == "_green" ? b : c) = number;
        return dc1394_feature_whiteshading_set_value(camera(), a, b, c);
      case DC1394_FEATURE_TEMPERATURE: return dc1394_feature_temperature_set_value(camera(), number);
      default: return dc1394_feature_set_value(camera(), id, number);
    }
  }

  dc1394error_t set_trigger(std::string_view part, const Json& value) const {
    if (part == "_on") return dc1394_external_trigger_set_power(camera(), switch_of(value));
    if (part == "_mode") return dc1394_external_trigger_set_mode(camera(), value_in(kTriggerModes, value));
    if (part == "_source")
      return dc1394_external_trigger_set_source(camera(), value_in(kTriggerSources, value));
    if (part == "_polarity")
      return dc1394_external_trigger_set_polarity(camera(), value_in(kPolarities, value));
    return dc1394_software_trigger_set_power(camera(), DC1394_ON);
  }

  /// Loading a memory channel may also change the video mode, which the source does not notice.
  void use_memory(const Control& control) const {
    const bool load = control.name.starts_with(kLoad);
    const auto channel = static_cast<std::uint32_t>(std::stoul(control.name.substr(kLoad.size())));
    must(load ? dc1394_memory_load(camera(), channel) : dc1394_memory_save(camera(), channel), control.name);
  }

  const std::shared_ptr<Link> link_;
};

static_assert(kLoad.size() == kSave.size());

}  // namespace

std::shared_ptr<Controls> make_controls(std::shared_ptr<Link> link) {
  return std::make_shared<IidcControls>(std::move(link));
}

std::optional<double> exposure_s_of(dc1394camera_t* camera) {
  dc1394feature_info_t shutter{}, trigger{};
  shutter.id = DC1394_FEATURE_SHUTTER;
  trigger.id = DC1394_FEATURE_TRIGGER;
  if (dc1394_feature_get(camera, &shutter) != DC1394_SUCCESS || shutter.available != DC1394_TRUE ||
      shutter.absolute_capable != DC1394_TRUE || shutter.readout_capable != DC1394_TRUE ||
      shutter.current_mode == DC1394_FEATURE_MODE_AUTO || !(shutter.abs_value > 0)) {
    return std::nullopt;
  }
  // In trigger modes other than 0, the shutter does not determine the exposure time.
  if (dc1394_feature_get(camera, &trigger) == DC1394_SUCCESS && trigger.available == DC1394_TRUE &&
      trigger.is_on == DC1394_ON && trigger.trigger_mode != DC1394_TRIGGER_MODE_0) {
    return std::nullopt;
  }
  return shutter.abs_value;
}

bool waits_for_trigger(dc1394camera_t* camera) {
  dc1394bool_t there = DC1394_FALSE;
  dc1394switch_t on = DC1394_OFF;
  return dc1394_feature_is_present(camera, DC1394_FEATURE_TRIGGER, &there) == DC1394_SUCCESS &&
         there == DC1394_TRUE && dc1394_external_trigger_get_power(camera, &on) == DC1394_SUCCESS &&
         on == DC1394_ON;
}

}  // namespace sslv::iidc
