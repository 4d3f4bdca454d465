// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
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
};

/// As docs/openapi.json has it.
Json control_json(const Control& control);

/// Throws SettingsError "NAME: VALUE is not allowed; expected ..." for a value that the control does not
/// take.
void check_control_value(const Control& control, const Json& value);

/// The camera has `b` when it says `a`: it rounds numbers, by less than a step or a ten-thousandth.
bool is_same_value(const Control& control, const Json& a, const Json& b);

enum class ControlEffect : std::uint8_t {
  kAtOnce,
  kWhenOpened,  // the camera must be closed and opened again for it
};

class ControlMemory;

/// The controls of an open camera. May be used from any thread, also beside the one that takes images, and
/// may block for as long as the camera takes to answer. Lives on when the camera is closed; then all throws
/// CaptureError.
class Controls {
 public:
  Controls();
  virtual ~Controls();

  /// All of them, in the camera's order. Throws CaptureError.
  virtual std::vector<Control> list() = 0;
  /// Throws SettingsError when there is no such control.
  virtual Control get(const std::string& name) = 0;
  /// Sets a control, or does an action (whose value does not matter). Throws SettingsError for what the
  /// camera refuses, and CaptureError when it does not answer.
  ControlEffect set(const std::string& name, const Json& value);

  ControlMemory& memory() { return *memory_; }

 protected:
  /// `value` is one that the control takes.
  virtual ControlEffect write(const Control& control, const Json& value) = 0;

 private:
  const std::unique_ptr<ControlMemory> memory_;
};

/// Sets all of `wanted` (name -> value), in whatever order works: a gain can often be set only once its
/// automatic is off. What stays refused is returned, a line for each.
std::vector<std::string> apply_controls(Controls& controls, const Json& wanted);

}  // namespace sslv
