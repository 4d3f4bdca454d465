// SPDX-License-Identifier: Apache-2.0
#include "capture/v4l2/v4l2_nodes.h"

#include "capture/source.h"

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <fstream>
#include <optional>
#include <system_error>
#include <utility>

#include <fmt/format.h>

namespace sslv {
namespace {

namespace fs = std::filesystem;

/// A text from the kernel, which may lack the terminating zero.
template <std::size_t N>
std::string text_of(const __u8 (&text)[N]) {
  return {text, std::find(text, text + N, 0)};
}

/// The entries of a folder, sorted; empty if the folder does not exist.
std::vector<fs::path> entries_of(const fs::path& folder) {
  std::error_code error;
  std::vector<fs::path> out;
  for (fs::directory_iterator i(folder, error); !error && i != fs::directory_iterator(); i.increment(error))
    out.push_back(i->path());
  std::sort(out.begin(), out.end());
  return out;
}

/// The serial number of the USB device that a video device belongs to.
std::string usb_serial_of(const V4l2System& system, const std::string& name) {
  std::error_code error;
  fs::path folder = fs::canonical(fs::path(system.class_folder) / name / "device", error);
  // Usually a video device belongs to an interface of the USB device, so check two levels. The levels above
  // are hubs, which have their own serial numbers.
  for (int i = 0; i < 2 && !error; ++i, folder = folder.parent_path()) {
    if (!fs::exists(folder / "idVendor", error)) continue;
    std::string serial;
    std::ifstream file(folder / "serial");
    std::getline(file, serial);
    return serial;
  }
  return {};
}

std::vector<std::string> links_to(const V4l2System& system, const std::string& path) {
  std::vector<std::string> out;
  for (const char* folder : {"v4l/by-id", "v4l/by-path"}) {
    for (const fs::path& link : entries_of(fs::path(system.device_folder) / folder)) {
      std::error_code error;
      if (fs::canonical(link, error) == path && !error) out.push_back(link.filename().string());
    }
  }
  return out;
}

/// The result of an attempt to open a device.
struct Opened {
  std::optional<V4l2Node> node;
  std::string problem{};
  bool forbidden = false;  // no permission to open the device, which may be a camera
};

Opened open_node(const V4l2System& system, const std::string& path) {
  V4l2Node node;
  node.path = path;
  node.device = system.open(path);
  if (!node.device) {
    const int error = errno;
    if (error != EACCES) return {std::nullopt, errno_text(error)};
    return {std::nullopt, errno_text(error) + "; only members of the group video may use it", true};
  }
  v4l2_capability capability{};
  if (const int error = node.device->call(VIDIOC_QUERYCAP, &capability); error != 0)
    return {std::nullopt, "no video device: " + errno_text(error)};
  const auto capabilities = (capability.capabilities & V4L2_CAP_DEVICE_CAPS) != 0 ? capability.device_caps
                                                                                  : capability.capabilities;
  const bool captures = (capabilities & V4L2_CAP_VIDEO_CAPTURE) != 0;
  const bool captures_planes = (capabilities & V4L2_CAP_VIDEO_CAPTURE_MPLANE) != 0;
  if (!(captures || captures_planes) || (capabilities & V4L2_CAP_STREAMING) == 0)
    return {std::nullopt, "this device delivers no images"};
  if (!captures) node.buffers = V4L2_BUF_TYPE_VIDEO_CAPTURE_MPLANE;
  node.model = text_of(capability.card);
  node.driver = text_of(capability.driver);
  node.bus = text_of(capability.bus_info);
  node.serial = usb_serial_of(system, fs::path(path).filename().string());
  node.links = links_to(system, path);
  return {std::move(node)};
}

bool is_called(const V4l2Node& node, const std::string& name) {
  return !name.empty() && (name == node.serial || name == node.bus || name == node.path ||
                           std::find(node.links.begin(), node.links.end(), name) != node.links.end());
}

std::string listed(const std::vector<V4l2Node>& nodes, const std::vector<V4l2Node>& all) {
  std::string out;
  for (const V4l2Node& node : nodes)
    out += fmt::format("{}\"{}\" ({})", out.empty() ? "" : ", ", known_by(node, all), node.model);
  return out;
}

std::vector<V4l2Node> find_nodes(const V4l2System& system, std::string& problem) {
  std::vector<fs::path> entries = entries_of(system.class_folder);
  const auto shorter_first = [](const fs::path& a, const fs::path& b) {  // video2 before video10
    return a.native().size() < b.native().size();
  };
  std::stable_sort(entries.begin(), entries.end(), shorter_first);
  std::vector<V4l2Node> out;
  for (const fs::path& entry : entries) {
    const std::string name = entry.filename().string();
    if (!name.starts_with("video")) continue;  // other entries are radios and the like
    const std::string path = system.device_folder + '/' + name;
    Opened opened = open_node(system, path);
    if (opened.node) out.push_back(std::move(*opened.node));
    if (opened.forbidden) problem = path + ": " + opened.problem;
  }
  return out;
}

}  // namespace

std::vector<V4l2Node> find_v4l2_nodes(const V4l2System& system) {
  std::string problem;
  return find_nodes(system, problem);
}

const std::string& known_by(const V4l2Node& node, const std::vector<V4l2Node>& all) {
  const auto is_unique = [&](const std::string& name) {
    return std::count_if(all.begin(), all.end(), [&](const V4l2Node& n) { return is_called(n, name); }) == 1;
  };
  if (is_unique(node.serial)) return node.serial;
  if (is_unique(node.bus)) return node.bus;
  const auto link = std::find_if(node.links.begin(), node.links.end(), is_unique);
  return link != node.links.end() ? *link : node.path;
}

V4l2Node find_v4l2_node(const V4l2System& system, const std::string& camera) {
  if (camera.starts_with('/')) {
    std::error_code error;
    const fs::path path = fs::canonical(camera, error);  // resolves links in /dev/v4l
    Opened opened = open_node(system, error ? camera : path.string());
    if (opened.node) return std::move(*opened.node);
    throw CaptureError(fmt::format("camera \"{}\": {}", camera, opened.problem));
  }
  std::string problem = "there is no video device";
  std::vector<V4l2Node> all = find_nodes(system, problem);
  if (all.empty()) throw CaptureError(fmt::format("camera \"{}\": {}", camera, problem));
  if (camera.empty()) return std::move(all.front());
  std::vector<V4l2Node> found;
  for (const V4l2Node& node : all) {
    if (is_called(node, camera)) found.push_back(node);
  }
  if (found.size() == 1) return std::move(found.front());
  if (found.empty())
    throw CaptureError(fmt::format("camera \"{}\": not found; available: {}", camera, listed(all, all)));
  throw CaptureError(fmt::format("camera \"{}\": {} cameras have this name; use one of {}", camera,
                                 found.size(), listed(found, all)));
}

}  // namespace sslv
