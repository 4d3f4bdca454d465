// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "capture/controls.h"
#include "capture/driver_calls.h"

#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <vector>

namespace sslv {

/// Values by the controls' names.
using ControlValues = std::map<std::string, Json>;

/// A control that was set but not saved.
struct UnsavedControl {
  Control control;  // as last read
  Json before;      // the value that revert() restores
};

/// The effect of new settings on the controls of an open camera.
struct ControlPlan {
  ControlValues unsaid{};  // values to restore because the new settings no longer contain them
  bool reopens = false;    // some controls require reopening the camera
};

/// Serialises all access to a camera's controls, and remembers what was read. Only this class sets an open
/// camera's controls. A control's home value is its saved setting, or else its value at opening.
/// Thread-safe.
class ControlQueue {
 public:
  using Refusals = std::vector<std::string>;  // one line each

  /// `driver` owns this object.
  explicit ControlQueue(Controls& driver) : driver_(driver) {}

  /// Sets all of `wanted` (name -> value) on the calling thread, which is opening the camera, so no other
  /// call is running.
  Refusals open_with(const Json& wanted);
  /// Like open_with(), for a camera that is already open because several sources share it. Queues the calls;
  /// does not wait. Throws like DriverCalls::post().
  void share_with(const Json& wanted);
  /// Queues reading all controls after opening; does not wait. `before`: the controls of the previous
  /// opening, or null. Unsaved values that the camera still has stay unsaved. Throws like
  /// DriverCalls::post().
  void begin(std::shared_ptr<Controls> before);

  // The following functions wait for the camera. They throw CaptureError if the camera does not answer in
  // time (see DriverCalls).

  /// Reads all controls.
  std::vector<Control> list();
  /// Sets one control (or performs an action) without saving it. Throws like Controls::set().
  Control set(const std::string& name, const Json& value);
  /// Restores unsaved controls to their home values; all of them if `names` is empty. For a mode, also
  /// restores the controls that the mode changed. Throws SettingsError if the camera refuses a value; the
  /// other controls are still restored. Returns all controls, like list().
  std::vector<Control> revert(const std::set<std::string>& names, const Json& saved);

  /// Queues the change from settings `before` (name -> value) to `wanted`; does not wait. Controls whose
  /// settings differ are no longer unsaved. The returned function waits until the change has been made and
  /// returns the camera's refusals, or throws CaptureError.
  std::function<Refusals()> apply(const Json& before, const Json& wanted);

  // The following functions use the values read last, without asking the camera.

  /// The change from settings `before` (name -> value) to `wanted`. Throws SettingsError, beginning with
  /// `path`, for controls that the camera lacks and for invalid values. Does not check a number whose range
  /// may have changed with other controls.
  ControlPlan plan(const Json& before, const Json& wanted, const std::string& path) const;
  /// The unsaved controls that differ from their home values.
  std::vector<UnsavedControl> unsaved(const Json& saved) const;
  /// The settings that the camera has refused and not accepted since.
  Refusals refused() const;

  /// See DriverCalls::ask_to_stop().
  void ask_to_stop() const { calls_.ask_to_stop(); }

 private:
  using RefusedByName = std::map<std::string, std::string>;
  /// The known state of the camera.
  struct Memory {
    std::vector<Control> list;      // as last read
    bool ranges_are_old = false;    // controls set since the last full read may have changed the ranges
    ControlValues opened;           // value of each control before it was first set
    std::set<std::string> unsaved;  // controls that were set but not saved
    RefusedByName refused;

    const Control* find(const std::string& name) const;
    ControlValues home(ControlValues saved) const;
    ControlValues changed(const ControlValues& before, const ControlValues& wanted) const;
  };

  template <class Act>
  auto in_turn(Act act);
  RefusedByName set_all(const ControlValues& wanted, bool also_locked);
  RefusedByName take_home(const ControlValues& targets, const ControlValues& saved, bool also_locked);
  Control set_unsaved(const std::string& name, const Json& value);
  void revert_unsaved(const std::set<std::string>& names, const ControlValues& saved);
  Refusals carry_out(const ControlValues& before, const ControlValues& wanted);
  void write(const Control& control, const Json& value);
  Control read(const std::string& name);
  std::vector<Control> read_all();
  void inherit(const Memory& before);
  Memory memory() const;

  Controls& driver_;
  const DriverCalls calls_;
  mutable std::mutex mutex_;  // guards memory_; not held while the camera is being asked
  Memory memory_;
};

}  // namespace sslv
