// SPDX-License-Identifier: Apache-2.0
// The stage "april_tags" detects AprilTags, publishes those on robots, and stores all of them in a part of
// the frame that this library defines. "tag_corners" reads that part and measures the error of the
// calibration with tags on the field's corners.
#include <cmath>
#include <cstdio>
#include <memory>

#include <apriltag/apriltag.h>
#include <apriltag/tag16h5.h>
#include <apriltag/tag36h11.h>
#include <image/pixel_at.h>
#include <kit/stages.h>

using namespace sslv;

/// A tag's centre on the plane z = height, and the direction of its upper edge, counter-clockwise from +x.
struct Tag {
  int id;
  double x_mm, y_mm, orientation_rad, height_mm, pixel_x, pixel_y;
  double margin;  // AprilTag's decision margin: how clear its bits are, grey levels
};
/// Another library can read this part if it defines a part with the same name and members.
struct TagList {
  static constexpr std::string_view kPartName = "tags";
  std::vector<Tag> tags;
  void clear() { tags.clear(); }
};

enum class Family { k36h11, k16h5 };
constexpr std::array<Choice<Family>, 2> kFamilies{{{"tag36h11", Family::k36h11}, {"tag16h5", Family::k16h5}}};
constexpr std::array<Choice<Team>, 2> kTeams{{{"yellow", Team::kYellow}, {"blue", Team::kBlue}}};

class AprilTags {
 public:
  struct Params {
    Family family = Family::k36h11;
    double decimate = 1, min_margin = 25, height_mm = 0;
    std::optional<Team> team;
    std::array<int, 2> robot_tags{0, 15};
    static constexpr auto fields() {
      return std::tuple{
          choice("family", &Params::family, kFamilies, "tag family to detect"),
          number("decimate", &Params::decimate, 1.0, 4.0, "", "image scale divisor for edge detection"),
          number("min_margin", &Params::min_margin, 0.0, 255.0, "", "minimum contrast of the bits"),
          number("height_mm", &Params::height_mm, 0.0, 10'000.0, "mm", "height of other tags"),
          choice("team", &Params::team, kTeams, "team whose robots wear tags; null: no team"),
          range("robot_tags", &Params::robot_tags, 0, 586, "", "tag ids of robots; the first is on robot 0")};
    }
  };
  AprilTags() { look_for(Family::k36h11); }
  // AprilTag allocates for each image: `ssl-visionlab bench` shows whether a camera can afford it.
  void process(const Params& params, const Scene& scene, const Mask& mask, const Image& image,
               Update<RobotList> robots, TagList& list, StageNotes& notes) noexcept {
    const ImageView& view = image.view();
    if (!scene.camera || std::min(view.width, view.height) < 32)  // AprilTag cannot handle smaller images
      return notes.say("needs a calibrated camera and an image of at least 32 x 32 pixels");
    if (params.family != family_) look_for(params.family);
    detector_->quad_decimate = static_cast<float>(params.decimate);
    copy_grey(view, grey_);
    image_u8_t grey{view.width, view.height, view.width, grey_.data()};
    zarray_t* found = apriltag_detector_detect(detector_.get(), &grey);
    for (int i = 0; i < zarray_size(found); ++i) {
      apriltag_detection_t* one = nullptr;
      zarray_get(found, i, &one);
      const bool is_robot = params.team && one->id >= params.robot_tags[0] && one->id <= params.robot_tags[1];
      const auto tag =
          locate(*one, *scene.camera, is_robot ? scene.height_of(*params.team) : params.height_mm);
      if (!tag || tag->margin < params.min_margin || !mask.shows(tag->pixel_x, tag->pixel_y)) continue;
      list.tags.push_back(*tag);
      if (is_robot) add_robot(*params.team, tag->id - params.robot_tags[0], *tag, *robots);
    }
    apriltag_detections_destroy(found);
    notes.say("tags: " + std::to_string(list.tags.size()));
  }

 private:
  /// Nothing if a corner's ray does not meet the plane.
  static std::optional<Tag> locate(const apriltag_detection_t& found, const CameraModel& camera,
                                   double height_mm) {
    std::array<Eigen::Vector2d, 4> corners;  // counter-clockwise from the lower left one
    for (std::size_t i = 0; i < corners.size(); ++i) {
      // AprilTag's origin is the first pixel's corner, ours is its centre.
      const auto place = camera.unproject({found.p[i][0] - 0.5, found.p[i][1] - 0.5}, height_mm);
      if (!place) return std::nullopt;
      corners[i] = *place;
    }
    const Eigen::Vector2d middle = (corners[0] + corners[1] + corners[2] + corners[3]) / 4;
    const Eigen::Vector2d up = corners[2] + corners[3] - corners[0] - corners[1];
    const double orientation_rad = std::atan2(up.y(), up.x());
    return Tag{found.id,  middle.x(),       middle.y(),       orientation_rad,
               height_mm, found.c[0] - 0.5, found.c[1] - 0.5, found.decision_margin};
  }

  /// Does nothing if the robot's pattern was found. The list is sorted by falling confidence.
  static void add_robot(Team team, int id, const Tag& tag, RobotList& list) {
    for (const Robot& robot : list.robots)
      if (robot.team == team && robot.id == id) return;
    list.robots.insert(list.robots.begin(), {team, id, tag.x_mm, tag.y_mm, tag.orientation_rad, tag.height_mm,
                                             tag.pixel_x, tag.pixel_y, 1});
  }

  void look_for(Family family) {
    detector_ = {apriltag_detector_create(), apriltag_detector_destroy};
    detector_->nthreads = 1;  // the calling thread: the camera's
    tags_ = family == Family::k16h5 ? std::shared_ptr<apriltag_family_t>(tag16h5_create(), tag16h5_destroy)
                                    : std::shared_ptr<apriltag_family_t>(tag36h11_create(), tag36h11_destroy);
    apriltag_detector_add_family_bits(detector_.get(), tags_.get(), 0);  // corrects no bits: fewer errors
    family_ = family;
  }

  Family family_{};
  std::shared_ptr<apriltag_family_t> tags_;
  std::shared_ptr<apriltag_detector_t> detector_;  // destroyed before the family that it uses
  std::vector<std::uint8_t> grey_;
};

class TagCorners {
 public:
  struct Params {
    int first_id = 100;
    double max_off_mm = 20;
    static constexpr auto fields() {
      return std::tuple{
          number("first_id", &Params::first_id, 0, 583, "", "on the corner +x +y; others counter-clockwise"),
          number("max_off_mm", &Params::max_off_mm, 0.0, 1'000.0, "mm", "more is a warning")};
    }
  };
  void process(const Params& params, const Scene& scene, const TagList& list, StageNotes& notes) noexcept {
    double most_mm = 0;
    text_.clear();  // keeps its memory for the next image
    for (const Tag& tag : list.tags) {
      const int corner = tag.id - params.first_id;
      if (corner < 0 || corner > 3) continue;
      const double dx_mm = tag.x_mm - (corner == 0 || corner == 3 ? 0.5 : -0.5) * scene.field.field_length;
      const double dy_mm = tag.y_mm - (corner < 2 ? 0.5 : -0.5) * scene.field.field_width;
      std::array<char, 64> line{};
      std::snprintf(line.data(), line.size(), "tag %d is off by (%+.1f, %+.1f) mm; ", tag.id, dx_mm, dy_mm);
      text_ += line.data();
      most_mm = std::max(most_mm, std::hypot(dx_mm, dy_mm));
    }
    most_mm > params.max_off_mm ? notes.warn(text_)
                                : notes.say(text_.empty() ? "no corner tag in view" : text_);
  }

 private:
  std::string text_;
};
SSLV_STAGES(stage<AprilTags>("april_tags", "finds AprilTags; those on robots are published"),
            stage<TagCorners>("tag_corners", "says how far tags lie off the field's corners"))
