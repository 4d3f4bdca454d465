// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "services/cameras/cameras.h"
#include "services/colors/color_desk.h"
#include "services/colors/saved_tables.h"
#include "services/settings/settings_editor.h"
#include "settings/profiles.h"

#include <map>
#include <memory>
#include <mutex>
#include <string>

namespace sslv {

/// The cameras' accepted colour tables. Each camera has its own ColorDesk; a changed table is saved, and the
/// settings then name it. Thread-safe.
class ColorTables {
 public:
  /// All must outlive this.
  ColorTables(Cameras& cameras, SettingsEditor& settings, SavedTables& saved, const Profiles& profiles)
      : cameras_(cameras), settings_(settings), saved_(saved), profiles_(profiles) {}

  /// Exclusive access to a camera's desk with its accepted table.
  struct AtDesk {
    std::unique_lock<std::mutex> lock;
    CameraNow camera;
    ColorDesk& desk;

    const LabelSet& labels() const { return *camera.context().labels; }
    /// Whether the table in use is adapted to the light.
    bool is_adapted() const { return camera.context().adapted_lut != camera.context().accepted_lut; }
  };
  /// Throws HttpError 404.
  AtDesk open(int camera_id);

  /// Returns a function that saves a table of the camera and names it in the settings. It throws the
  /// exceptions of SavedTables::save() and SettingsEditor::patch().
  ColorDesk::Save saver(const AtDesk& at, const std::string& who);
  /// Replaces the camera's whole table by `lut`, converted to the table's number of colour bits.
  void take_over(AtDesk& at, std::shared_ptr<const Lut> lut, const std::string& what, const std::string& who);
  /// Sets the name of the camera's table in the settings; "": the table of the settings' classes or file.
  /// Throws HttpError 404, and the exceptions of SettingsEditor::patch().
  void name_table(int camera_id, const std::string& name, const std::string& what, const std::string& who);

 private:
  /// On every 50th call, removes old saved tables that neither settings, history nor profiles name.
  void tidy();

  Cameras& cameras_;
  SettingsEditor& settings_;
  SavedTables& saved_;
  const Profiles& profiles_;
  std::mutex mutex_;                // guards the members below; held during a whole change
  std::map<int, ColorDesk> desks_;  // by camera
  int saved_since_tidied_ = 0;
};

}  // namespace sslv
