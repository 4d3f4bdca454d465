// SPDX-License-Identifier: Apache-2.0
#include "services/sources/uploaded_images.h"

#include "base/error.h"
#include "base/plain_text.h"
#include "capture/files/file_media.h"
#include "image/jpeg_decoder.h"
#include "settings/state_folder.h"

#include <algorithm>
#include <cerrno>
#include <fstream>
#include <span>
#include <string_view>
#include <system_error>

#include <fmt/format.h>

namespace sslv {
namespace {

namespace fs = std::filesystem;

constexpr const char* kFolderName = "images";
constexpr std::size_t kMaxNameBytes = 100;
/// Folder in which an upload is tested before it is saved. It is separate from the saved images, because a
/// camera may be using them.
constexpr const char* kTrialName = ".trial";

void check_name_of_file(std::string_view key, const std::string& name) {
  const bool is_fine = !name.empty() && name.size() <= kMaxNameBytes && is_plain_text(name) &&
                       name.find('/') == std::string::npos && !name.starts_with('.') &&
                       !name.starts_with(' ') && !name.ends_with(' ');
  if (is_fine) return;
  throw SettingsError(
      fmt::format("{}: \"{}\" is not allowed; expected 1 to {} bytes of plain text without a "
                  "slash, a dot at the beginning or a space at either end",
                  key, escaped_text(shortened(name)), kMaxNameBytes));
}

enum class ImageType { kJpeg, kPng, kOther };

ImageType type_of(std::string_view bytes) {
  if (bytes.starts_with("\xff\xd8\xff")) return ImageType::kJpeg;
  if (bytes.starts_with("\x89PNG\r\n\x1a\n")) return ImageType::kPng;
  return ImageType::kOther;
}

ImageType type_by_name(const std::string& name) {
  std::string ending = fs::path(name).extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  if (ending == ".jpg" || ending == ".jpeg") return ImageType::kJpeg;
  return ending == ".png" ? ImageType::kPng : ImageType::kOther;
}

/// Returns the number of pixels according to the image's header, before memory is allocated for the image; 0
/// if the header does not give it.
std::int64_t pixels_of(std::string_view bytes, ImageType type) {
  const auto* data = reinterpret_cast<const std::uint8_t*>(bytes.data());
  if (type == ImageType::kJpeg) {
    JpegDecoder decoder;
    std::string ignored;
    const ImageView layout = decoder.layout({data, bytes.size()}, ignored);
    return std::int64_t{layout.width} * layout.height;
  }
  // PNG's first chunk, IHDR: its length, its name, then width and height, big-endian.
  constexpr std::size_t kNameAt = 12, kWidthAt = 16, kEnd = 24;
  if (bytes.size() < kEnd || bytes.substr(kNameAt, 4) != "IHDR") return 0;
  const auto number = [&](std::size_t at) {
    return std::int64_t{data[at]} << 24 | std::int64_t{data[at + 1]} << 16 | std::int64_t{data[at + 2]} << 8 |
           data[at + 3];
  };
  const std::int64_t width = number(kWidthAt), height = number(kWidthAt + 4);
  constexpr std::int64_t kMaxSide = 16384;  // no code here accepts a larger image
  return width > kMaxSide || height > kMaxSide ? kMaxSide * kMaxSide : width * height;
}

class RemovedAtEnd {
 public:
  explicit RemovedAtEnd(fs::path file) : file_(std::move(file)) {}
  ~RemovedAtEnd() {
    std::error_code ignored;
    fs::remove(file_, ignored);
  }
  RemovedAtEnd(const RemovedAtEnd&) = delete;
  RemovedAtEnd& operator=(const RemovedAtEnd&) = delete;

 private:
  const fs::path file_;
};

/// Reads the image as the backend "files" would. Throws std::runtime_error if the image cannot be read.
void read_as_camera(const fs::path& file) {
  PicturePool pool;
  Image image;
  std::string problem = "no image in it";
  MediaReader reader(file.string(), true);
  if (reader.read(pool, image, problem) != MediaReader::Result::kPicture) throw std::runtime_error(problem);
}

UploadedImages::Folder look_into(const fs::path& path) {
  UploadedImages::Folder folder{path.filename().string(), path};
  std::error_code error;
  for (fs::directory_iterator i(path, error); !error && i != fs::directory_iterator(); i.increment(error)) {
    std::error_code gone;
    const std::uintmax_t bytes = i->file_size(gone);
    if (gone) continue;
    ++folder.images;
    folder.bytes += bytes;
  }
  return folder;
}

}  // namespace

UploadedImages::UploadedImages(StateFolder& folder) : state_(folder), path_(folder.path() / kFolderName) {
  std::error_code ignored;
  fs::remove_all(path_ / kTrialName, ignored);  // left by a service that was killed
}

fs::path UploadedImages::path_of(const std::string& folder) const {
  check_name_of_file("folder", folder);
  return path_ / folder;
}

std::vector<UploadedImages::Folder> UploadedImages::folders() const {
  std::vector<Folder> out;
  std::error_code error;
  for (fs::directory_iterator i(path_, error); !error && i != fs::directory_iterator(); i.increment(error)) {
    std::error_code gone;
    if (i->is_directory(gone) && !i->path().filename().string().starts_with('.'))
      out.push_back(look_into(i->path()));
  }
  std::sort(out.begin(), out.end(), [](const Folder& a, const Folder& b) { return a.name < b.name; });
  return out;
}

void UploadedImages::check_room(const fs::path& file, std::size_t bytes) const {
  const std::vector<Folder> all = folders();
  std::error_code error;
  const std::uintmax_t old = fs::file_size(file, error);  // size of the file that is replaced
  const bool is_new = static_cast<bool>(error);
  std::uintmax_t sum = bytes - (is_new ? 0 : old);
  for (const Folder& folder : all) sum += folder.bytes;
  if (sum > kMaxBytes) {
    throw SettingsError(
        fmt::format("there is space for {} MiB of images, and this one does not fit; remove a "
                    "folder of images first",
                    kMaxBytes >> 20U));
  }
  const fs::path folder_path = file.parent_path();
  const auto folder =
      std::find_if(all.begin(), all.end(), [&](const Folder& one) { return one.path == folder_path; });
  if (folder == all.end() && all.size() >= kMaxFolders)
    throw SettingsError(fmt::format("there are {} folders of images already; remove one first", kMaxFolders));
  if (folder != all.end() && is_new && folder->images >= kMaxImages)
    throw SettingsError(
        fmt::format("folder \"{}\" has {} images already; use another folder", folder->name, kMaxImages));
}

void UploadedImages::check_readable(const std::string& name, std::string_view bytes) const {
  const ImageType type = type_of(bytes);
  if (type == ImageType::kOther)
    throw SettingsError(fmt::format("{}: this is neither a JPEG nor a PNG", shortened(name)));
  if (type != type_by_name(name)) {
    throw SettingsError(fmt::format("{}: this is a {}; expected a name that ends in {}", shortened(name),
                                    type == ImageType::kJpeg ? "JPEG" : "PNG",
                                    type == ImageType::kJpeg ? ".jpg or .jpeg" : ".png"));
  }
  const std::int64_t pixels = pixels_of(bytes, type);
  if (pixels == 0)
    throw SettingsError(fmt::format("{}: this is not an image, or only part of one", shortened(name)));
  if (pixels > kMaxPixels) {
    throw SettingsError(fmt::format("{}: the image has more than {} million pixels", shortened(name),
                                    kMaxPixels / 1'000'000));
  }
  const fs::path folder = path_ / kTrialName;
  std::error_code error;
  fs::create_directories(folder, error);
  const fs::path file = folder / (type == ImageType::kJpeg ? "image.jpg" : "image.png");
  const RemovedAtEnd removed(file);
  std::ofstream out(file, std::ios::binary);
  out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  out.close();
  if (!out) {
    throw StorageError(
        fmt::format("cannot write {}: {}", file.string(), std::generic_category().message(errno)));
  }
  try {
    decoding_.run([file] {
      read_as_camera(file);
      return Json();
    });
  } catch (const std::exception& problem) {
    throw SettingsError(fmt::format("{}: this image cannot be read: {}", shortened(name), problem.what()));
  }
}

fs::path UploadedImages::save(const std::string& folder, const std::string& name, std::string_view bytes) {
  check_name_of_file("name", name);
  const fs::path file = path_of(folder) / name;
  const std::lock_guard lock(mutex_);
  check_room(file, bytes.size());
  check_readable(name, bytes);
  state_.write(file, bytes);
  return file.parent_path();
}

bool UploadedImages::remove(const std::string& folder) {
  const fs::path path = path_of(folder);
  const std::lock_guard lock(mutex_);
  std::error_code error;
  const std::uintmax_t count = fs::remove_all(path, error);
  if (error) throw StorageError(fmt::format("cannot remove {}: {}", path.string(), error.message()));
  return count > 0;
}

}  // namespace sslv
