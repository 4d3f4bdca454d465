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

/// Whether and how far a camera's colour table follows the light.
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
        number("min_confidence", &P::min_confidence, 0.0, 1.0, "", "robots below it are not used"),
        number("min_robots", &P::min_robots, 1, 16, "", "with fewer confirmed robots it is frozen"),
    };
  }
};

enum class LightFollowing : std::uint8_t {
  kOff,
  kLearning,   // the first robots are to show how the accepted table's colours look
  kFollowing,  // the light
  kAtBound,    // the light is further away than the table may follow
  kFrozen,     // nothing is confirmed, or it may not
};
/// As in the interface: "off", "learning", "following", "at_bound", "frozen".
const char* name_of(LightFollowing following);

struct LightState {
  static constexpr int kColumns = LightAreas::kColumns, kRows = LightAreas::kRows;

  LightFollowing following = LightFollowing::kOff;
  std::string why;                      // frozen, or which bound; for people
  std::array<double, 3> gain{1, 1, 1};  // of red, green and blue since the table was accepted
  /// Each part of the image beside the whole, since it was first seen; 1 where too few robots were. Row by
  /// row.
  std::array<double, std::size_t{kColumns} * kRows> areas;
  int robots = 0;                          // that counted in the newest image
  std::optional<double> last_confirmed_s;  // when enough of them last did
  bool from_carpet = false;                // a jump of the carpet's light was followed, robots are awaited

  LightState() { areas.fill(1); }
};

/// A table that was put into use.
struct LightStep {
  double time_s;
  LightChange change;
  int robots;        // that said so
  bool from_carpet;  // or the carpet did
};

/// Finds how the light on a camera's field changes, from robots whose five dots all fit, and makes the colour
/// table follow. Nothing else teaches: no ball, no region, no pixel without a robot's pattern about it.
///
/// What a team's dot of one colour looks like is taken from the first that are confirmed while the accepted
/// table is in use, and then stays, so that nothing drifts. Later ones tell the light: one gain for each of
/// red, green and blue, the median over all dots, and beside it, slowly, a brightness for each part of the
/// image.
///
/// Has no thread and reads no clock. Images a few times a second will do.
class LightFollower {
 public:
  explicit LightFollower(std::shared_ptr<const Lut> accepted);

  /// One finished image.
  struct Look {
    double time_s;
    const ImageView& image;
    const Scene& scene;
    const PatternTable& patterns;
    std::span<const Robot> robots;  // found in it
    bool game_is_running = false;
  };
  void observe(const FollowLightParams& params, const Look& look);
  /// Back to the accepted table. Switched on again it starts over: the accepted table is right for the light
  /// at that moment.
  void switch_off();

  /// Makes a new table when the light has changed since the last one; null when it has not. Takes some
  /// tens of milliseconds.
  std::shared_ptr<const Lut> new_table();
  const std::shared_ptr<const Lut>& table() const { return tables_.in_use; }
  const std::shared_ptr<const Lut>& accepted() const { return tables_.accepted; }

  /// Back to the accepted table; frozen until it was switched off.
  void take_back();

  const LightState& state() const { return state_; }
  /// The newest ones, oldest first.
  const std::deque<LightStep>& steps() const { return steps_; }

 private:
  using Log3 = std::array<double, 3>;  // logarithms, of red, green and blue
  struct Tables {
    std::shared_ptr<const Lut> accepted, in_use;
    LightChange change;  // from the one to the other
  };
  /// How a dot's colour looks in the light of the accepted table, in a part of middling light.
  struct Reference {
    std::array<int, 3> count{};
    Log3 contrast{};  // logarithm
  };
  using Key = std::pair<Team, Label>;
  struct Dot {
    Key key;
    std::size_t robot, area;
    std::array<double, 3> contrast;  // of red, green and blue; grey levels
    double sigma_grey;               // of each of these, by noise
    std::array<bool, 3> below_end;   // the channel is not at its upper end
  };
  /// A dot's channel against what is expected of it.
  struct Difference {
    double log, weight;
  };
  using AreaLuma = std::array<float, LightAreas::kCount>;
  /// Whether the carpet's light jumped when the robots were gone.
  struct CarpetJump {
    /// The image when robots were last confirmed.
    struct Before {
      double time_s;
      AreaLuma luma;
      std::size_t robots;
    };
    struct Trial {
      double began_s;
      Log3 gain;  // to go back to
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
  double time_s_ = 0;  // of the newest image

  PatternFitter fitter_;
  Log3 gain_{};
  std::deque<std::pair<double, Log3>> last_minute_;
  std::map<Key, Reference> references_;
  LightAreas areas_;
  CarpetJump carpet_;
};

}  // namespace sslv
