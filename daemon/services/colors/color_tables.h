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

/// The cameras' accepted colour tables: each on a desk of its own, where it is changed, saved and named in
/// the settings. May be used from any thread.
class ColorTables {
 public:
  /// All must outlive this.
  ColorTables(Cameras& cameras, SettingsEditor& settings, SavedTables& saved, const Profiles& profiles)
      : cameras_(cameras), settings_(settings), saved_(saved), profiles_(profiles) {}

  /// A camera's desk with its accepted table on it, while nobody else has one.
  struct AtDesk {
    std::unique_lock<std::mutex> lock;
    CameraNow camera;
    ColorDesk& desk;

    const LabelSet& labels() const { return *camera.context().labels; }
    /// The table in use is adapted to the light.
    bool is_adapted() const { return camera.context().adapted_lut != camera.context().accepted_lut; }
  };
  /// Throws HttpError 404.
  AtDesk open(int camera_id);

  /// Saves a table of the camera and names it in the settings. Throws what SettingsEditor::patch() does.
  ColorDesk::Save saver(const AtDesk& at, const std::string& who);
  /// A whole table, in the bits of the camera's.
  void take_over(AtDesk& at, std::shared_ptr<const Lut> lut, const std::string& what, const std::string& who);
  /// Saves in the settings that the camera has this table; "": that of the settings themselves.
  void name_table(int camera_id, const std::string& name, const std::string& what, const std::string& who);

 private:
  /// Removes saved tables that nothing names any more.
  void tidy();

  Cameras& cameras_;
  SettingsEditor& settings_;
  SavedTables& saved_;
  const Profiles& profiles_;
  std::mutex mutex_;                // guards what follows; held during a whole change of a table
  std::map<int, ColorDesk> desks_;  // by camera
  int saved_since_tidied_ = 0;
};

}  // namespace sslv
