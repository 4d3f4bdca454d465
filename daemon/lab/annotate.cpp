// SPDX-License-Identifier: Apache-2.0
#include "lab/annotate.h"

#include "config/backends.h"
#include "image/jpeg.h"
#include "lab/annotation_page.h"
#include "settings/state_folder.h"

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <ostream>
#include <vector>

#include <fmt/format.h>

namespace sslv {
namespace {

namespace fs = std::filesystem;

class Annotating {
 public:
  Annotating(const Config& config, std::size_t camera_index, const AnnotateOptions& o)
      : o_(o),
        scene_(*make_context(config, camera_index, std::make_shared<const Lut>()).scene),
        lines_(read_truth(o.truth_file)) {
    if (!scene_.camera) {
      throw SettingsError(fmt::format("camera {} is not calibrated: nothing that it sees can be located",
                                      config.cameras.at(camera_index).id));
    }
  }

  void take(const std::string& name, const Frame& frame) {
    if (has_picture(name))
      throw SettingsError(fmt::format("{}: two images are called {}", o_.pictures.input, name));
    constexpr int kWhole = 1 << 14, kQuality = 92;
    const auto jpeg = encoder_.encode(frame.image.view(), kWhole, kQuality, Chroma::kFull);
    pictures_.push_back({name, {jpeg.begin(), jpeg.end()}});
    Json* line = line_of(name);
    if (line == nullptr) {
      lines_.push_back(draft_of_truth(name, frame));
    } else if (o_.again && is_meant(name)) {
      *line = draft_of_truth(name, frame);
    }
  }

  void correct_pictures() {
    if (!o_.frame.empty() && !has_picture(o_.frame))
      throw SettingsError(fmt::format("--frame: {} has no image \"{}\"", o_.pictures.input, o_.frame));
    if (o_.frame.empty() && !o_.corrections.empty() && pictures_.size() > 1)
      throw SettingsError(fmt::format("--frame: which of the {} images is corrected?", pictures_.size()));
    for (const Picture& picture : pictures_) {
      if (is_meant(picture.name)) correct(*line_of(picture.name), o_.corrections, scene_);
    }
  }

  void write() {
    std::string truth;
    for (const Json& line : lines_) truth += json_text(line) + "\n";
    write_file_durably(o_.truth_file, truth, 0644);
    fs::create_directories(o_.pages_folder);
    AnnotationPlace place{o_.command, {}, {}};
    for (std::size_t i = 0; i < pictures_.size(); ++i) {
      place.previous = i > 0 ? annotation_page_name(pictures_[i - 1].name) : "";
      place.next = i + 1 < pictures_.size() ? annotation_page_name(pictures_[i + 1].name) : "";
      write_file_durably(fs::path(o_.pages_folder) / annotation_page_name(pictures_[i].name),
                         annotation_page(*line_of(pictures_[i].name), pictures_[i].jpeg, scene_, place),
                         0644);
    }
  }

  void report(std::ostream& out) {
    int not_checked = 0;
    for (const Picture& picture : pictures_) {
      const Json& line = *line_of(picture.name);
      not_checked += line.at("checked") == true ? 0 : 1;
      if (is_meant(picture.name)) out << truth_text(line);
    }
    if (pictures_.empty()) return;
    const std::string& first = o_.frame.empty() ? pictures_.front().name : o_.frame;
    out << fmt::format("{}: {} of {} images not checked yet; look at {} in a browser\n", o_.truth_file,
                       not_checked, pictures_.size(),
                       (fs::path(o_.pages_folder) / annotation_page_name(first)).string());
  }

 private:
  /// An image of the input.
  struct Picture {
    std::string name;
    std::vector<std::uint8_t> jpeg;
  };

  bool is_meant(const std::string& name) const { return o_.frame.empty() || o_.frame == name; }

  bool has_picture(const std::string& name) const {
    return std::any_of(pictures_.begin(), pictures_.end(), [&](const Picture& p) { return p.name == name; });
  }

  Json* line_of(const std::string& name) {
    const auto found =
        std::find_if(lines_.begin(), lines_.end(), [&](const Json& l) { return l["frame"] == name; });
    return found == lines_.end() ? nullptr : &*found;
  }

  const AnnotateOptions& o_;
  const Scene scene_;
  std::vector<Json> lines_;
  std::vector<Picture> pictures_;
  JpegEncoder encoder_;
};

}  // namespace

void annotate(const Config& config, std::size_t camera_index, const AnnotateOptions& options,
              std::ostream& out, std::ostream& problems) {
  Annotating annotating(config, camera_index, options);
  const int unreadable = process_recording(
      config, camera_index, options.pictures,
      [&](const std::string& name, const Frame& frame) { annotating.take(name, frame); }, problems);
  annotating.correct_pictures();
  annotating.write();
  annotating.report(out);
  if (unreadable > 0) problems << unreadable << " frames could not be read and were skipped\n";
}

}  // namespace sslv
