// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"
#include "base/slot_queue.h"
#include "config/config.h"
#include "services/settings/settings_editor.h"
#include "tracking/ball_model_learner.h"

#include <cstddef>
#include <mutex>
#include <optional>
#include <string>

namespace sslv {

/// Learns the ball's model from play and offers it to the admin. The field's thread calls hand_over() only;
/// other threads call the rest.
class BallLearning {
 public:
  BallLearning();

  /// For the field's thread; never waits. Drops the kick if the queue is full.
  void hand_over(const WatchedKick& kick) noexcept;

  /// Learns from the kicks handed over. `model`: the current ball model.
  void learn(const BallModel& model);

  /// BallLearning in docs/openapi.json. `now`: models in the settings.
  Json to_json(const std::optional<BallModels>& now) const;

  /// Writes the known values to the settings. Throws HttpError 409 if nothing is known, and the exceptions of
  /// SettingsEditor::patch().
  void accept(SettingsEditor& settings, const std::string& who) const;

 private:
  static constexpr std::size_t kSlots = 8;
  SlotQueue<WatchedKick, kSlots> queue_;
  mutable std::mutex mutex_;
  BallModelLearner learner_;
};

}  // namespace sslv
