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

/// How much one should know of cameras to use a control (GenICam SFNC's visibility).
enum class ControlLevel : std::uint8_t { kBeginner, kExpert, kGuru };

/// Something that can be set on the camera itself, with its current value: the camera says what there is, not
/// we.
struct Control {
  std::string name;                   // the camera's own, such as "ExposureTime"
  std::string title, category, help;  // for people; may be empty
  std::string unit;                   // as the camera has it: "us", "dB"
  ControlKind kind = ControlKind::kNumber;
  ControlLevel level = ControlLevel::kBeginner;
  Json value;                               // null: cannot be read now; of an action
  std::optional<double> least, most, step;  // of kInteger and kNumber
  std::vector<std::string> choices;         // of kChoice
  bool writable = true;                     // now
  bool moves = false;                       // it goes on changing once it is set: a recording's position
  bool depends = false;                     // on what another control selects, or selects itself
  bool reopens = false;                     // now the camera must be closed and opened again to set it
};

/// As docs/openapi.json has it.
Json control_json(const Control& control);

/// Throws SettingsError "NAME: VALUE is not allowed; expected ..." for a value that the control does not
/// take.
void check_control_value(const Control& control, const Json& value);

/// The camera has `b` when it says `a`: it rounds numbers, by less than a step or a ten-thousandth.
bool is_same_value(const Control& control, const Json& a, const Json& b);

class ControlQueue;

/// The driver of an open camera's controls. It may block for as long as the camera takes to answer: of an
/// open camera queue() alone calls it. Lives on when the camera is closed; then all throws CaptureError.
class Controls : public std::enable_shared_from_this<Controls> {
 public:
  Controls();
  virtual ~Controls();

  /// All of them, in the camera's order. Throws CaptureError.
  virtual std::vector<Control> list() = 0;
  /// Throws SettingsError when there is no such control.
  virtual Control get(const std::string& name) = 0;
  /// Sets a control that was just read, or does an action (whose value does not matter). Throws
  /// SettingsError for what the camera refuses (NeedsReopening: now), and CaptureError when it does not
  /// answer.
  void set(const Control& control, const Json& value);
  void set(const std::string& name, const Json& value) { set(get(name), value); }

  ControlQueue& queue() { return *queue_; }

 protected:
  /// `value` is one that the control takes.
  virtual void write(const Control& control, const Json& value) = 0;

 private:
  const std::unique_ptr<ControlQueue> queue_;
};

/// It takes effect only when the camera is reopened, so it cannot be set without saving it.
struct NeedsReopening : SettingsError {
  using SettingsError::SettingsError;
};

}  // namespace sslv
