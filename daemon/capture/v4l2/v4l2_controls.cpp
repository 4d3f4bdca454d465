// SPDX-License-Identifier: Apache-2.0
#include "capture/v4l2/v4l2_controls.h"

#include "base/error.h"
#include "capture/source.h"

#include <algorithm>
#include <cerrno>
#include <string_view>
#include <utility>

#include <fmt/format.h>

namespace sslv {
namespace {

/// The name as in v4l2-ctl: "White Balance, Automatic" is white_balance_automatic.
std::string key_of(std::string_view title) {
  std::string out;
  bool gap = false;
  for (const char c : title) {
    const bool upper = c >= 'A' && c <= 'Z';
    if (upper || (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9')) {
      if (gap && !out.empty()) out += '_';
      gap = false;
      out += upper ? static_cast<char>(c - 'A' + 'a') : c;
    } else {
      gap = true;
    }
  }
  return out;
}

std::string title_of(const v4l2_query_ext_ctrl& asked) {
  return {asked.name, std::find(asked.name, asked.name + sizeof asked.name, '\0')};
}

/// Empty for types that cannot be shown (matrices, codec parameters).
std::optional<ControlKind> kind_of(std::uint32_t type) {
  switch (type) {
    case V4L2_CTRL_TYPE_INTEGER:
    case V4L2_CTRL_TYPE_INTEGER64:
    case V4L2_CTRL_TYPE_BITMASK: return ControlKind::kInteger;
    case V4L2_CTRL_TYPE_BOOLEAN: return ControlKind::kFlag;
    case V4L2_CTRL_TYPE_MENU:
    case V4L2_CTRL_TYPE_INTEGER_MENU: return ControlKind::kChoice;
    case V4L2_CTRL_TYPE_BUTTON: return ControlKind::kAction;
    case V4L2_CTRL_TYPE_STRING: return ControlKind::kText;
    default: return std::nullopt;
  }
}

/// The unit of a control, defined for few controls (linux/v4l2-controls.h); otherwise empty.
std::string unit_of(std::uint32_t id) {
  if (id == V4L2_CID_EXPOSURE_ABSOLUTE) return "100 us";
  return id == V4L2_CID_WHITE_BALANCE_TEMPERATURE ? "K" : "";
}

ControlLevel level_of(std::uint32_t id) {
  const auto group = V4L2_CTRL_ID2CLASS(id);
  const bool usual = group == V4L2_CTRL_CLASS_USER || group == V4L2_CTRL_CLASS_CAMERA;
  return usual && !V4L2_CTRL_DRIVER_PRIV(id) ? ControlLevel::kBeginner : ControlLevel::kExpert;
}

/// Makes a request with one control. Returns the errno, or 0.
int call_with(V4l2Device& device, unsigned long request, v4l2_ext_control& one) {
  v4l2_ext_controls all{};
  all.which = V4L2_CTRL_WHICH_CUR_VAL;
  all.count = 1;
  all.controls = &one;
  return device.call(request, &all);
}

bool is_writable(const v4l2_query_ext_ctrl& asked) {
  constexpr __u32 kFixed = V4L2_CTRL_FLAG_READ_ONLY | V4L2_CTRL_FLAG_INACTIVE | V4L2_CTRL_FLAG_GRABBED;
  return (asked.flags & kFixed) == 0;
}

[[noreturn]] void refuse(const Control& control, const Json& value, std::string_view why) {
  throw SettingsError(fmt::format("{}: {} refused: {}", control.name, json_text(value), why));
}

}  // namespace

V4l2Controls::V4l2Controls(std::shared_ptr<V4l2Device> device) : device_(std::move(device)) {
  std::string category;
  for (std::uint32_t id = 0;;) {
    v4l2_query_ext_ctrl asked{};
    asked.id = id | V4L2_CTRL_FLAG_NEXT_CTRL;
    if (device_->call(VIDIOC_QUERY_EXT_CTRL, &asked) != 0 || asked.id <= id) break;
    id = asked.id;
    if (asked.type == V4L2_CTRL_TYPE_CTRL_CLASS) category = title_of(asked);
    if (!kind_of(asked.type) || (asked.flags & V4L2_CTRL_FLAG_DISABLED) != 0) continue;
    std::string name = key_of(title_of(asked));
    const auto same = [&](const Entry& entry) { return entry.name == name; };
    if (std::any_of(entries_.begin(), entries_.end(), same)) name += fmt::format("_{:x}", id);
    entries_.push_back({std::move(name), category, id});
  }
}

void V4l2Controls::close() {
  const std::lock_guard lock(mutex_);
  device_.reset();
}

V4l2Device& V4l2Controls::device() const {
  if (!device_) throw CaptureError("the camera is closed");
  return *device_;
}

std::vector<Control> V4l2Controls::list() {
  const std::lock_guard lock(mutex_);
  std::vector<Control> out;
  out.reserve(entries_.size());
  for (const Entry& entry : entries_) out.push_back(describe(entry));
  return out;
}

Control V4l2Controls::get(const std::string& name) {
  const std::lock_guard lock(mutex_);
  return describe(entry_of(name));
}

const V4l2Controls::Entry& V4l2Controls::entry_of(const std::string& name) const {
  const auto found =
      std::find_if(entries_.begin(), entries_.end(), [&](const Entry& entry) { return entry.name == name; });
  if (found == entries_.end()) throw SettingsError(name + ": the camera has no such control");
  return *found;
}

v4l2_query_ext_ctrl V4l2Controls::query(std::uint32_t id) const {
  v4l2_query_ext_ctrl asked{};
  asked.id = id;
  if (const int error = device().call(VIDIOC_QUERY_EXT_CTRL, &asked); error != 0)
    throw CaptureError("the camera does not answer: " + errno_text(error));
  return asked;
}

Control V4l2Controls::describe(const Entry& entry) const {
  const v4l2_query_ext_ctrl asked = query(entry.id);
  Control out;
  out.name = entry.name;
  out.title = title_of(asked);
  out.category = entry.category;
  out.unit = unit_of(entry.id);
  out.kind = kind_of(asked.type).value_or(ControlKind::kInteger);
  out.level = level_of(entry.id);
  if (out.kind == ControlKind::kInteger) {
    const bool mask = asked.type == V4L2_CTRL_TYPE_BITMASK;
    out.least = mask ? 0.0 : static_cast<double>(asked.minimum);
    out.most = static_cast<double>(mask ? static_cast<__u32>(asked.maximum) : asked.maximum);
    out.step = mask ? 1.0 : static_cast<double>(asked.step);
  }
  std::vector<std::int64_t> numbers;
  if (out.kind == ControlKind::kChoice) out.choices = menu(asked, numbers);
  if ((asked.flags & V4L2_CTRL_FLAG_WRITE_ONLY) == 0) out.value = read(asked);
  if (out.kind == ControlKind::kChoice && !out.value.is_null()) {
    const auto found = std::find(numbers.begin(), numbers.end(), out.value.get<std::int64_t>());
    out.value = found == numbers.end() ? Json(nullptr)
                                       : Json(out.choices[static_cast<std::size_t>(found - numbers.begin())]);
  }
  out.writable = is_writable(asked);
  return out;
}

/// Returns the choices, and their kernel numbers in `numbers`. Numbers that the kernel skips are not allowed.
std::vector<std::string> V4l2Controls::menu(const v4l2_query_ext_ctrl& asked,
                                            std::vector<std::int64_t>& numbers) const {
  std::vector<std::string> out;
  for (std::int64_t i = asked.minimum; i <= asked.maximum; ++i) {
    v4l2_querymenu item{};
    item.id = asked.id;
    item.index = static_cast<__u32>(i);
    if (device().call(VIDIOC_QUERYMENU, &item) != 0) continue;
    if (asked.type == V4L2_CTRL_TYPE_INTEGER_MENU) {
      const std::int64_t value = item.value;  // the kernel's struct is packed
      out.push_back(std::to_string(value));
    } else {
      const __u8* text = item.name;
      out.emplace_back(text, std::find(text, text + sizeof item.name, 0));
    }
    numbers.push_back(i);
  }
  return out;
}

/// Null if the control cannot be read now or has no value.
Json V4l2Controls::read(const v4l2_query_ext_ctrl& asked) const {
  if (asked.type == V4L2_CTRL_TYPE_BUTTON) return nullptr;
  v4l2_ext_control one{};
  one.id = asked.id;
  std::string text;
  if (asked.type == V4L2_CTRL_TYPE_STRING) {
    text.resize(asked.elem_size);
    one.size = asked.elem_size;
    one.string = text.data();
  }
  if (const int error = call_with(device(), VIDIOC_G_EXT_CTRLS, one); error == ENODEV) {
    throw CaptureError("the camera does not answer: " + errno_text(error));
  } else if (error != 0) {
    return nullptr;
  }
  switch (asked.type) {
    case V4L2_CTRL_TYPE_STRING: return text.c_str();
    case V4L2_CTRL_TYPE_BOOLEAN: return one.value != 0;
    case V4L2_CTRL_TYPE_INTEGER64: return std::int64_t{one.value64};
    case V4L2_CTRL_TYPE_BITMASK: return static_cast<std::uint32_t>(one.value);
    default: return std::int32_t{one.value};
  }
}

void V4l2Controls::write(const Control& control, const Json& value) {
  const std::lock_guard lock(mutex_);
  const v4l2_query_ext_ctrl asked = query(entry_of(control.name).id);
  if (!is_writable(asked)) {
    refuse(control, value,
           (asked.flags & V4L2_CTRL_FLAG_READ_ONLY) != 0 ? "it is read-only"
           : (asked.flags & V4L2_CTRL_FLAG_GRABBED) != 0
               ? "the camera does not allow it while it delivers images"
               : "another control sets it, such as an automatic mode");
  }
  v4l2_ext_control one{};
  one.id = asked.id;
  std::string text;
  switch (control.kind) {
    case ControlKind::kAction: break;
    case ControlKind::kFlag: one.value = value.get<bool>(); break;
    case ControlKind::kText:
      text = value.get<std::string>();
      if (text.size() >= asked.elem_size) refuse(control, value, "it is too long");
      one.size = asked.elem_size;
      text.resize(asked.elem_size);
      one.string = text.data();
      break;
    case ControlKind::kChoice: {
      std::vector<std::int64_t> numbers;
      const std::vector<std::string> choices = menu(asked, numbers);
      const auto found = std::find(choices.begin(), choices.end(), value.get<std::string>());
      if (found == choices.end()) refuse(control, value, "the camera no longer has this choice");
      one.value = static_cast<__s32>(numbers[static_cast<std::size_t>(found - choices.begin())]);
      break;
    }
    default:
      if (asked.type == V4L2_CTRL_TYPE_INTEGER64) {
        one.value64 = value.get<std::int64_t>();
      } else {
        one.value = static_cast<__s32>(value.get<std::int64_t>());
      }
  }
  const int error = call_with(device(), VIDIOC_S_EXT_CTRLS, one);
  if (error == ENODEV) throw CaptureError("the camera does not answer: " + errno_text(error));
  if (error != 0) refuse(control, value, errno_text(error));
}

}  // namespace sslv
