// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/seqlock.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>

namespace sslv {

/// Current message of a stage to the admin: a short text that Diagnostics shows beside the stage's time. A
/// warning also raises an alert. Written by the stage's thread without a lock, read by any thread.
class StageNotes {
 public:
  /// A warning raises an alert; a note is only shown.
  enum class Kind : std::uint8_t { kNone, kNote, kWarning };
  /// The current message; empty after clear().
  struct Note {
    Kind kind = Kind::kNone;
    std::string text;
  };
  /// Maximum length of a text in bytes; longer texts are truncated.
  static constexpr std::size_t kMaxText = 254;

  /// Replaces the message by a note.
  void say(std::string_view text) noexcept { store(Kind::kNote, text); }
  /// Replaces the message by a warning.
  void warn(std::string_view text) noexcept { store(Kind::kWarning, text); }
  /// Removes the message.
  void clear() noexcept { note_.store({}); }

  /// A copy, for any thread.
  Note read() const {
    const Stored stored = note_.load();
    return {stored.kind, std::string(stored.text.data(), stored.length)};
  }

 private:
  struct Stored {
    Kind kind = Kind::kNone;
    std::uint8_t length = 0;
    std::array<char, kMaxText> text{};
  };
  void store(Kind kind, std::string_view text) noexcept {
    Stored stored{kind, static_cast<std::uint8_t>(std::min(text.size(), kMaxText)), {}};
    std::memcpy(stored.text.data(), text.data(), stored.length);
    note_.store(stored);
  }

  Seqlock<Stored> note_;
};

}  // namespace sslv
