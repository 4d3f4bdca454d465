// SPDX-License-Identifier: Apache-2.0
#pragma once

// The data exchanged with a stage's process for one frame, in the same order on both sides.

#include "kit/sandbox/validate_parts.h"
#include "pipeline/camera_stage.h"
#include "pipeline/field_stage.h"

#include <algorithm>
#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <vector>

namespace sslv::sandbox {

template <class Floor>
inline constexpr std::string_view kFloorName = std::is_same_v<Floor, CameraFloor> ? "camera" : "field";

/// The parts that a stage reads, writes and updates, and the arguments that it takes, as its row lists them.
struct StageNeeds {
  PartSet reads, writes, updates;
  GivenSet takes;

  PartSet sent() const { return reads | writes; }  // written parts, too: the stage may reuse their contents
  PartSet answered() const { return writes | updates; }
};

/// The needs of a stage, except the libraries' own parts.
template <class Floor>
StageNeeds needs_of(const BasicStageType<Floor>& type) {
  const PartSet of_frame((1ULL << kPartCount<Floor>)-1);
  return {type.reads & of_frame, type.writes & of_frame, type.updates & of_frame, type.takes};
}

/// A stage's reads, writes and arguments as a text. If the library yields another text for the same stage,
/// the library was replaced after it was described.
template <class Floor>
std::string contract_of(const BasicStageType<Floor>& type) {
  const StageNeeds needs = needs_of(type);
  std::string text = needs.reads.to_string() + needs.writes.to_string() + needs.updates.to_string() +
                     needs.takes.to_string();
  for (const OwnPartUse& use : type.own_parts) {
    text += ' ' + use.type.name + ':' + std::to_string(use.type.layout) + (use.is_written ? 'w' : 'r') +
            (use.is_updated ? 'u' : 'r');
  }
  return text;
}

template <class Floor, class Arg>
bool takes(const StageNeeds& needs) {
  return needs.takes[given_index<Floor, Arg>()];
}

/// Why a stage with these needs cannot run in its own process; empty if it can.
template <class Floor>
std::string why_not_apart(const StageNeeds& needs) {
  std::string why;
  std::size_t i = 0;
  const auto look = [&]<class T>(const Part<typename Floor::Frame, T>& part) {
    const std::size_t at = i++;
    if (kIsEncodable<T> || !(needs.sent()[at] || needs.answered()[at])) return;
    if (std::is_same_v<T, Image> && !needs.answered()[at]) return;  // the image is sent separately
    why = "it " + std::string(needs.answered()[at] ? "changes '" : "reads '") + std::string(part.name) +
          "', which cannot leave the service";
  };
  std::apply([&](const auto&... part) { (look(part), ...); }, Floor::kParts);
  const bool takes_sink = [&] {
    if constexpr (std::is_same_v<Floor, CameraFloor>)
      return takes<Floor, DetectionSink&>(needs);
    else
      return takes<Floor, FieldSink&>(needs);
  }();
  if (takes_sink) why = "it sends results itself, which only stages inside the service can do";
  return why;
}

/// If `is_limited`, returns false if a part takes more bytes than max_bytes() allows.
template <class Floor>
bool encode_parts(const typename Floor::Frame& frame, PartSet parts, ByteWriter& to,
                  bool is_limited = false) {
  std::size_t i = 0;
  bool is_within = true;
  const auto add = [&]<class T>(const Part<typename Floor::Frame, T>& part) {
    const bool is_sent = parts[i++];
    if constexpr (kIsEncodable<T>) {
      if (!is_sent) return;
      const std::size_t before = to.written();
      encode(frame.*part.member, to);
      is_within = is_within && (!is_limited || to.written() - before <= max_bytes(std::type_identity<T>{}));
    }
  };
  std::apply([&](const auto&... part) { (add(part), ...); }, Floor::kParts);
  return is_within;
}

/// False for invalid bytes; the parts are unspecified then.
template <class Floor>
[[nodiscard]] bool decode_parts(ByteReader& from, typename Floor::Frame& frame, PartSet parts) {
  std::size_t i = 0;
  const auto take = [&]<class T>(const Part<typename Floor::Frame, T>& part) {
    const bool is_sent = parts[i++];
    if constexpr (kIsEncodable<T>) {
      if (is_sent) return decode(from, frame.*part.member);
    }
    return true;
  };
  return std::apply([&](const auto&... part) { return (take(part) && ...); }, Floor::kParts);
}

/// Like decode_parts(), for bytes from an untrusted process: refuses parts longer than max_bytes() allows.
/// Removes the decoded bytes from `from`.
template <class Floor>
[[nodiscard]] bool decode_limited_parts(std::span<const std::byte>& from, typename Floor::Frame& frame,
                                        PartSet parts) {
  std::size_t i = 0;
  const auto take = [&]<class T>(const Part<typename Floor::Frame, T>& part) {
    const bool is_sent = parts[i++];
    if constexpr (kIsEncodable<T>) {
      if (!is_sent) return true;
      const auto room = from.first(std::min(from.size(), max_bytes(std::type_identity<T>{})));
      ByteReader reader(room, true);
      if (!decode(reader, frame.*part.member)) return false;
      from = from.subspan(room.size() - reader.left());
    }
    return true;
  };
  return std::apply([&](const auto&... part) { return (take(part) && ...); }, Floor::kParts);
}

}  // namespace sslv::sandbox
