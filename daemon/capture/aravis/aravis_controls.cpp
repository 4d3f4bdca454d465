// SPDX-License-Identifier: Apache-2.0
#include "capture/aravis/aravis_controls.h"

#include "base/error.h"
#include "capture/source.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include <fmt/format.h>

namespace sslv {
namespace {

/// Features that change the image size, so that the stream's buffers no longer fit.
constexpr std::array<std::string_view, 8> kLayout{"Width",
                                                  "Height",
                                                  "PixelFormat",
                                                  "BinningHorizontal",
                                                  "BinningVertical",
                                                  "DecimationHorizontal",
                                                  "DecimationVertical",
                                                  "SensorBinning"};

/// Hidden: the source itself starts and stops the acquisition.
constexpr std::array<std::string_view, 5> kOurs{"AcquisitionStart", "AcquisitionStop", "AcquisitionAbort",
                                                "AcquisitionMode", "TLParamsLocked"};

/// Selectors whose choices all have independent values, such as red and blue for the white balance. Each
/// choice becomes its own control, "BalanceRatio[Red]", which can be saved and restored. Features of other
/// selectors are shown for the current choice.
constexpr std::array<std::string_view, 3> kSplit{"BalanceRatioSelector", "GainSelector",
                                                 "BlackLevelSelector"};

template <std::size_t N>
bool is_one_of(const std::array<std::string_view, N>& names, std::string_view name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

std::optional<double> finite(double value) {
  // For a feature without limits, drivers report the limits of the number's type.
  const bool is_limit = !std::isfinite(value) || std::abs(value) >= 9e18;
  return is_limit ? std::nullopt : std::optional(value);
}

std::vector<std::string> choices_of(ArvGcEnumeration* node) {
  std::vector<std::string> out;
  guint count = 0;
  const std::unique_ptr<const char*, void (*)(void*)> names(
      arv_gc_enumeration_dup_available_string_values(node, &count, nullptr), g_free);
  for (guint i = 0; names && i < count; ++i) out.emplace_back(names.get()[i]);
  return out;
}

/// Sets a selector to a choice for this object's lifetime. Throws SettingsError if the camera refuses.
class Selected {
 public:
  Selected(ArvGcEnumeration* selector, const std::string& choice) : selector_(selector) {
    Failure failure;
    before_ = text_or_empty(arv_gc_enumeration_get_string_value(selector_, failure));
    if (before_ != choice) arv_gc_enumeration_set_string_value(selector_, choice.c_str(), failure);
    if (failure.failed())
      throw SettingsError(fmt::format("{}: {} cannot be selected", choice, failure.text()));
  }
  ~Selected() { arv_gc_enumeration_set_string_value(selector_, before_.c_str(), nullptr); }
  Selected(const Selected&) = delete;
  Selected& operator=(const Selected&) = delete;

 private:
  ArvGcEnumeration* const selector_;
  std::string before_;
};

class AravisControls final : public Controls {
 public:
  explicit AravisControls(std::shared_ptr<AravisCamera> camera) : camera_(std::move(camera)) {}

  std::vector<Control> list() override {
    const std::lock_guard lock(camera_->mutex);
    std::vector<Control> out;
    std::set<std::string> seen;  // a feature may be in several categories
    find_selectors_once();
    add_category(genicam(), "Root", "", seen, out);
    return out;
  }

  Control get(const std::string& name) override {
    const std::lock_guard lock(camera_->mutex);
    const Place place = place_of(name);
    if (place.selector == nullptr) return whole_control_of(place.node, "");
    const Selected selected(place.selector, place.choice);
    return selected_control_of(place.node, "", place.choice);
  }

 private:
  /// Location of a control: a feature, possibly at one choice of a selector.
  struct Place {
    ArvGcFeatureNode* node;
    ArvGcEnumeration* selector;  // null without a selector
    std::string choice;
  };

  Place place_of(const std::string& name) {
    find_selectors_once();
    const std::size_t open = name.ends_with(']') ? name.find('[') : std::string::npos;
    if (open == std::string::npos) return {node_of(name), nullptr, ""};
    const std::string choice = name.substr(open + 1, name.size() - open - 2);
    ArvGcFeatureNode* node = node_of(name.substr(0, open));
    ArvGcEnumeration* selector = splitting(node);
    if (selector != nullptr) {
      for (const std::string& one : choices_of(selector))
        if (one == choice) return {node, selector, choice};
    }
    throw SettingsError(fmt::format("{}: the camera has no such control", name));
  }

  /// Must not run during an iteration over a category's features: Aravis rebuilds that list on every request.
  void find_selectors_once() {
    if (std::exchange(knows_selectors_, true)) return;
    std::set<std::string> seen;
    find_selectors(genicam(), "Root", seen);
  }

  /// The selector that this feature depends on; null if none.
  ArvGcFeatureNode* selector_of(ArvGcFeatureNode* node) const {
    const auto found = selectors_.find(text_or_empty(arv_gc_feature_node_get_name(node)));
    return found == selectors_.end() ? nullptr : found->second;
  }

  void find_selectors(ArvGc* genicam, const char* name, std::set<std::string>& seen) {
    ArvGcNode* node = arv_gc_get_node(genicam, name);
    if (node == nullptr || !seen.insert(name).second) return;
    const GSList* inside = nullptr;
    if (ARV_IS_GC_CATEGORY(node)) inside = arv_gc_category_get_features(ARV_GC_CATEGORY(node));
    for (; inside != nullptr; inside = inside->next)
      find_selectors(genicam, static_cast<const char*>(inside->data), seen);
    if (!ARV_IS_GC_SELECTOR(node) || !arv_gc_selector_is_selector(ARV_GC_SELECTOR(node))) return;
    for (const GSList* one = arv_gc_selector_get_selected_features(ARV_GC_SELECTOR(node)); one != nullptr;
         one = one->next) {
      const auto* feature = ARV_GC_FEATURE_NODE(one->data);
      selectors_.emplace(text_or_empty(arv_gc_feature_node_get_name(const_cast<ArvGcFeatureNode*>(feature))),
                         ARV_GC_FEATURE_NODE(node));
    }
  }

  /// Whether each choice of this selector has its own controls.
  static bool is_split(ArvGcFeatureNode* selector) {
    return ARV_IS_GC_ENUMERATION(selector) &&
           is_one_of(kSplit, text_or_empty(arv_gc_feature_node_get_name(selector))) &&
           arv_gc_feature_node_is_available(selector, nullptr) &&
           arv_gc_feature_node_get_actual_access_mode(selector) != ARV_GC_ACCESS_MODE_RO &&
           choices_of(ARV_GC_ENUMERATION(selector)).size() > 1;
  }

  /// The selector whose choices split this feature into several controls; null if the feature is one control.
  ArvGcEnumeration* splitting(ArvGcFeatureNode* node) const {
    ArvGcFeatureNode* selector = ARV_IS_GC_COMMAND(node) ? nullptr : selector_of(node);
    return selector != nullptr && is_split(selector) ? ARV_GC_ENUMERATION(selector) : nullptr;
  }

  /// The control of an unsplit feature. A selector with only one choice does not count as a dependency.
  Control whole_control_of(ArvGcFeatureNode* node, const std::string& category) const {
    Control out = control_of(node, category);
    ArvGcFeatureNode* selector = selector_of(node);
    const bool is_selected = selector != nullptr && !(ARV_IS_GC_ENUMERATION(selector) &&
                                                      choices_of(ARV_GC_ENUMERATION(selector)).size() == 1);
    out.depends =
        is_selected || (ARV_IS_GC_SELECTOR(node) && arv_gc_selector_is_selector(ARV_GC_SELECTOR(node)));
    return out;
  }

  Control selected_control_of(ArvGcFeatureNode* node, const std::string& category,
                              const std::string& choice) const {
    Control out = control_of(node, category);
    out.name += fmt::format("[{}]", choice);
    if (!out.title.empty()) out.title += fmt::format(" ({})", choice);
    return out;
  }

  void add_feature(ArvGcFeatureNode* node, const std::string& category, std::vector<Control>& out) const {
    if (is_split(node)) return;
    ArvGcEnumeration* selector = splitting(node);
    if (selector == nullptr) {
      out.push_back(whole_control_of(node, category));
      return;
    }
    for (const std::string& choice : choices_of(selector)) {
      try {
        const Selected selected(selector, choice);
        out.push_back(selected_control_of(node, category, choice));
      } catch (const SettingsError&) {
        continue;  // the camera does not permit this choice now
      }
    }
  }

  ArvGc* genicam() const {
    if (camera_->is_closed) throw CaptureError("the camera was closed");
    return arv_device_get_genicam(arv_camera_get_device(camera_->camera.get()));
  }

  ArvGcFeatureNode* node_of(const std::string& name) const {
    ArvGcNode* node = arv_gc_get_node(genicam(), name.c_str());
    if (node == nullptr || !ARV_IS_GC_FEATURE_NODE(node) || !is_shown(ARV_GC_FEATURE_NODE(node)))
      throw SettingsError(fmt::format("{}: the camera has no such control", name));
    return ARV_GC_FEATURE_NODE(node);
  }

  /// Whether the camera implements this feature and shows it to users.
  static bool is_shown(ArvGcFeatureNode* node) {
    const bool is_kind = ARV_IS_GC_COMMAND(node) || ARV_IS_GC_ENUMERATION(node) || ARV_IS_GC_BOOLEAN(node) ||
                         ARV_IS_GC_STRING(node) || ARV_IS_GC_FLOAT(node) || ARV_IS_GC_INTEGER(node);
    return is_kind && !ARV_IS_GC_CATEGORY(node) &&
           !is_one_of(kOurs, text_or_empty(arv_gc_feature_node_get_name(node))) &&
           arv_gc_feature_node_get_visibility(node) != ARV_GC_VISIBILITY_INVISIBLE &&
           arv_gc_feature_node_is_implemented(node, nullptr);
  }

  void add_category(ArvGc* genicam, const char* name, const std::string& title, std::set<std::string>& seen,
                    std::vector<Control>& out) const {
    ArvGcNode* node = arv_gc_get_node(genicam, name);
    if (node == nullptr || !seen.insert(name).second) return;
    if (ARV_IS_GC_CATEGORY(node)) {
      const std::string here = text_or_empty(arv_gc_feature_node_get_display_name(ARV_GC_FEATURE_NODE(node)));
      for (const GSList* one = arv_gc_category_get_features(ARV_GC_CATEGORY(node)); one != nullptr;
           one = one->next) {
        add_category(genicam, static_cast<const char*>(one->data), here.empty() ? name : here, seen, out);
      }
    } else if (ARV_IS_GC_FEATURE_NODE(node) && is_shown(ARV_GC_FEATURE_NODE(node))) {
      add_feature(ARV_GC_FEATURE_NODE(node), title, out);
    }
  }

  Control control_of(ArvGcFeatureNode* node, const std::string& category) const {
    Control out;
    out.name = text_or_empty(arv_gc_feature_node_get_name(node));
    out.title = text_or_empty(arv_gc_feature_node_get_display_name(node));
    out.category = category;
    out.help = text_or_empty(arv_gc_feature_node_get_description(node));
    if (out.help.empty()) out.help = text_or_empty(arv_gc_feature_node_get_tooltip(node));
    const ArvGcVisibility visibility = arv_gc_feature_node_get_visibility(node);
    out.level = visibility == ARV_GC_VISIBILITY_GURU     ? ControlLevel::kGuru
                : visibility == ARV_GC_VISIBILITY_EXPERT ? ControlLevel::kExpert
                                                         : ControlLevel::kBeginner;
    const bool is_available = arv_gc_feature_node_is_available(node, nullptr);
    out.writable = is_available && arv_gc_feature_node_get_actual_access_mode(node) != ARV_GC_ACCESS_MODE_RO;
    fill_kind(node, is_available, out);
    out.reopens = camera_->is_streaming &&
                  (is_one_of(kLayout, out.name) || arv_gc_feature_node_is_locked(node, nullptr) != FALSE);
    return out;
  }

  /// Unavailable features get no value and no range.
  static void fill_kind(ArvGcFeatureNode* node, bool is_available, Control& out) {
    Failure failure;
    const auto set = [&](Json value) {
      if (!failure.failed()) out.value = std::move(value);
    };
    // The order matters: Aravis's enumerations are also integers.
    if (ARV_IS_GC_COMMAND(node)) {
      out.kind = ControlKind::kAction;
    } else if (ARV_IS_GC_ENUMERATION(node)) {
      out.kind = ControlKind::kChoice;
      if (!is_available) return;
      out.choices = choices_of(ARV_GC_ENUMERATION(node));
      set(text_or_empty(arv_gc_enumeration_get_string_value(ARV_GC_ENUMERATION(node), failure)));
    } else if (ARV_IS_GC_BOOLEAN(node)) {
      out.kind = ControlKind::kFlag;
      if (is_available) set(arv_gc_boolean_get_value(ARV_GC_BOOLEAN(node), failure) != FALSE);
    } else if (ARV_IS_GC_FLOAT(node)) {
      ArvGcFloat* number = ARV_GC_FLOAT(node);
      out.kind = ControlKind::kNumber;
      out.unit = text_or_empty(arv_gc_float_get_unit(number));
      if (!is_available) return;
      if (const double least = arv_gc_float_get_min(number, failure); !failure.failed())
        out.least = finite(least);
      if (const double most = arv_gc_float_get_max(number, failure); !failure.failed())
        out.most = finite(most);
      const double value = arv_gc_float_get_value(number, failure);
      set(value);
    } else if (ARV_IS_GC_INTEGER(node)) {
      ArvGcInteger* number = ARV_GC_INTEGER(node);
      out.kind = ControlKind::kInteger;
      out.unit = text_or_empty(arv_gc_integer_get_unit(number));
      if (!is_available) return;
      const auto limit = [&](gint64 value) {
        return failure.failed() ? std::nullopt : finite(static_cast<double>(value));
      };
      const gint64 least = arv_gc_integer_get_min(number, failure);
      out.least = limit(least);
      const gint64 most = arv_gc_integer_get_max(number, failure);
      out.most = limit(most);
      const gint64 step = arv_gc_integer_get_inc(number, failure);
      if (!failure.failed() && step > 0) out.step = static_cast<double>(step);
      const gint64 value = arv_gc_integer_get_value(number, failure);
      set(value);
    } else {
      out.kind = ControlKind::kText;
      if (is_available) set(text_or_empty(arv_gc_string_get_value(ARV_GC_STRING(node), failure)));
    }
  }

  void write(const Control& control, const Json& value) override {
    const std::lock_guard lock(camera_->mutex);
    const Place place = place_of(control.name);
    ArvGcFeatureNode* node = place.node;
    std::optional<Selected> selected;
    if (place.selector != nullptr) selected.emplace(place.selector, place.choice);
    if (!control.writable)
      throw SettingsError(fmt::format("{}: cannot be set now: it is read-only", control.name));
    Failure failure;
    switch (control.kind) {
      case ControlKind::kAction: arv_gc_command_execute(ARV_GC_COMMAND(node), failure); break;
      case ControlKind::kFlag:
        arv_gc_boolean_set_value(ARV_GC_BOOLEAN(node), value.get<bool>(), failure);
        break;
      case ControlKind::kChoice:
        arv_gc_enumeration_set_string_value(ARV_GC_ENUMERATION(node), value.get<std::string>().c_str(),
                                            failure);
        break;
      case ControlKind::kNumber:
        arv_gc_float_set_value(ARV_GC_FLOAT(node), value.get<double>(), failure);
        break;
      case ControlKind::kInteger:
        arv_gc_integer_set_value(ARV_GC_INTEGER(node), value.get<gint64>(), failure);
        break;
      case ControlKind::kText:
        arv_gc_string_set_value(ARV_GC_STRING(node), value.get<std::string>().c_str(), failure);
        break;
    }
    if (failure.failed())
      throw SettingsError(fmt::format("{}: {} refused: {}", control.name, json_text(value), failure.text()));
    read_exposure(*camera_);
  }

  const std::shared_ptr<AravisCamera> camera_;
  std::map<std::string, ArvGcFeatureNode*> selectors_;  // by feature name
  bool knows_selectors_ = false;                        // guarded by the camera's mutex, like selectors_
};

}  // namespace

std::shared_ptr<Controls> aravis_controls(std::shared_ptr<AravisCamera> camera) {
  return std::make_shared<AravisControls>(std::move(camera));
}

void read_exposure(AravisCamera& camera) {
  Failure failure;
  const double exposure_us = arv_camera_get_exposure_time(camera.camera.get(), failure);
  bool asks_again = failure.is_unanswered();
  if (!asks_again) {
    camera.exposure_s = failure.failed() || !(exposure_us > 0) ? 0 : exposure_us * 1e-6;
    asks_again = arv_camera_is_exposure_auto_available(camera.camera.get(), failure) != FALSE &&
                 arv_camera_get_exposure_time_auto(camera.camera.get(), failure) != ARV_AUTO_OFF &&
                 !failure.failed();
  }
  camera.may_exposure_change = asks_again || failure.is_unanswered();
}

}  // namespace sslv
