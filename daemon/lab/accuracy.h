// SPDX-License-Identifier: Apache-2.0
#pragma once

// The accuracy suite: simulated images under named conditions, detected and compared with the truth. A file
// defines the conditions and the required results (tests/golden/accuracy.json).

#include "base/json.h"
#include "base/params.h"
#include "colors/light_follower.h"
#include "geometry/camera_model.h"
#include "geometry/field.h"
#include "lab/score.h"
#include "vision/lut_from_samples.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

namespace sslv {

/// A field and the camera over it; the calibration gives the image size.
struct AccuracyField {
  FieldSize size;
  CameraCalibration calibration;
  int frames = 40;
  static constexpr auto fields() {
    using F = AccuracyField;
    return std::tuple{
        group("size", &F::size, "sizes of the playing field"),
        group("calibration", &F::calibration, "of the camera, and the size of its images"),
        number("frames", &F::frames, 1, 100'000, "", "images for each condition"),
    };
  }
};

/// Limits for a result; null: no limit.
struct AccuracyLimits {
  std::optional<double> recall, position_rms_mm, orientation_rms_deg;
  std::optional<int> wrong_id, invented;
  std::optional<double> ball_recall, ball_precision, ball_rms_mm;
  std::optional<double> false_balls_in_100;
  std::optional<double> worst_recall, worst_ball_recall;
  std::optional<double> position_over_bound, orientation_over_bound;
  static constexpr auto fields() {
    using L = AccuracyLimits;
    return std::tuple{
        number("recall", &L::recall, 0.0, 1.0, "", "least share of the visible robots found"),
        number("wrong_id", &L::wrong_id, 0, 1'000'000, "", "most robots with a wrong id"),
        number("invented", &L::invented, 0, 1'000'000, "", "most robots that are none"),
        number("position_rms_mm", &L::position_rms_mm, 0.0, 1000.0, "mm", "largest error of position"),
        number("orientation_rms_deg", &L::orientation_rms_deg, 0.0, 180.0, "deg",
               "largest error of orientation"),
        number("ball_recall", &L::ball_recall, 0.0, 1.0, "", "least share of the visible balls found"),
        number("ball_precision", &L::ball_precision, 0.0, 1.0, "", "least share of the found balls that are"),
        number("ball_rms_mm", &L::ball_rms_mm, 0.0, 1000.0, "mm", "largest error of a ball's position"),
        number("false_balls_in_100", &L::false_balls_in_100, 0.0, 1e5, "",
               "most balls that are none, in 100 images"),
        number("worst_recall", &L::worst_recall, 0.0, 1.0, "",
               "least recall of robots in any five seconds of a film"),
        number("worst_ball_recall", &L::worst_ball_recall, 0.0, 1.0, "", "the same of balls"),
        number("position_over_bound", &L::position_over_bound, 1.0, 1000.0, "",
               "largest error of position, as a multiple of the least one that the samples allow"),
        number("orientation_over_bound", &L::orientation_over_bound, 1.0, 1000.0, "",
               "the same of orientation"),
    };
  }
};

/// The source of a condition's colour table.
enum class AccuracyColors : std::uint8_t {
  kClicked,  // from an admin's simulated clicks in other images: eight places for each label
  kLearnt,   // from other images by learn_colors(), without a click
};
inline constexpr std::array<Choice<AccuracyColors>, 2> kAccuracyColorsChoices{
    {{"clicked", AccuracyColors::kClicked}, {"learnt", AccuracyColors::kLearnt}}};

/// A condition. It has a line in the report for each of its pixel formats.
struct AccuracyCondition {
  std::string name;
  std::string field;
  std::vector<std::string> pixel_formats{"uyvy"};
  std::optional<double> px_per_mm;
  Json source = Json::object();
  std::vector<int> halls;
  std::optional<AccuracyColors> colors;
  std::optional<int> learn_frames;
  Json learn_source = Json::object();
  double robot_height = 140;
  Json teams = Json::object();
  Json stages = Json::object();
  double min_ball_share = 1;
  bool cut_to_8_bits = false;
  std::optional<int> frames;
  std::optional<double> film_hz;
  FollowLightParams follow_light;
  Json must = Json::object();
  static constexpr auto fields() {
    using C = AccuracyCondition;
    return std::tuple{
        text("name", &C::name, "for people and --only"),
        text("field", &C::field, "one of the suite's fields"),
        names("pixel_formats", &C::pixel_formats, "each is a line of the table"),
        number("px_per_mm", &C::px_per_mm, 0.01, 10.0, "px/mm",
               "the camera is scaled to this resolution on the floor in its middle; null: it is not"),
        object("source", &C::source, "the simulator's options, over the suite's options"),
        numbers(
            "halls", &C::halls, 0, 1'000'000,
            "seeds of halls that share the images, each with a colour table of its own; none: the suite's "
            "seeds, or the one that source says"),
        choice("colors", &C::colors, kAccuracyColorsChoices, "instead of what the suite says"),
        number("learn_frames", &C::learn_frames, 1, 30, "", "instead of what the suite says"),
        object("learn_source", &C::learn_source,
               "the simulator's options for the images that the colours come from, over source"),
        number("robot_height", &C::robot_height, 20.0, 1000.0, "mm", "height of the patterns of both teams"),
        object("teams", &C::teams, "settings of the teams"),
        object("stages", &C::stages, "parameters of the stages"),
        number("min_ball_share", &C::min_ball_share, 0.0, 1.0, "",
               "a ball of which less is in sight need not be found"),
        flag("cut_to_8_bits", &C::cut_to_8_bits, "images of more bits are cut to 8, for comparison"),
        number("frames", &C::frames, 1, 100'000, "", "images; null: as many as the field says"),
        number("film_hz", &C::film_hz, 1.0, 1000.0, "Hz",
               "images follow each other like this, and the colours were clicked at before light_swing and "
               "cast_swing began; null: they have little in common"),
        group("follow_light", &C::follow_light, "the colour table follows the light of a film"),
        object("must", &C::must, "how good the result must be, over the suite's"),
    };
  }
};

struct AccuracySuite {
  std::string file;
  AccuracyColors colors = AccuracyColors::kClicked;
  std::optional<int> learn_frames;
  std::vector<int> halls;
  Json source = Json::object(), learn_source = Json::object(), stages = Json::object(), must = Json::object();
  Json named_fields = Json::object();
  std::vector<AccuracyCondition> conditions;
  static constexpr auto fields() {
    using S = AccuracySuite;
    return std::tuple{
        choice("colors", &S::colors, kAccuracyColorsChoices,
               "where the colour tables come from: clicked: a few places in other images; learnt: other "
               "images and no click"),
        number("learn_frames", &S::learn_frames, 1, 30, "",
               "how many images that is; null: two with clicks, three without"),
        numbers("halls", &S::halls, 0, 1'000'000, "the halls of every condition that names none"),
        object("source", &S::source, "the simulator's options in every condition"),
        object("learn_source", &S::learn_source,
               "the same for the images that the colours come from, over source"),
        object("stages", &S::stages, "parameters of the stages in every condition"),
        object("must", &S::must, "how good the result must be in every condition"),
        object("fields", &S::named_fields, "fields with their cameras, by name"),
        list("conditions", &S::conditions, "what is to be tried"),
    };
  }
};

/// Reads and validates a suite. Throws SettingsError, beginning with the file's name and the key.
AccuracySuite read_accuracy_suite(const std::string& file);

/// Root mean squares of the Cramer-Rao bounds (accuracy_bound.h) of the robots that should be found.
struct AccuracyBound {
  std::size_t robots = 0;  // 0: no bound is known, as without noise or with a rolling shutter
  double position_mm = 0, orientation_deg = 0;
};

/// Result of one condition in one pixel format.
struct AccuracyRow {
  std::string condition, pixel_format;
  AccuracyColors colors;
  double px_per_mm;  // on the floor in the middle of the image
  Score score;
  std::vector<std::string> failures;  // missed limits, in words
  /// A part of a film.
  struct Stretch {
    static constexpr double kSeconds = 5;
    double begin_s;
    FoundCounts robots, balls;
    LightChange change{};  // change of the colour table up to the end of this part
  };
  std::vector<Stretch> film{};
  AccuracyBound bound{};

  /// Errors as multiples of their bounds; none if there is no bound, or if nothing was found.
  std::optional<double> position_over_bound() const;
  std::optional<double> orientation_over_bound() const;
};

/// Detected balls with no true ball at their place, per 100 frames.
double false_balls_in_100(const Score& score);

/// Correct detections by confidence: robots with the right id, balls at the place of a true ball.
struct Reliability {
  static constexpr std::size_t kBins = 10;  // 0 - 0.1, ..., 0.9 - 1
  struct Bin {
    std::size_t count = 0, right = 0;
  };
  std::array<Bin, kBins> robots, balls;
};

struct AccuracyReport {
  std::vector<AccuracyRow> rows;
  Reliability reliability;

  bool passed() const;
};

struct AccuracyOptions {
  std::vector<std::string> only;              // names of the conditions to run; empty: all
  std::optional<int> frames;                  // frames for each condition, instead of the field's number
  std::optional<AccuracyColors> colors = {};  // instead of the suite's choice
  /// Called after each row.
  std::function<void(const AccuracyRow&)> done = [](const AccuracyRow&) {};
};

/// Runs the camera's default stack over simulated images of each condition and scores the result. The colour
/// table is made under the same condition, except for learn_source, from other images: by lut_from_samples()
/// from clicks spread over the image, or by learn_colors(). If nothing could be learnt, nothing is found, and
/// the row has the reason. The same suite gives the same report. Throws SettingsError for a name in `only`
/// that is not in the suite, CaptureError if the simulator cannot draw a condition.
AccuracyReport run_accuracy_suite(const AccuracySuite& suite, const AccuracyOptions& options);

/// Human-readable tables, plain or as Markdown. Rows that miss a limit are marked, and listed below.
std::string accuracy_text(const AccuracyReport& report, bool markdown);
Json accuracy_json(const AccuracyReport& report);

}  // namespace sslv
