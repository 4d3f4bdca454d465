// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/error.h"
#include "base/json.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace sslv {

enum class ControlKind : std::uint8_t { kFlag, kInteger, kNumber, kChoice, kText, kAction };

/// The knowledge of cameras that a control requires of its user (GenICam SFNC visibility).
enum class ControlLevel : std::uint8_t { kBeginner, kExpert, kGuru };

/// A setting of the camera itself with its current value. Each camera defines its own controls.
struct Control {
  std::string name;                   // the camera's name, such as "ExposureTime"
  std::string title, category, help;  // for display; may be empty
  std::string unit;                   // the camera's text: "us", "dB"
  ControlKind kind = ControlKind::kNumber;
  ControlLevel level = ControlLevel::kBeginner;
  Json value;                               // null for an action, or if it cannot be read now
  std::optional<double> least, most, step;  // for kInteger and kNumber
  std::vector<std::string> choices;         // for kChoice
  bool writable = true;                     // at present
  bool moves = false;    // the value keeps changing after it is set, such as a recording's position
  bool depends = false;  // depends on a selector, or is a selector itself
  bool reopens = false;  // setting it in the current state requires reopening the camera
};

/// See docs/openapi.json.
Json control_json(const Control& control);

/// Throws SettingsError "NAME: VALUE is not allowed; expected ..." for a value that the control does not
/// accept.
void check_control_value(const Control& control, const Json& value);

/// Whether a camera that reports `a` was set to `b`: cameras round numbers, by less than a step or a relative
/// 1e-4.
bool is_same_value(const Control& control, const Json& a, const Json& b);

class ControlQueue;

/// Driver of an open camera's controls. Calls may block until the camera answers; while the camera is open,
/// only queue() makes these calls. May outlive the camera; every call then throws CaptureError.
class Controls : public std::enable_shared_from_this<Controls> {
 public:
  Controls();
  virtual ~Controls();

  /// All controls, in the camera's order. Throws CaptureError.
  virtual std::vector<Control> list() = 0;
  /// Throws SettingsError if there is no such control.
  virtual Control get(const std::string& name) = 0;
  /// Sets a control that was just read, or performs an action (whose value is ignored). Throws SettingsError
  /// if the camera refuses (NeedsReopening if the camera must be reopened first), and CaptureError if the
  /// camera does not answer.
  void set(const Control& control, const Json& value);
  void set(const std::string& name, const Json& value) { set(get(name), value); }

  ControlQueue& queue() { return *queue_; }

 protected:
  /// `value` has passed check_control_value().
  virtual void write(const Control& control, const Json& value) = 0;

 private:
  const std::unique_ptr<ControlQueue> queue_;
};

/// The control takes effect only when the camera is reopened, so it cannot be set without being saved.
struct NeedsReopening : SettingsError {
  using SettingsError::SettingsError;
};

}  // namespace sslv
