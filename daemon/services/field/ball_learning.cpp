// SPDX-License-Identifier: Apache-2.0
#include "services/field/ball_learning.h"

#include "base/log.h"
#include "base/params_json.h"
#include "web/route.h"

#include <array>
#include <cmath>

#include <fmt/format.h>

namespace sslv {
namespace {

constexpr double kMmPerMeter = 1000;

/// A number in the settings' ball_models: its key, its learnt value, and the factor that converts the learnt
/// value to the unit of the settings.
struct Number {
  const char* key;
  LearntBallModel::Value LearntBallModel::*learnt;
  double factor;
};
constexpr std::array<Number, 6> kNumbers{{{"acc_slide", &LearntBallModel::slides_mm_s2, -1 / kMmPerMeter},
                                          {"acc_roll", &LearntBallModel::rolls_mm_s2, -1 / kMmPerMeter},
                                          {"k_switch", &LearntBallModel::rolls_from_share, 1},
                                          {"damping_xy_first_hop", &LearntBallModel::first_hop_xy, 1},
                                          {"damping_xy_other_hops", &LearntBallModel::later_hops_xy, 1},
                                          {"damping_z", &LearntBallModel::hops_z, 1}}};

/// Rounds `value` to the second significant digit of its uncertainty `sigma`.
double rounded(double value, double sigma) {
  const double step = std::pow(10, std::floor(std::log10(std::max(1e-6, sigma))) - 1);
  return std::round(value / step) * step;
}

}  // namespace

BallLearning::BallLearning() {
  queue_.prepare([](WatchedKick& slot) { slot.points.reserve(WatchedKick::kMaxPoints); });
}

void BallLearning::hand_over(const WatchedKick& kick) noexcept {
  WatchedKick* const slot = queue_.to_write();
  if (!slot) return;
  slot->kick = kick.kick;
  slot->points.assign(kick.points.begin(), kick.points.end());
  queue_.write();
}

void BallLearning::learn(const BallModel& model) {
  while (const WatchedKick* kick = queue_.to_read()) {
    {
      const std::lock_guard lock(mutex_);
      learner_.learn(*kick, model);
    }
    queue_.read();
  }
}

Json BallLearning::to_json(const std::optional<BallModels>& now) const {
  const std::lock_guard lock(mutex_);
  const LearntBallModel& learnt = learner_.learnt();
  const Json in_settings = now ? params_to_json(*now) : Json(nullptr);
  Json out{{"kicks", learnt.kicks}, {"chips", learnt.chips}, {"numbers", Json::array()}};
  for (const Number& number : kNumbers) {
    const LearntBallModel::Value& value = learnt.*number.learnt;
    const double sigma = value.sigma * std::abs(number.factor);
    out["numbers"].push_back(
        {{"key", number.key},
         {"learnt", value.is_known() ? Json(rounded(value.value * number.factor, sigma)) : Json(nullptr)},
         {"sigma", value.is_known() ? Json(rounded(sigma, sigma)) : Json(nullptr)},
         {"now", in_settings.is_null() ? Json(nullptr) : in_settings.at(number.key)}});
  }
  return out;
}

void BallLearning::accept(SettingsEditor& settings, const std::string& who) const {
  const auto before = settings.current();
  const Json now = before.settings.value("ball_models", Json());
  Json next = now.is_object() ? now : params_to_json(BallModels{});
  int count = 0;
  const Json learnt = to_json({});
  for (const Json& number : learnt.at("numbers")) {
    if (number.at("learnt").is_null()) continue;
    next[number.at("key").get<std::string>()] = number.at("learnt");
    ++count;
  }
  if (count == 0)
    throw HttpError(409, "nothing is known about the ball yet: learning needs a few undisturbed kicks");
  const Json patch{{{"op", "add"}, {"path", "/ball_models"}, {"value", std::move(next)}}};
  const auto version = settings.patch(patch, {who, before.revision, "ball model learnt"});
  log::info("settings revision {} saved: ball model learnt from {} kicks and {} chips, by {}",
            version.revision, learnt.at("kicks").get<int>(), learnt.at("chips").get<int>(), who);
}

}  // namespace sslv
