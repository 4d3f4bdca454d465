// SPDX-License-Identifier: Apache-2.0
#include "net/other_visions.h"

#include "base/clock.h"
#include "net/parse.h"
#include "ssl_vision_wrapper.pb.h"

#include <algorithm>
#include <cmath>

namespace sslv {
namespace {

using boost::asio::ip::udp;
using google::protobuf::FieldDescriptor;
using google::protobuf::Message;

// More can only be an attack; these are enough to say that something is wrong.
constexpr std::size_t kMaxSenders = 16, kMaxCameras = 64;

/// A number that is set; nothing for an absent field or one of another kind.
std::optional<double> number(const Message& message, const FieldDescriptor& field) {
  const auto* reflection = message.GetReflection();
  if (field.is_repeated() || !reflection->HasField(message, &field)) return std::nullopt;
  switch (field.cpp_type()) {
    case FieldDescriptor::CPPTYPE_INT32: return reflection->GetInt32(message, &field);
    case FieldDescriptor::CPPTYPE_FLOAT: return reflection->GetFloat(message, &field);
    case FieldDescriptor::CPPTYPE_DOUBLE: return reflection->GetDouble(message, &field);
    default: return std::nullopt;
  }
}

template <class Things>
bool are_somewhere(const Things& things) {
  return std::all_of(things.begin(), things.end(),
                     [](const auto& one) { return std::isfinite(one.x()) && std::isfinite(one.y()); });
}

bool makes_sense(const SSL_DetectionFrame& frame) {
  return std::isfinite(frame.t_capture()) && std::isfinite(frame.t_sent()) && are_somewhere(frame.balls()) &&
         are_somewhere(frame.robots_yellow()) && are_somewhere(frame.robots_blue());
}

bool makes_sense(const SSL_GeometryFieldSize& field) {
  constexpr double kLargest = 1e6;
  for (int i = 0; i < field.GetDescriptor()->field_count(); ++i) {
    const auto size = number(field, *field.GetDescriptor()->field(i));
    if (size && !(*size >= 0 && *size <= kLargest)) return false;  // NaN neither
  }
  return field.field_length() > 0 && field.field_width() > 0;
}

/// It says something, and nothing absurd.
bool makes_sense(const SSL_WrapperPacket& packet) {
  return (packet.has_detection() || packet.has_geometry()) &&
         (!packet.has_detection() || makes_sense(packet.detection())) &&
         (!packet.has_geometry() || makes_sense(packet.geometry().field()));
}

SSL_GeometryFieldSize sizes_of(const SSL_GeometryFieldSize& field) {
  SSL_GeometryFieldSize sizes = field;
  sizes.clear_field_lines();
  sizes.clear_field_arcs();
  sizes.DiscardUnknownFields();
  return sizes;
}

}  // namespace

std::vector<SizeConflict> size_conflicts(const SSL_GeometryFieldSize& ours,
                                         const SSL_GeometryFieldSize& theirs) {
  constexpr double kSame_mm = 0.01;  // the wire has floats
  std::vector<SizeConflict> conflicts;
  for (int i = 0; i < ours.GetDescriptor()->field_count(); ++i) {
    const FieldDescriptor& field = *ours.GetDescriptor()->field(i);
    const auto our_size = number(ours, field), their_size = number(theirs, field);
    if (our_size && their_size && std::abs(*our_size - *their_size) > kSame_mm) {
      conflicts.push_back({field.name(), *our_size, *their_size});
    }
  }
  return conflicts;
}

OtherVisions::OtherVisions(IsOwn is_own, OnOwn on_own, OnOther on_other)
    : is_own_(std::move(is_own)),
      on_own_(std::move(on_own)),
      on_other_(std::move(on_other)),
      receiver_("other visions", [this](std::span<const std::byte> datagram, const udp::endpoint& sender) {
        receive(datagram, sender, static_cast<double>(steady_ns()) * 1e-9);
      }) {}

void OtherVisions::listen(const GroupAddress& where) {
  if (where_ == where) return;
  receiver_.listen(std::nullopt);
  where_ = where;
  {
    const std::lock_guard lock(mutex_);
    senders_.clear();
  }
  receiver_.listen(where);
}

void OtherVisions::receive(std::span<const std::byte> datagram, const udp::endpoint& sender, double now_s) {
  if (sender == own_ || is_own_(sender)) {
    own_ = sender;
    on_own_(datagram, now_s);
    return;
  }
  SSL_WrapperPacket packet;
  const bool good = parse(packet, datagram) && makes_sense(packet);
  std::optional<SSL_GeometryFieldSize> field;
  if (good && packet.has_geometry()) field = sizes_of(packet.geometry().field());
  const std::string address = sender.address().to_string();
  if (good) on_other_(packet, address, now_s);

  const std::lock_guard lock(mutex_);
  if (!good) {
    ++refused_;
    return;
  }
  std::erase_if(senders_, [&](const auto& one) { return now_s - one.second.heard_s > kForgottenAfter_s; });
  if (senders_.size() >= kMaxSenders && !senders_.contains(address)) return;
  Sender& from = senders_[address];
  from.heard_s = now_s;
  if (field) from.field = std::move(field);
  if (packet.has_detection()) {
    auto& heard_s = from.camera_heard_s;
    std::erase_if(heard_s, [&](const auto& one) { return now_s - one.second > kForgottenAfter_s; });
    const std::uint32_t id = packet.detection().camera_id();
    if (heard_s.size() < kMaxCameras || heard_s.contains(id)) heard_s[id] = now_s;
  }
}

std::vector<OtherVision> OtherVisions::seen(double now_s) const {
  std::vector<OtherVision> seen;
  const std::lock_guard lock(mutex_);
  for (const auto& [address, sender] : senders_) {
    if (now_s - sender.heard_s > kForgottenAfter_s) continue;
    OtherVision& other = seen.emplace_back();
    other.address = address;
    other.silent_s = std::max(0.0, now_s - sender.heard_s);
    other.field = sender.field;
    for (const auto& [id, heard_s] : sender.camera_heard_s) {
      if (now_s - heard_s <= kForgottenAfter_s) other.cameras.push_back(id);
    }
  }
  return seen;
}

std::uint64_t OtherVisions::refused() const {
  const std::lock_guard lock(mutex_);
  return refused_;
}

}  // namespace sslv
