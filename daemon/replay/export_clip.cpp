// SPDX-License-Identifier: Apache-2.0
#include "replay/export_clip.h"

#include "base/error.h"
#include "replay/png_file.h"
#include "vision/detections_json.h"
#include "vision/field_view.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>
#include <numbers>
#include <string_view>
#include <system_error>
#include <utility>

#include <Eigen/Geometry>
#include <fmt/format.h>

namespace sslv {
namespace {

constexpr int kShownOutsideMm = 300;

void write_export(const std::filesystem::path& file, std::string_view bytes) {
  std::ofstream out(file, std::ios::binary);
  out << bytes << std::flush;
  if (!out) throw StorageError(fmt::format("{}: cannot write: {}", file.string(), std::strerror(errno)));
}

std::string_view text_of(const std::vector<std::uint8_t>& bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

void make_export_folder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error)
    throw StorageError(fmt::format("{}: cannot create the folder: {}", folder.string(), error.message()));
  const bool is_empty = std::filesystem::is_empty(folder, error);
  if (error)
    throw StorageError(fmt::format("{}: cannot read the folder: {}", folder.string(), error.message()));
  if (!is_empty) throw StorageError(fmt::format("{}: is not empty; expected a new folder", folder.string()));
}

/// A copy of an image with some parts blackened.
class BlackedImage {
 public:
  /// Copies the rows without the driver's padding between them. The view is valid until the next call.
  const ImageView& copy(const ImageView& image) {
    const auto row_bytes = static_cast<std::size_t>(image.width * bytes_per_pixel(image.format));
    bytes_.resize(row_bytes * static_cast<std::size_t>(image.height));
    for (int y = 0; y < image.height; ++y)
      std::copy_n(image.row(y), row_bytes, bytes_.data() + static_cast<std::size_t>(y) * row_bytes);
    view_ = image;
    view_.data = bytes_.data();
    view_.stride_bytes = static_cast<std::ptrdiff_t>(row_bytes);
    view_.to_low_bits = 0;
    return view_;
  }

  /// Blackens everything that `view` hides, and everything outside the image size that it was made for.
  void blacken(const FieldView& view) {
    for (const PixelRectangle& hidden : hidden_by(view)) blacken(hidden);
    const int below_px = static_cast<int>(view.bands.size()) * FieldView::kBandPx;
    blacken({view.width_px, 0, view_.width, view_.height});
    blacken({0, below_px, view_.width, view_.height});
  }

  std::string_view bytes() const { return text_of(bytes_); }

 private:
  /// Never splits pairs (YUV 4:2:2) or quads (Bayer) of pixels, since the size of bands is even.
  void blacken(const PixelRectangle& hidden) {
    const int pixel_bytes = bytes_per_pixel(view_.format);
    const int left = std::clamp(hidden.left_px, 0, view_.width);
    const int right = std::clamp(hidden.left_px + hidden.width_px, left, view_.width);
    const int bottom = std::min(hidden.top_px + hidden.height_px, view_.height);
    for (int y = hidden.top_px; y < bottom; ++y) {
      std::uint8_t* row = bytes_.data() + y * view_.stride_bytes;
      std::fill(row + left * pixel_bytes, row + right * pixel_bytes, std::uint8_t{0});
      if (!is_yuv422(view_.format)) continue;
      constexpr std::uint8_t kNoColor = 128;
      for (int i = left * 2 + (view_.format == PixelFormat::kUyvy ? 0 : 1); i < right * 2; i += 2)
        row[i] = kNoColor;
    }
  }

  std::vector<std::uint8_t> bytes_;
  ImageView view_;
};

/// The view of the field up to kShownOutsideMm outside its lines, regardless of the boundary width.
FieldView shown_view(const Scene& scene) {
  Scene with_margin = scene;
  with_margin.field.boundary_width = kShownOutsideMm;
  with_margin.field.boundary_width_goal_line = kShownOutsideMm;
  return field_view(with_margin, 0);
}

/// Left, top, width and height in px.
using PixelBox = std::array<double, 4>;

/// Bounding box of projected points, clipped to the image.
class BoxMaker {
 public:
  explicit BoxMaker(const CameraModel& camera) : camera_(camera) {}

  void add_circle(const Eigen::Vector3d& middle_mm, const Eigen::Vector3d& x_mm,
                  const Eigen::Vector3d& y_mm) {
    constexpr int kPoints = 32;
    for (int i = 0; i < kPoints; ++i) {
      const double angle = 2 * std::numbers::pi * i / kPoints;
      const auto pixel = camera_.project(middle_mm + std::cos(angle) * x_mm + std::sin(angle) * y_mm);
      if (!pixel) continue;
      low_ = low_.cwiseMin(*pixel);
      high_ = high_.cwiseMax(*pixel);
    }
  }
  /// Our pixel centres have integer coordinates; COCO's boxes begin at a pixel's edge.
  PixelBox box(const ImageView& image) const {
    constexpr double kEdge = 0.5;
    const double left = std::clamp(low_.x() + kEdge, 0.0, 1.0 * image.width);
    const double top = std::clamp(low_.y() + kEdge, 0.0, 1.0 * image.height);
    return {left, top, std::clamp(high_.x() + kEdge, left, 1.0 * image.width) - left,
            std::clamp(high_.y() + kEdge, top, 1.0 * image.height) - top};
  }

 private:
  const CameraModel& camera_;
  Eigen::Vector2d low_{1e9, 1e9}, high_{-1e9, -1e9};
};

PixelBox robot_box(const Scene& scene, const Robot& robot, double radius_mm, const ImageView& image) {
  BoxMaker box(*scene.camera);
  for (const double z_mm : {0.0, robot.height_mm})
    box.add_circle({robot.x_mm, robot.y_mm, z_mm}, {radius_mm, 0, 0}, {0, radius_mm, 0});
  return box.box(image);
}

PixelBox ball_box(const Scene& scene, const Ball& ball, const ImageView& image) {
  const double radius_mm = scene.field.ball_radius;
  const Eigen::Vector3d middle_mm(ball.x_mm, ball.y_mm, radius_mm);
  // At this distance the outline is nearly a circle perpendicular to the line of sight.
  const Eigen::Vector3d sight = (middle_mm - scene.camera->position_mm()).normalized();
  const Eigen::Vector3d across = sight.unitOrthogonal();
  BoxMaker box(*scene.camera);
  box.add_circle(middle_mm, radius_mm * across, radius_mm * sight.cross(across));
  return box.box(image);
}

/// COCO's file for object detection.
class CocoFile {
 public:
  void add_frame(const std::string& file, std::uint32_t camera_id, const ClipReplay::Result& result,
                 const CameraContext& context) {
    const Frame& frame = *result.frame;
    const ImageView& image = frame.image.view();
    images_.push_back({{"id", images_.size() + 1},
                       {"file_name", file},
                       {"width", image.width},
                       {"height", image.height},
                       {"camera_id", camera_id},
                       {"t_capture", frame.info.times.t_capture_s}});
    if (!context.scene->camera) return;
    for (const Robot& robot : frame.robots.robots) {
      Json& added = add_annotation(robot.team == Team::kBlue ? kBlueRobot : kYellowRobot,
                                   robot_box(*context.scene, robot, context.patterns->top_radius_mm, image));
      added.update({{"robot_id", robot.id},
                    {"x_mm", robot.x_mm},
                    {"y_mm", robot.y_mm},
                    {"orientation_rad", robot.orientation_rad},
                    {"score", robot.confidence}});
    }
    for (const Ball& ball : frame.balls.balls) {
      Json& added = add_annotation(kBall, ball_box(*context.scene, ball, image));
      added.update({{"x_mm", ball.x_mm}, {"y_mm", ball.y_mm}, {"score", ball.confidence}});
    }
  }

  std::string text() const {
    const Json categories{{{"id", kYellowRobot}, {"name", "yellow robot"}, {"supercategory", "robot"}},
                          {{"id", kBlueRobot}, {"name", "blue robot"}, {"supercategory", "robot"}},
                          {{"id", kBall}, {"name", "ball"}, {"supercategory", "ball"}}};
    return json_text(Json{{"images", images_}, {"annotations", annotations_}, {"categories", categories}}) +
           "\n";
  }

 private:
  static constexpr int kYellowRobot = 1, kBlueRobot = 2, kBall = 3;

  Json& add_annotation(int category, const PixelBox& box) {
    annotations_.push_back({{"id", annotations_.size() + 1},
                            {"image_id", images_.size()},
                            {"category_id", category},
                            {"bbox", box},
                            {"area", box[2] * box[3]},
                            {"iscrowd", 0}});
    return annotations_.back();
  }

  Json images_ = Json::array(), annotations_ = Json::array();
};

ExportedCamera export_camera(ClipReader& clip, std::uint32_t camera_id, const ExportOptions& options) {
  const std::filesystem::path folder = options.folder / fmt::format("camera_{}", camera_id);
  make_export_folder(folder);
  const bool is_raw = options.format == ExportFormat::kRaw;
  ExportedCamera out{camera_id};
  ClipReplay replay(clip, camera_id, options.span);
  BlackedImage picture;
  std::shared_ptr<const Scene> view_scene;  // the scene for which `view` was made
  FieldView view;
  CocoFile coco;
  std::string truth;
  Json index{{"camera", camera_id}, {"frames", Json::array()}};
  ClipReplay::Result result;
  while (replay.next(result)) {
    const Frame& frame = *result.frame;
    const CameraContext& context = replay.setup().context;
    const std::string name = clip_frame_name(frame.info.number);
    const std::string file = name + (is_raw ? ".raw" : ".png");
    const ImageView& shown = picture.copy(frame.image.view());
    if (options.is_anonymous) {
      if (!context.scene->camera)
        throw StorageError(
            fmt::format("camera {} is not calibrated in frame {}, so the area outside the field is unknown; "
                        "calibrate it before recording, or export without --anonymous",
                        camera_id, frame.info.number));
      if (context.scene != view_scene) view = shown_view(*context.scene);
      view_scene = context.scene;
      picture.blacken(view);
    }
    if (is_raw) {
      write_export(folder / file, picture.bytes());
    } else {
      const std::vector<std::uint8_t> png = png_file(shown);
      write_export(folder / file, text_of(png));
    }
    Json line = truth_draft_json(name, shown.width, shown.height, frame.robots, frame.balls);
    line["t"] = frame.info.times.t_capture_s;
    truth += json_text(line) + "\n";
    index["frames"].push_back({{"file", file},
                               {"t", frame.info.times.t_capture_s},
                               {"width", shown.width},
                               {"height", shown.height},
                               {"pixel_format", is_raw ? name_of(shown.format) : "rgb24"}});
    if (options.with_coco) coco.add_frame(file, camera_id, result, context);
    ++out.frames;
    out.robots += frame.robots.robots.size();
    out.balls += frame.balls.balls.size();
  }
  write_export(folder / "truth.jsonl", truth);
  write_export(folder / "frames.json", json_text(index, 1) + "\n");
  if (options.with_coco) write_export(folder / "coco.json", coco.text());
  out.doubts = replay.doubts();
  return out;
}

}  // namespace

std::string clip_frame_name(std::uint32_t number) {
  return fmt::format("frame_{:06}", number);
}

std::vector<ExportedCamera> export_clip(ClipReader& clip, const ExportOptions& options) {
  make_export_folder(options.folder);
  std::vector<ExportedCamera> out;
  if (options.camera_id) {
    out.push_back(export_camera(clip, *options.camera_id, options));
  } else {
    for (const ClipReader::Camera& camera : clip.cameras())
      out.push_back(export_camera(clip, camera.id, options));
  }
  return out;
}

}  // namespace sslv
