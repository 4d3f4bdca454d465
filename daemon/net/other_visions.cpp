// SPDX-License-Identifier: Apache-2.0
#include "net/other_visions.h"

#include "base/clock.h"
#include "geometry/limits.h"

#include <algorithm>
#include <cmath>

namespace sslv {

using boost::asio::ip::udp;
using google::protobuf::FieldDescriptor;

std::vector<SizeConflict> size_conflicts(const SSL_GeometryFieldSize& ours,
                                         const SSL_GeometryFieldSize& theirs) {
  constexpr double kSame_mm = 0.01;  // the wire format has floats
  std::vector<SizeConflict> conflicts;
  for (int i = 0; i < ours.GetDescriptor()->field_count(); ++i) {
    const FieldDescriptor& field = *ours.GetDescriptor()->field(i);
    const auto our_size = number_of(ours, field), their_size = number_of(theirs, field);
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
  if (is_own_(sender)) {
    on_own_(datagram, now_s);
    return;
  }
  const auto message = VisionMessage::read(datagram);
  const std::string address = sender.address().to_string();
  bool is_named = false;
  {
    const std::lock_guard lock(mutex_);
    if (!message) {
      ++refused_;
      return;
    }
    is_named = named_.contains(address);
    note(*message, address, is_named, now_s);
  }
  on_other_(*message, address, is_named, now_s);
}

void OtherVisions::note(const VisionMessage& message, const std::string& address, bool is_named,
                        double now_s) {
  std::erase_if(senders_, [&](const auto& one) { return now_s - one.second.heard_s > kForgottenAfter_s; });
  const auto unnamed =
      std::ranges::count_if(senders_, [&](const auto& one) { return !named_.contains(one.first); });
  if (!is_named && !senders_.contains(address) && static_cast<std::size_t>(unnamed) >= limits::kMaxComputers)
    return;
  Sender& from = senders_[address];
  from.heard_s = now_s;
  if (message.field) from.field = message.field;
  if (!message.detection) return;
  auto& heard_s = from.camera_heard_s;
  std::erase_if(heard_s, [&](const auto& one) { return now_s - one.second > kForgottenAfter_s; });
  const int id = message.detection->arrived.image.camera;
  if (heard_s.size() < limits::kMaxCameras || heard_s.contains(id)) heard_s[id] = now_s;
}

void OtherVisions::set_named(std::set<std::string> addresses) {
  receiver_.set_named(addresses);
  const std::lock_guard lock(mutex_);
  named_ = std::move(addresses);
}

std::vector<OtherVision> OtherVisions::seen(double now_s) const {
  std::vector<OtherVision> seen;
  const std::lock_guard lock(mutex_);
  for (const auto& [address, sender] : senders_) {
    if (now_s - sender.heard_s > kForgottenAfter_s) continue;
    OtherVision& other = seen.emplace_back();
    other.address = address;
    other.is_named = named_.contains(address);
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
