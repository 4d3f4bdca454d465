// SPDX-License-Identifier: Apache-2.0
#include "capture/files/file.h"

#include "base/clock.h"
#include "base/params_json.h"
#include "capture/files/file_media.h"
#include "capture/files/file_playback.h"
#include "capture/pixel_format_choice.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <filesystem>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

namespace sslv {
namespace {

namespace fs = std::filesystem;

constexpr double kStillRateHz = 30;

struct Options {
  std::string path;
  PixelFormatOrAuto pixel_format;
  int width = 0, height = 0;
  std::optional<double> frame_rate_hz;
  bool loop = false;
  Json controls = Json::object();
  static constexpr auto fields() {
    using O = Options;
    return std::tuple{
        file("path", &O::path,
             "a folder of images (.png .jpg .jpeg .bmp .ppm) and raw frames (.raw), read in the order of "
             "their "
             "names; or one such file; or a video"),
        choice("pixel_format", &O::pixel_format, kPixelFormatOrAutoChoices,
               "how the bytes of raw frames lie; images and videos know it themselves (auto)"),
        number("width", &O::width, 0, 16384, "px", "of raw frames; 0: there are none"),
        number("height", &O::height, 0, 16384, "px", "of raw frames; 0: there are none"),
        number("frame_rate_hz", &O::frame_rate_hz, 0.0, 10000.0, "Hz",
               "images a second; 0: as fast as they are taken; null: a video's own rate, 30 for the rest"),
        flag("loop", &O::loop, "begin again at the end"),
        object("controls", &O::controls,
               "how it is played, such as {\"paused\": true, \"position\": 100}; changed while it runs"),
    };
  }
};

enum class Kind { kPicture, kRaw, kVideo };

struct Item {
  Kind kind;
  std::string path;
  std::string name;  // stem
};

/// What is neither image nor raw frame is tried as a video.
Kind kind_of(const fs::path& path) {
  switch (recording_kind(path)) {
    case RecordingKind::kImage: return Kind::kPicture;
    case RecordingKind::kRaw: return Kind::kRaw;
    default: return Kind::kVideo;
  }
}

std::vector<Item> find_items(const std::string& path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (!fs::exists(status)) {
    throw CaptureError(
        fmt::format("path \"{}\": {}; expected a folder of images, an image, a raw frame or a video", path,
                    std::make_error_code(error ? static_cast<std::errc>(error.value())
                                               : std::errc::no_such_file_or_directory)
                        .message()));
  }
  std::vector<Item> items;
  const auto add = [&](const fs::path& file, Kind kind) {
    items.push_back({kind, file.string(), file.stem().string()});
  };
  if (!fs::is_directory(status)) {
    add(path, kind_of(path));
    return items;
  }
  fs::directory_iterator folder(path, error);
  for (; !error && folder != fs::directory_iterator(); folder.increment(error)) {
    const Kind kind = kind_of(folder->path());
    if (kind != Kind::kVideo) add(folder->path(), kind);
  }
  if (error) throw CaptureError(fmt::format("path \"{}\": {}", path, error.message()));
  if (items.empty()) {
    throw CaptureError(fmt::format(
        "path \"{}\": no images in this folder; expected files ending in .png .jpg .jpeg .bmp .ppm or .raw",
        path));
  }
  std::sort(items.begin(), items.end(), [](const Item& a, const Item& b) { return a.path < b.path; });
  return items;
}

/// An open file for reading.
class Descriptor {
 public:
  explicit Descriptor(const char* path) : fd_(::open(path, O_RDONLY | O_CLOEXEC)) {}
  ~Descriptor() {
    if (fd_ >= 0) ::close(fd_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int get() const { return fd_; }

 private:
  int fd_;
};

class FileSource final : public Source {
 public:
  explicit FileSource(const Options& options) : options_(options), items_(find_items(options.path)) {
    const bool raw =
        std::any_of(items_.begin(), items_.end(), [](const Item& i) { return i.kind == Kind::kRaw; });
    if (raw &&
        !(options_.pixel_format && is_valid_size(*options_.pixel_format, options_.width, options_.height))) {
      throw CaptureError(
          fmt::format("path \"{}\": raw frames need pixel_format (not auto), width and height (2 .. 16384; "
                      "even for YUV and "
                      "Bayer formats); they are {}, {} and {}",
                      options_.path, options_.pixel_format ? name_of(*options_.pixel_format) : "auto",
                      options_.width, options_.height));
    }
    double rate_hz = kStillRateHz;
    auto count = static_cast<std::int64_t>(items_.size());
    if (items_.front().kind == Kind::kVideo) {
      try {
        media_ = std::make_unique<MediaReader>(items_.front().path, false);
      } catch (const std::exception& error) {
        throw CaptureError(
            fmt::format("path \"{}\": {}; expected a folder of images, an image, a raw frame or a video",
                        options_.path, error.what()));
      }
      if (const double own_hz = media_->frame_rate_hz(); own_hz > 0) rate_hz = own_hz;
      count = media_->count() > 0 ? media_->count() : kEndless;
    }
    playback_ = std::make_shared<Playback>(count, options_.frame_rate_hz.value_or(rate_hz), options_.loop);
    warnings_ = apply_controls(*playback_, options_.controls);
  }

  CaptureStatus next(CapturedImage& image, std::string& problem, std::chrono::milliseconds timeout) override {
    try {
      const auto turn = playback_->wait_turn(timeout);
      if (!turn) return CaptureStatus::kTimeout;
      return show(*turn, image, problem);
    } catch (const std::exception& error) {
      problem = fmt::format("path \"{}\": {}", options_.path, error.what());
      return CaptureStatus::kLost;
    }
  }

  std::shared_ptr<Controls> controls() override { return playback_; }
  std::vector<std::string> warnings() const override { return warnings_; }

 private:
  CaptureStatus show(std::int64_t place, CapturedImage& image, std::string& problem) {
    const CaptureStatus status =
        media_ ? take_video(place, image, problem) : take_still(place, image, problem);
    any_good_ = any_good_ || status == CaptureStatus::kImage;
    image.times.t_capture_s = unix_time_s();
    return status;
  }

  /// At the end, behind so many images.
  CaptureStatus begin_again(std::int64_t count, CapturedImage& image, std::string& problem) {
    if (!playback_->begin_again(count)) return CaptureStatus::kEnd;
    if (!std::exchange(any_good_, false)) {
      problem = fmt::format("path \"{}\": nothing in it can be read", options_.path);
      return CaptureStatus::kLost;
    }
    return show(0, image, problem);
  }

  CaptureStatus take_still(std::int64_t place, CapturedImage& image, std::string& problem) {
    if (const auto count = static_cast<std::int64_t>(items_.size()); place >= count)
      return begin_again(count, image, problem);
    const Item& item = items_[static_cast<std::size_t>(place)];
    try {
      image.image = item.kind == Kind::kRaw ? read_raw(item.path) : read_picture(item.path);
      image.name = item.name;
      return CaptureStatus::kImage;
    } catch (const std::exception& error) {
      problem = item.path + ": " + error.what();
      return CaptureStatus::kIncomplete;
    }
  }

  Image read_picture(const std::string& path) {
    Image image;
    std::string problem = "no image in it";
    MediaReader reader(path, true);
    if (reader.read(pool_, image, problem) != MediaReader::Result::kPicture)
      throw std::runtime_error(problem);
    return image;
  }

  Image read_raw(const std::string& path) {
    const Descriptor file(path.c_str());
    struct stat status {};
    if (file.get() < 0 || ::fstat(file.get(), &status) != 0)
      throw std::system_error(errno, std::generic_category());
    const PixelFormat format = *options_.pixel_format;
    const std::int64_t expected = std::int64_t{options_.width} * options_.height * bytes_per_pixel(format);
    // Low bits lie behind the image.
    const bool is_deep = bytes_per_pixel(format) == 1 && status.st_size == 2 * expected;
    if (status.st_size != expected && !is_deep) {
      throw std::runtime_error(fmt::format("{} bytes; expected {} ({}x{} {})", status.st_size, expected,
                                           options_.width, options_.height, name_of(format)));
    }
    std::uint8_t* pixels = nullptr;
    Image image = pool_.take(format, options_.width, options_.height, pixels, is_deep);
    for (std::int64_t done = 0; done < status.st_size;) {
      const ssize_t got = ::read(file.get(), pixels + done, static_cast<std::size_t>(status.st_size - done));
      if (got < 0) throw std::system_error(errno, std::generic_category());
      if (got == 0) throw std::runtime_error("has become shorter while it was read");
      done += got;
    }
    return image;
  }

  CaptureStatus take_video(std::int64_t place, CapturedImage& image, std::string& problem) {
    const Item& item = items_.front();
    if (place != video_place_) {
      if (place > 0) {
        media_->seek(place);
      } else {  // without reading through all of it
        media_ = std::make_unique<MediaReader>(item.path, false);
      }
      video_place_ = place;
    }
    const MediaReader::Result result = media_->read(pool_, image.image, problem);
    if (result == MediaReader::Result::kEnd) return begin_again(video_place_, image, problem);
    const std::int64_t number = video_place_++;
    if (result == MediaReader::Result::kDamaged) {
      problem = fmt::format("{}: frame {}: {}", item.path, number, problem);
      return CaptureStatus::kIncomplete;
    }
    image.name = fmt::format("{}{:06}", item.name, number);
    image.times.t_capture_camera_s = media_->time_s();
    return CaptureStatus::kImage;
  }

  static constexpr std::int64_t kEndless = std::int64_t{1} << 40;  // images of a video that does not say

  const Options options_;
  const std::vector<Item> items_;
  std::shared_ptr<Playback> playback_;
  std::vector<std::string> warnings_;
  PicturePool pool_;
  std::unique_ptr<MediaReader> media_;  // of a video
  std::int64_t video_place_ = 0;        // of the image it gives next
  bool any_good_ = false;               // in this pass
};

}  // namespace

RecordingKind recording_kind(const fs::path& file) {
  std::string ending = file.extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  constexpr std::array<std::string_view, 5> kImages{".png", ".jpg", ".jpeg", ".bmp", ".ppm"};
  constexpr std::array<std::string_view, 9> kVideos{".mp4", ".mkv", ".avi",  ".mov", ".webm",
                                                    ".m4v", ".ts",  ".mpeg", ".mpg"};
  const auto is_one_of = [&](const auto& endings) {
    return std::find(endings.begin(), endings.end(), ending) != endings.end();
  };
  if (ending == ".raw") return RecordingKind::kRaw;
  if (is_one_of(kImages)) return RecordingKind::kImage;
  return is_one_of(kVideos) ? RecordingKind::kVideo : RecordingKind::kOther;
}

Backend file_backend() {
  return {
      "files",
      "recorded images, raw frames or a video instead of a camera",
      [](const Json& options, const std::string& path) {
        return params_to_json(params_from_json<Options>(options, path));
      },
      [] { return params_schema<Options>(); },
      [](const Json& options, const SourceContext&) -> std::unique_ptr<Source> {
        return std::make_unique<FileSource>(params_from_json<Options>(options, ""));
      },
      [] { return std::vector<FoundCamera>{}; },
  };
}

}  // namespace sslv
