// SPDX-License-Identifier: Apache-2.0
#include "capture/tile.h"

#include "base/error.h"
#include "base/params_json.h"
#include "capture/control_queue.h"
#include "capture/shared_camera.h"

#include <utility>

#include <fmt/format.h>

namespace sslv {
namespace {

struct TileOptions {
  Json of = Json::object();
  int x = 0, y = 0, width = 2, height = 2;
  Json controls = Json::object();
  static constexpr auto fields() {
    using O = TileOptions;
    return std::tuple{
        object("of", &O::of, "the big camera: \"backend\" and its options, the same for all of its tiles"),
        number("x", &O::x, 0, 16382, "px", "left edge in the big image; even"),
        number("y", &O::y, 0, 16382, "px", "upper edge in the big image; even"),
        number("width", &O::width, 2, 16384, "px", "even"),
        number("height", &O::height, 2, 16384, "px", "even"),
        object("controls", &O::controls,
               "settings of the big camera itself; those of all its tiles are applied"),
    };
  }
};

class TileSource final : public Source {
 public:
  TileSource(const TileOptions& options, const SharedCamera::Open& open)
      : options_(options), taker_(SharedCamera::get(json_text(options.of), open)) {
    warnings_ = taker_.camera().warnings();
    if (const auto controls = taker_.camera().controls()) controls->queue().share_with(options_.controls);
  }

  CaptureStatus next(CapturedImage& image, std::string& problem, std::chrono::milliseconds timeout) override {
    CapturedImage whole;
    const CaptureStatus status = taker_.next(whole, problem, timeout);
    if (status != CaptureStatus::kImage) return status;
    const ImageView view = whole.image.view();
    if (options_.x + options_.width > view.width || options_.y + options_.height > view.height) {
      problem = fmt::format("the tile of {} x {} at ({}, {}) is not within the camera's {} x {} pixels",
                            options_.width, options_.height, options_.x, options_.y, view.width, view.height);
      return CaptureStatus::kLost;
    }
    ImageView tile = view;
    tile.data = view.row(options_.y) + std::ptrdiff_t{options_.x} * bytes_per_pixel(view.format);
    tile.width = options_.width;
    tile.height = options_.height;
    image = std::move(whole);
    image.image.narrow_to(tile);
    // The camera itself may read only part of its sensor.
    if (image.whole.width == 0) image.whole = {view.width, view.height};
    image.whole.x += options_.x;
    image.whole.y += options_.y;
    return CaptureStatus::kImage;
  }

  std::uint64_t dropped() const noexcept override { return taker_.dropped(); }
  std::optional<PacketCounts> packets() const noexcept override { return taker_.packets(); }
  std::shared_ptr<Controls> controls() override { return taker_.camera().controls(); }
  std::vector<std::string> warnings() const override { return warnings_; }

 private:
  const TileOptions options_;
  SharedCamera::Taker taker_;
  std::vector<std::string> warnings_;
};

}  // namespace

Json complete_tile(const Json& json, const std::string& path,
                   Json (*complete_source)(const Json& source, const std::string& path)) {
  auto options = params_from_json<TileOptions>(json, path);
  for (const auto& [key, value] :
       {std::pair{"x", options.x}, {"y", options.y}, {"width", options.width}, {"height", options.height}}) {
    // Two neighbouring pixels share colour, in YUV 4:2:2 and in Bayer images.
    if (value % 2 != 0) {
      throw SettingsError(fmt::format("{}/{}: {} is not allowed; expected an even number", path, key, value));
    }
  }
  options.of = complete_source(options.of, path + "/of");
  if (options.of.at("backend") == "tile")
    throw SettingsError(path + "/of/backend: \"tile\" is not allowed; expected a whole camera");
  return params_to_json(options);
}

Json tile_schema() {
  return params_schema<TileOptions>();
}

std::unique_ptr<Source> open_tile(
    const Json& json, const std::function<std::unique_ptr<Source>(const Json& source)>& open_source) {
  const auto options = params_from_json<TileOptions>(json, "");
  return std::make_unique<TileSource>(options, [&] { return open_source(options.of); });
}

SourceContext whole_camera(const Json& json, SourceContext context) {
  if (!context.scene.camera) return context;
  const auto options = params_from_json<TileOptions>(json, "");
  CameraCalibration whole = context.scene.camera->calibration();
  whole.principal_point_x += options.x;
  whole.principal_point_y += options.y;
  whole.pixel_image_width = options.of.value("width", 0);
  whole.pixel_image_height = options.of.value("height", 0);
  context.scene.camera.emplace(whole);
  return context;
}

}  // namespace sslv
