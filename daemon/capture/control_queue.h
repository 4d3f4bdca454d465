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

/// Of controls, by their names.
using ControlValues = std::map<std::string, Json>;

/// A control that was set and not saved.
struct UnsavedControl {
  Control control;  // as it was last read
  Json before;      // what it goes back to
};

/// What other settings do to the controls of an open camera.
struct ControlPlan {
  ControlValues unsaid{};  // what goes back because they say it no more
  bool reopens = false;    // some of it can only be set by reopening the camera
};

/// All that is asked of a camera's controls, one after the other, and what is known of them. Nobody else sets
/// an open camera's controls. A control's home is what the settings say, else what the camera had when it was
/// opened. May be used from any thread.
class ControlQueue {
 public:
  using Refusals = std::vector<std::string>;  // a line each

  /// `driver` owns this.
  explicit ControlQueue(Controls& driver) : driver_(driver) {}

  /// Sets all of `wanted` (name -> value) in this thread, which opens the camera: nobody else asks it yet.
  Refusals open_with(const Json& wanted);
  /// Likewise of a camera that is open already, because several share it: in turn, and does not wait for it.
  /// Throws as DriverCalls::post() does.
  void share_with(const Json& wanted);
  /// Then reads all, and does not wait for it. `before`: of the opening before, or null: what the camera
  /// still has as it was left is unsaved still. Throws as DriverCalls::post() does.
  void begin(std::shared_ptr<Controls> before);

  // These wait for the camera. They throw CaptureError when it does not answer in time (see DriverCalls).

  /// All of them, read now.
  std::vector<Control> list();
  /// Sets one (or does an action) without saving it. Throws what Controls::set() throws.
  Control set(const std::string& name, const Json& value);
  /// Unsaved controls go home; `names` empty: all. With a mode also what it has changed since. Throws
  /// SettingsError when the camera refuses one; the others go. Returns list().
  std::vector<Control> revert(const std::set<std::string>& names, const Json& saved);

  /// Goes from settings (name -> value) to others, and does not wait for it: nothing that differs is unsaved
  /// from then on. What it returns waits, for what the camera has refused. That throws CaptureError.
  std::function<Refusals()> apply(const Json& before, const Json& wanted);

  // These know what was read last, and ask the camera nothing.

  /// From settings (name -> value) to others. Throws SettingsError, beginning with `path`, for what the
  /// camera does not have or take as far as that is known: numbers' ranges may move with what is set with
  /// them.
  ControlPlan plan(const Json& before, const Json& wanted, const std::string& path) const;
  /// Those that are not at home.
  std::vector<UnsavedControl> unsaved(const Json& saved) const;
  /// What the camera has refused of plans, and not taken since.
  Refusals refused() const;

  /// See DriverCalls::ask_to_stop().
  void ask_to_stop() const { calls_.ask_to_stop(); }

 private:
  using RefusedByName = std::map<std::string, std::string>;
  /// What is known of the camera.
  struct Memory {
    std::vector<Control> list;      // as they were last read
    bool ranges_are_old = false;    // what was set since may have moved other controls' ranges
    ControlValues opened;           // what each had before it was set for the first time
    std::set<std::string> unsaved;  // that were set
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
  mutable std::mutex mutex_;  // guards the next; not held while the camera is asked
  Memory memory_;
};

}  // namespace sslv
