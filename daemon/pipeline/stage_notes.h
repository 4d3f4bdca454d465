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

/// What a stage has to tell the admin at the moment: a short text that Diagnostics shows beside its time. A
/// warning is an alert too. Written by the stage's thread without a lock, read by any.
class StageNotes {
 public:
  enum class Kind : std::uint8_t { kNone, kNote, kWarning };
  struct Note {
    Kind kind = Kind::kNone;
    std::string text;
  };
  /// In bytes; what is longer is cut off.
  static constexpr std::size_t kMaxText = 254;

  void say(std::string_view text) noexcept { store(Kind::kNote, text); }
  void warn(std::string_view text) noexcept { store(Kind::kWarning, text); }
  void clear() noexcept { note_.store({}); }

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
