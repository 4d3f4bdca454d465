// SPDX-License-Identifier: Apache-2.0
#include "capture/files/file.h"

#include "base/clock.h"
#include "base/json.h"
#include "base/params_json.h"
#include "capture/control_queue.h"
#include "capture/files/file_clip.h"
#include "capture/files/file_media.h"
#include "capture/files/file_playback.h"
#include "capture/files/recording.h"
#include "capture/pixel_format_choice.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>
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

struct FileOptions {
  std::string path;
  PixelFormatOrAuto pixel_format;
  int width = 0, height = 0;
  std::optional<int> camera_id;
  std::optional<double> frame_rate_hz;
  bool loop = false;
  Json controls = Json::object();
  static constexpr auto fields() {
    using O = FileOptions;
    return std::tuple{
        file("path", &O::path,
             "a folder of images (.png .jpg .jpeg .bmp .ppm) and raw frames (.raw), read in the order of "
             "their "
             "names; or one such file; or a video; or a clip (.clip)"),
        choice("pixel_format", &O::pixel_format, kPixelFormatOrAutoChoices,
               "pixel format of raw frames; images, videos and clips state their own (auto), and so may a "
               "frames.json beside raw frames"),
        number("width", &O::width, 0, 16384, "px",
               "width of raw frames; 0: no raw frames, or frames.json states it"),
        number("height", &O::height, 0, 16384, "px",
               "height of raw frames; 0: no raw frames, or frames.json states it"),
        number("camera_id", &O::camera_id, 0, 255, "",
               "id of the camera in a clip; null: the first camera in it"),
        number("frame_rate_hz", &O::frame_rate_hz, 0.0, 10000.0, "Hz",
               "images per second; 0: as fast as they are processed; null: a video's own rate, the times of "
               "a clip, otherwise 30"),
        flag("loop", &O::loop, "start again at the end"),
        object("controls", &O::controls,
               "playback, such as {\"paused\": true, \"position\": 100}; changed while it runs"),
    };
  }
};

constexpr std::string_view kExpectedFiles =
    "expected a folder of images, an image, a raw frame, a video or a clip";

enum class Kind { kPicture, kRaw, kVideo, kClip };

struct Item {
  Kind kind;
  std::string path;
  std::string name;  // file name without its extension
};

/// Files of unknown kind are tried as videos.
Kind kind_of(const fs::path& path) {
  switch (recording_kind(path)) {
    case RecordingKind::kImage: return Kind::kPicture;
    case RecordingKind::kRaw: return Kind::kRaw;
    case RecordingKind::kClip: return Kind::kClip;
    default: return Kind::kVideo;
  }
}

std::vector<Item> find_items(const std::string& path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (!fs::exists(status)) {
    throw CaptureError(fmt::format("path \"{}\": {}; {}", path,
                                   std::make_error_code(error ? static_cast<std::errc>(error.value())
                                                              : std::errc::no_such_file_or_directory)
                                       .message(),
                                   kExpectedFiles));
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
    if (kind == Kind::kPicture || kind == Kind::kRaw) add(folder->path(), kind);
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

/// If the settings lack pixel format and size, reads them from frames.json beside the raw frames. That file,
/// written by `clip export` and `simulate --raw`, states them for all frames or for each frame. Throws
/// CaptureError.
FileOptions with_told_layout(FileOptions options, const std::vector<Item>& items) {
  const auto raw = std::ranges::find(items, Kind::kRaw, &Item::kind);
  if (raw == items.end() || options.pixel_format || options.width != 0 || options.height != 0) return options;
  const fs::path file = fs::path(raw->path).parent_path() / "frames.json";
  std::error_code error;
  if (!fs::is_regular_file(file, error)) return options;
  // Enough for 75 000 frames.
  constexpr std::size_t kMaxFileBytes = std::size_t{16} << 20U, kMaxBytes = std::size_t{48} << 20U;
  const bool is_small = fs::file_size(file, error) <= kMaxFileBytes && !error;
  std::ifstream in(file, std::ios::binary);
  const std::string text = is_small ? std::string(std::istreambuf_iterator<char>(in), {}) : std::string();
  const auto pixels = [](const Json& value) {
    return value.is_number_unsigned() && value <= 16384 ? value.get<int>() : 0;
  };
  bool are_alike = true;
  try {
    const Json told = parse_bounded_json(text, kMaxBytes);
    const Json& first = told.contains("pixel_format") ? told : told.at("frames").at(0);
    options.pixel_format = pixel_format_named(first.at("pixel_format").get<std::string>());
    options.width = pixels(first.at("width"));
    options.height = pixels(first.at("height"));
    if (&first != &told) {
      for (const Json& frame : told.at("frames")) {
        for (const char* key : {"pixel_format", "width", "height"})
          are_alike = are_alike && frame.at(key) == first.at(key);
      }
    }
  } catch (const Json::exception&) {
    options.pixel_format.reset();
  } catch (const std::length_error& excess) {
    throw CaptureError(fmt::format("{}: {}; set pixel_format, width and height for the camera", file.string(),
                                   excess.what()));
  }
  if (!are_alike) {
    throw CaptureError(
        fmt::format("{}: its frames have different formats or sizes; put each kind into a folder of its own",
                    file.string()));
  }
  if (options.pixel_format && is_valid_size(*options.pixel_format, options.width, options.height))
    return options;
  throw CaptureError(fmt::format(
      "{}: pixel_format, width or height is missing or not allowed for raw frames (2 .. 16384 px; "
      "even for YUV and Bayer formats); set all three for the camera, or correct the file",
      file.string()));
}

/// A file opened for reading.
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

/// Images and raw frames, one per file.
class StillRecording final : public Recording {
 public:
  StillRecording(const FileOptions& options, std::vector<Item> items)
      : options_(with_told_layout(options, items)), items_(std::move(items)) {
    const bool raw =
        std::any_of(items_.begin(), items_.end(), [](const Item& i) { return i.kind == Kind::kRaw; });
    if (raw &&
        !(options_.pixel_format && is_valid_size(*options_.pixel_format, options_.width, options_.height))) {
      throw CaptureError(fmt::format(
          "path \"{}\": raw frames need pixel_format (not auto), width and height (2 .. 16384; even for YUV "
          "and Bayer formats); they are {}, {} and {}, and no frames.json states them",
          options_.path, options_.pixel_format ? name_of(*options_.pixel_format) : "auto", options_.width,
          options_.height));
    }
  }

  CaptureStatus take(std::int64_t place, CapturedImage& image, std::string& problem,
                     Clock::time_point /*until*/) override {
    if (place >= count()) return CaptureStatus::kEnd;
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

  std::int64_t count() const override { return static_cast<std::int64_t>(items_.size()); }

 private:
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
    // Low bits are stored after the image.
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
      if (got == 0) throw std::runtime_error("became shorter while it was read");
      done += got;
    }
    return image;
  }

  const FileOptions options_;
  const std::vector<Item> items_;
  PicturePool pool_;
};

class VideoRecording final : public Recording {
 public:
  explicit VideoRecording(Item item)
      : item_(std::move(item)), media_(std::make_unique<MediaReader>(item_.path, false)) {
    if (media_->count() > 0) count_ = media_->count();
  }

  CaptureStatus take(std::int64_t place, CapturedImage& image, std::string& problem,
                     Clock::time_point until) override {
    if (place != place_ || is_lost_) {
      is_lost_ = true;
      if (place == 0) {  // reopening is faster than seeking, which reads the whole file
        media_ = std::make_unique<MediaReader>(item_.path, false);
      } else if (!media_->seek(place, until)) {
        return CaptureStatus::kTimeout;
      }
      place_ = place;
      is_lost_ = false;
    }
    const MediaReader::Result result = media_->read(pool_, image.image, problem, until);
    if (result == MediaReader::Result::kSearching) return CaptureStatus::kTimeout;
    if (result == MediaReader::Result::kEnd) {
      count_ = place_;
      return CaptureStatus::kEnd;
    }
    const std::int64_t number = place_++;
    if (result == MediaReader::Result::kDamaged) {
      problem = fmt::format("{}: frame {}: {}", item_.path, number, problem);
      return CaptureStatus::kIncomplete;
    }
    image.name = fmt::format("{}{:06}", item_.name, number);
    image.times.t_capture_camera_s = media_->time_s();
    return CaptureStatus::kImage;
  }

  std::int64_t count() const override { return count_; }
  double frame_rate_hz() const override { return media_->frame_rate_hz(); }

 private:
  static constexpr std::int64_t kEndless = std::int64_t{1} << 40;  // for videos of unknown length

  const Item item_;
  PicturePool pool_;
  std::unique_ptr<MediaReader> media_;
  std::int64_t place_ = 0;  // number of the next image
  bool is_lost_ = false;    // the position is invalid: a seek was not completed
  std::int64_t count_ = kEndless;
};

/// Throws CaptureError.
std::unique_ptr<Recording> open_recording(const FileOptions& options) {
  std::vector<Item> items = find_items(options.path);
  const Kind kind = items.front().kind;
  if (options.camera_id && kind != Kind::kClip)
    throw CaptureError(
        fmt::format("path \"{}\": only a clip (.clip) has cameras; camera_id must be null, not {}",
                    options.path, *options.camera_id));
  if (kind != Kind::kVideo && kind != Kind::kClip)
    return std::make_unique<StillRecording>(options, std::move(items));
  try {
    if (kind == Kind::kVideo) return std::make_unique<VideoRecording>(std::move(items.front()));
    return open_clip(options.path, options.camera_id);
  } catch (const std::exception& error) {
    if (kind == Kind::kClip) throw CaptureError(error.what());
    throw CaptureError(fmt::format("path \"{}\": {}; {}", options.path, error.what(), kExpectedFiles));
  }
}

class FileSource final : public Source {
 public:
  explicit FileSource(const FileOptions& options) : options_(options), recording_(open_recording(options)) {
    std::vector<double> distances_s = recording_->distances_s();
    if (options_.frame_rate_hz || distances_s.empty()) {
      const double own_hz = recording_->frame_rate_hz();
      playback_ = std::make_shared<Playback>(
          recording_->count(), options_.frame_rate_hz.value_or(own_hz > 0 ? own_hz : kStillRateHz),
          options_.loop);
    } else {
      playback_ = std::make_shared<Playback>(std::move(distances_s), options_.loop);
    }
    warnings_ = playback_->queue().open_with(options_.controls);
  }

  CaptureStatus next(CapturedImage& image, std::string& problem, std::chrono::milliseconds timeout) override {
    try {
      const auto until = Recording::Clock::now() + timeout;
      if (searched_ && !playback_->is_next(*searched_ + 1)) searched_.reset();  // another image is wanted now
      const auto turn = searched_ ? searched_ : playback_->wait_turn(timeout);
      if (!turn) return CaptureStatus::kTimeout;
      CaptureStatus status = take(*turn, image, problem, until);
      searched_ = status == CaptureStatus::kTimeout ? turn : std::nullopt;
      if (status != CaptureStatus::kEnd || !playback_->begin_again(recording_->count())) return status;
      if (!std::exchange(any_good_, false)) {
        problem = fmt::format("path \"{}\": nothing in it can be read", options_.path);
        return CaptureStatus::kLost;
      }
      return take(0, image, problem, until);
    } catch (const std::exception& error) {
      problem = fmt::format("path \"{}\": {}", options_.path, error.what());
      return CaptureStatus::kLost;
    }
  }

  std::shared_ptr<Controls> controls() override { return playback_; }
  std::vector<std::string> warnings() const override { return warnings_; }

 private:
  CaptureStatus take(std::int64_t place, CapturedImage& image, std::string& problem,
                     Recording::Clock::time_point until) {
    const CaptureStatus status = recording_->take(place, image, problem, until);
    any_good_ = any_good_ || status == CaptureStatus::kImage;
    image.times.t_capture_s = unix_time_s();
    return status;
  }

  const FileOptions options_;
  const std::unique_ptr<Recording> recording_;
  std::shared_ptr<Playback> playback_;
  std::vector<std::string> warnings_;
  bool any_good_ = false;                 // an image was readable in this pass through the recording
  std::optional<std::int64_t> searched_;  // number of the due image while a seek to it is incomplete
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
  if (ending == ".clip") return RecordingKind::kClip;
  if (is_one_of(kImages)) return RecordingKind::kImage;
  return is_one_of(kVideos) ? RecordingKind::kVideo : RecordingKind::kOther;
}

Backend file_backend() {
  return {
      "files",
      "recorded images, raw frames, a video or a clip instead of a camera",
      [](const Json& options, const std::string& path) {
        return params_to_json(params_from_json<FileOptions>(options, path));
      },
      [] { return params_schema<FileOptions>(); },
      [](const Json& options, const SourceContext&) -> std::unique_ptr<Source> {
        return std::make_unique<FileSource>(params_from_json<FileOptions>(options, ""));
      },
      [] { return std::vector<FoundCamera>{}; },
  };
}

}  // namespace sslv
