// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/params.h"
#include "colors/light_areas.h"
#include "colors/table_in_light.h"
#include "geometry/scene.h"
#include "image/image.h"
#include "vision/detections.h"
#include "vision/lut.h"
#include "vision/pattern_fit.h"
#include "vision/patterns.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

namespace sslv {

/// Settings: whether and how far a camera's colour table follows the light.
struct FollowLightParams {
  bool enabled = false;
  bool in_match = false;
  double max_brightness = 4;
  double max_balance = 1.3;
  double max_brightness_per_min = 6;
  double max_balance_per_min = 1.2;
  double min_confidence = 0.9;
  int min_robots = 2;

  static constexpr auto fields() {
    using P = FollowLightParams;
    return std::tuple{
        flag("enabled", &P::enabled, "the colour table follows the light on confirmed robots"),
        flag("in_match", &P::in_match,
             "also while the game is running; otherwise the table does not change then"),
        number("max_brightness", &P::max_brightness, 1.0, 8.0, "",
               "largest factor by which the light may become brighter or darker than for the accepted table"),
        number("max_balance", &P::max_balance, 1.0, 2.0, "",
               "largest factor by which red, green and blue may each differ from their common brightness"),
        number("max_brightness_per_min", &P::max_brightness_per_min, 1.0, 64.0, "",
               "largest factor between the brightness now and any in the last minute"),
        number("max_balance_per_min", &P::max_balance_per_min, 1.0, 4.0, "",
               "the same for red, green and blue against their common brightness"),
        number("min_confidence", &P::min_confidence, 0.0, 1.0, "",
               "robots below this confidence are not used"),
        number("min_robots", &P::min_robots, 1, 16, "", "with fewer confirmed robots, the table is frozen"),
    };
  }
};

enum class LightFollowing : std::uint8_t {
  kOff,
  kLearning,  // determines the references from the first robots
  kFollowing,
  kAtBound,  // the light has changed more than the table may follow
  kFrozen,   // no robot is confirmed, or following is not allowed
};
/// Name in the interface: "off", "learning", "following", "at_bound", "frozen".
const char* name_of(LightFollowing following);

struct LightState {
  static constexpr int kColumns = LightAreas::kColumns, kRows = LightAreas::kRows;

  LightFollowing following = LightFollowing::kOff;
  std::string why;                      // reason why it is frozen, or the bound reached; for the user
  std::array<double, 3> gain{1, 1, 1};  // factors on red, green and blue since the table was accepted
  /// Change of brightness of each area relative to the whole image since the area was first seen; 1 if too
  /// few robots were in the area. Row by row.
  std::array<double, std::size_t{kColumns} * kRows> areas;
  int robots = 0;                          // number confirmed in the newest image; 0 if too few
  std::optional<double> last_confirmed_s;  // when enough robots were last confirmed
  bool from_carpet = false;                // gain on trial after a jump of the carpet's brightness

  LightState() { areas.fill(1); }
};

/// A change of the table in use.
struct LightStep {
  double time_s;
  LightChange change;
  int robots;        // confirmed in the newest image
  bool from_carpet;  // based on the carpet, not on robots
};

/// Estimates how the light on a camera's field changes, from robots whose five dots all fit, and makes the
/// colour table follow. It ignores balls, regions and pixels outside a robot's pattern. A jump of the
/// carpet's brightness only starts a short trial.
///
/// The reference contrast of a team's dots of one colour is determined from the first confirmed dots and then
/// kept, so that nothing drifts. Later dots determine the light: a gain each for red, green and blue (the
/// median over all dots) and, more slowly, a brightness for each area of the image.
///
/// Has no thread and reads no clock. A few images per second are enough.
class LightFollower {
 public:
  explicit LightFollower(std::shared_ptr<const Lut> accepted);

  /// One processed image.
  struct Look {
    double time_s;
    const ImageView& image;
    const Scene& scene;
    const PatternTable& patterns;
    std::span<const Robot> robots;  // robots found in the image
    bool game_is_running = false;
  };
  void observe(const FollowLightParams& params, const Look& look);
  /// Returns to the accepted table. If enabled again, the follower starts over and assumes that the accepted
  /// table fits the light at that moment.
  void switch_off();

  /// Makes a new table if the light has changed since the last table; otherwise returns null. Takes tens
  /// of milliseconds.
  std::shared_ptr<const Lut> new_table();
  const std::shared_ptr<const Lut>& table() const { return tables_.in_use; }
  const std::shared_ptr<const Lut>& accepted() const { return tables_.accepted; }

  /// Returns to the accepted table; the follower is frozen until it is switched off.
  void take_back();

  const LightState& state() const { return state_; }
  /// The newest steps, oldest first.
  const std::deque<LightStep>& steps() const { return steps_; }

 private:
  using Log3 = std::array<double, 3>;  // logarithms, of red, green and blue
  struct Tables {
    std::shared_ptr<const Lut> accepted, in_use;
    LightChange change;  // from `accepted` to `in_use`
  };
  /// Contrast of a dot's colour in the light of the accepted table, in an area of average brightness.
  struct Reference {
    std::array<int, 3> count{};
    Log3 contrast{};  // logarithm
  };
  using Key = std::pair<Team, Label>;
  struct Dot {
    Key key;
    std::size_t robot, area;
    std::array<double, 3> contrast;  // contrast of red, green and blue in grey levels
    double sigma_grey;               // noise of each channel
    std::array<bool, 3> below_end;   // the channel is not clipped
  };
  /// Difference of a dot's channel from its expected value.
  struct Difference {
    double log, weight;
  };
  using AreaLuma = std::array<float, LightAreas::kCount>;
  /// A jump of the carpet's brightness at which the robots disappeared.
  struct CarpetJump {
    /// The last image with confirmed robots.
    struct Before {
      double time_s;
      AreaLuma luma;
      std::size_t robots;
    };
    struct Trial {
      double began_s;
      Log3 gain;  // before the trial
    };
    std::optional<Before> before;
    std::optional<Trial> trial;
  };

  std::vector<Dot> confirmed_dots(const FollowLightParams& params, const Look& look);
  std::optional<Difference> difference(const Dot& dot, std::size_t channel, int min_count) const;
  bool follow_robots(const FollowLightParams& params, const Look& look, const std::vector<Dot>& dots);
  void learn_areas(const std::vector<Dot>& dots);
  void learn_references(const std::vector<Dot>& dots);
  void try_carpet(const FollowLightParams& params, const Look& look, const AreaLuma& luma);
  Log3 bounded(const FollowLightParams& params, Log3 gain, std::string& bound) const;
  void set_gain(const Log3& gain);
  void freeze(std::string why);
  LightChange change() const;

  Tables tables_;
  LightState state_;
  std::deque<LightStep> steps_;
  bool taken_back_ = false, has_followed_ = false;
  double time_s_ = 0;  // time of the newest image

  PatternFitter fitter_;
  Log3 gain_{};
  std::deque<std::pair<double, Log3>> last_minute_;
  std::map<Key, Reference> references_;
  LightAreas areas_;
  CarpetJump carpet_;
};

}  // namespace sslv
