// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "capture/source.h"
#include "services/cameras/cameras.h"
#include "services/service.h"
#include "services/settings/settings_editor.h"
#include "services/sources/source_images.h"
#include "services/sources/uploaded_images.h"

#include <filesystem>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

namespace sslv {

/// Offers sources for a camera of the settings: connected cameras, with an image of each before it is added;
/// files of this computer that the settings may name; uploaded images.
class SourceService final : public Service {
 public:
  /// `file_folders`: folders in which settings from the network may name files. All must outlive this.
  SourceService(StateFolder& folder, SettingsEditor& settings, const Cameras& cameras,
                std::vector<std::filesystem::path> file_folders);

  void ask_to_stop() override {
    source_images_.ask_to_stop();
    uploaded_.ask_to_stop();
  }
  std::vector<Route> routes() override;

 private:
  Response get_sources();
  Response take_image(const Request& request);
  Response get_files(const Request& request) const;
  Response get_images() const;
  Response upload_image(const Request& request);
  Response remove_images(const Request& request);

  /// Returns the complete source if the request may open it. Leaves out its controls, because setting them
  /// would change a camera. Throws SettingsError.
  Json allowed_source(const Json& source) const;
  /// Returns the id of the camera in the settings that uses the same device as `source`; nothing if none
  /// does.
  std::optional<int> user_of(const Json& source, std::span<const FoundCamera> found) const;
  /// Returns the cameras found last; searches again if `source` is not among them.
  std::vector<FoundCamera> found_with(const Json& source);

  SettingsEditor& settings_;
  const Cameras& cameras_;
  const std::vector<std::filesystem::path> file_folders_;
  SourceImages source_images_;
  std::mutex found_mutex_;
  std::vector<FoundCamera> found_;  // result of the last search
  UploadedImages uploaded_;
};

}  // namespace sslv
