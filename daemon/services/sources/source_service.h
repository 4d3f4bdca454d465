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

/// What a camera can be made of: cameras that are found, and one image of each before it is added; files of
/// this computer that the settings may name; images that are uploaded.
class SourceService final : public Service {
 public:
  /// `file_folders`: where settings that come over the network may name files. All must outlive this.
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

  /// A source that the request may open, complete, without controls that would change a camera. Throws
  /// SettingsError.
  Json allowed_source(const Json& source) const;
  /// The id of the camera in the settings that has this one open.
  std::optional<int> user_of(const Json& source, std::span<const FoundCamera> found) const;
  /// The cameras that were found last, or now if `source` is not among them.
  std::vector<FoundCamera> found_with(const Json& source);

  SettingsEditor& settings_;
  const Cameras& cameras_;
  const std::vector<std::filesystem::path> file_folders_;
  SourceImages source_images_;
  std::mutex found_mutex_;
  std::vector<FoundCamera> found_;  // when somebody asked last
  UploadedImages uploaded_;
};

}  // namespace sslv
