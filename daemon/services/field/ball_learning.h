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

/// The ball's model as play tells it, offered to the admin. The field's thread hands kicks over; all else is
/// for other threads.
class BallLearning {
 public:
  BallLearning();

  /// For the field's thread; never waits. One that finds no room is not learnt from.
  void hand_over(const WatchedKick& kick) noexcept;

  /// Learns from what was handed over. `model`: in effect.
  void learn(const BallModel& model);

  /// As docs/openapi.json's BallLearning; `now`: of the settings.
  Json to_json(const std::optional<BallModels>& now) const;

  /// Sets what is known in the settings. Throws HttpError 409 when nothing is, and as SettingsEditor::patch()
  /// does.
  void accept(SettingsEditor& settings, const std::string& who) const;

 private:
  static constexpr std::size_t kSlots = 8;
  SlotQueue<WatchedKick, kSlots> queue_;
  mutable std::mutex mutex_;
  BallModelLearner learner_;
};

}  // namespace sslv
