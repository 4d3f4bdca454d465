// SPDX-License-Identifier: Apache-2.0
#include "capture/file.h"

#include "base/clock.h"
#include "base/params_json.h"
#include "capture/file_media.h"
#include "capture/pixel_format_choice.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <filesystem>
#include <system_error>
#include <thread>
#include <utility>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

namespace sslv {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr double kStillRateHz = 30;

struct Options {
  std::string path;
  PixelFormatOrAuto pixel_format;
  int width = 0, height = 0;
  std::optional<double> frame_rate_hz;
  bool loop = false;
  static constexpr auto fields() {
    using O = Options;
    return std::tuple{
        text("path", &O::path,
             "a folder of pictures (.png .jpg .jpeg .bmp .ppm) and raw frames (.raw), read in the order of "
             "their "
             "names; or one such file; or a video"),
        choice("pixel_format", &O::pixel_format, kPixelFormatOrAutoChoices,
               "how the bytes of raw frames lie; pictures and videos know it themselves (auto)"),
        number("width", &O::width, 0, 16384, "px", "of raw frames; 0: there are none"),
        number("height", &O::height, 0, 16384, "px", "of raw frames; 0: there are none"),
        number("frame_rate_hz", &O::frame_rate_hz, 0.0, 10000.0, "Hz",
               "pictures a second; 0: as fast as they are taken; null: a video's own rate, 30 for the rest"),
        flag("loop", &O::loop, "begin again at the end"),
    };
  }
};

enum class Kind { kPicture, kRaw, kVideo };

struct Item {
  Kind kind;
  std::string path;
  std::string name;  // stem
};

/// By the ending of the name; what is neither picture nor raw frame is tried as a video.
Kind kind_of(const fs::path& path) {
  std::string ending = path.extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  if (ending == ".raw") return Kind::kRaw;
  constexpr std::array<std::string_view, 5> kPictures{".png", ".jpg", ".jpeg", ".bmp", ".ppm"};
  return std::find(kPictures.begin(), kPictures.end(), ending) != kPictures.end() ? Kind::kPicture
                                                                                  : Kind::kVideo;
}

std::vector<Item> find_items(const std::string& path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (!fs::exists(status)) {
    throw CaptureError(
        fmt::format("path \"{}\": {}; expected a folder of pictures, a picture, a raw frame or a video", path,
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
        "path \"{}\": no pictures in this folder; expected files ending in .png .jpg .jpeg .bmp .ppm or .raw",
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
  explicit FileSource(const Options& options)
      : options_(options), items_(find_items(options.path)), next_due_(Clock::now()) {
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
    if (items_.front().kind == Kind::kVideo) {
      try {
        open_media(items_.front());
      } catch (const std::exception& error) {
        throw CaptureError(
            fmt::format("path \"{}\": {}; expected a folder of pictures, a picture, a raw frame or a video",
                        options_.path, error.what()));
      }
      if (const double own_hz = media_->frame_rate_hz(); own_hz > 0) rate_hz = own_hz;
    }
    rate_hz = options_.frame_rate_hz.value_or(rate_hz);
    if (rate_hz > 0)
      period_ = std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(1 / rate_hz));
  }

  CaptureStatus next(CapturedImage& image, std::string& problem, std::chrono::milliseconds timeout) override {
    try {
      if (period_ > Clock::duration::zero() && !wait_until_due(timeout)) return CaptureStatus::kTimeout;
      const CaptureStatus status = take(image, problem);
      image.times.t_capture_s = unix_time_s();
      return status;
    } catch (const std::exception& error) {
      problem = fmt::format("path \"{}\": {}", options_.path, error.what());
      return CaptureStatus::kLost;
    }
  }

 private:
  /// False when the next picture is not due within `timeout`. A reader that comes late is not rushed
  /// afterwards.
  bool wait_until_due(std::chrono::milliseconds timeout) {
    const Clock::time_point now = Clock::now();
    std::this_thread::sleep_until(std::min(next_due_, now + timeout));
    if (next_due_ > now + timeout) return false;
    next_due_ = std::max(next_due_ + period_, now);
    return true;
  }

  CaptureStatus take(CapturedImage& image, std::string& problem) {
    if (place_ == items_.size()) {
      if (!options_.loop) return CaptureStatus::kEnd;
      if (!any_good_) {
        problem = fmt::format("path \"{}\": nothing in it can be read", options_.path);
        return CaptureStatus::kLost;
      }
      place_ = 0;
      any_good_ = false;
    }
    const Item& item = items_[place_];
    const CaptureStatus status =
        item.kind == Kind::kVideo ? take_video(item, image, problem) : take_still(item, image, problem);
    any_good_ = any_good_ || status == CaptureStatus::kImage;
    return status;
  }

  CaptureStatus take_still(const Item& item, CapturedImage& image, std::string& problem) {
    ++place_;
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
    std::string problem = "no picture in it";
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
    if (status.st_size != expected) {
      throw std::runtime_error(fmt::format("{} bytes; expected {} ({}x{} {})", status.st_size, expected,
                                           options_.width, options_.height, name_of(format)));
    }
    std::uint8_t* pixels = nullptr;
    Image image = pool_.take(format, options_.width, options_.height, pixels);
    for (std::int64_t done = 0; done < expected;) {
      const ssize_t got = ::read(file.get(), pixels + done, static_cast<std::size_t>(expected - done));
      if (got < 0) throw std::system_error(errno, std::generic_category());
      if (got == 0) throw std::runtime_error("has become shorter while it was read");
      done += got;
    }
    return image;
  }

  CaptureStatus take_video(const Item& item, CapturedImage& image, std::string& problem) {
    if (!media_) open_media(item);
    const MediaReader::Result result = media_->read(pool_, image.image, problem);
    if (result == MediaReader::Result::kEnd) {
      media_.reset();
      ++place_;
      return take(image, problem);
    }
    const int number = video_frame_++;
    if (result == MediaReader::Result::kDamaged) {
      problem = fmt::format("{}: frame {}: {}", item.path, number, problem);
      return CaptureStatus::kIncomplete;
    }
    image.name = fmt::format("{}{:06}", item.name, number);
    return CaptureStatus::kImage;
  }

  void open_media(const Item& item) {
    media_ = std::make_unique<MediaReader>(item.path, false);
    video_frame_ = 0;
  }

  const Options options_;
  const std::vector<Item> items_;
  Clock::duration period_{};  // zero: as fast as possible
  Clock::time_point next_due_;
  PicturePool pool_;
  std::unique_ptr<MediaReader> media_;  // the video being read
  int video_frame_ = 0;
  std::size_t place_ = 0;  // in items_
  bool any_good_ = false;  // in this pass through items_
};

}  // namespace

Backend file_backend() {
  return {
      "files",
      "recorded pictures, raw frames or a video instead of a camera",
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
