// SPDX-License-Identifier: Apache-2.0
#include "net/heard_packets.h"

#include "net/parse.h"
#include "ssl_vision_wrapper.pb.h"

#include <utility>

#include <google/protobuf/util/json_util.h>

namespace sslv {

void HeardPackets::Kind::take(std::span<const std::byte> datagram, double now_s) {
  newest.bytes.assign(datagram.begin(), datagram.end());
  newest.heard_s = now_s;
  ++newest.count;
  const double passed_s = now_s - second_began_s;
  if (passed_s >= 1) {
    // After a gap, the rate is unknown until the first second is complete.
    newest.per_s = passed_s < 2 ? static_cast<double>(in_second) / passed_s : 0;
    second_began_s = now_s;
    in_second = 0;
  }
  ++in_second;
}

HeardPacket HeardPackets::Kind::at(double now_s) const {
  HeardPacket packet = newest;
  if (now_s - newest.heard_s > 2) packet.per_s = 0;
  return packet;
}

void HeardPackets::receive(std::span<const std::byte> datagram, double now_s) {
  SSL_WrapperPacket packet;
  if (!parse(packet, datagram)) return;
  const std::lock_guard lock(mutex_);
  if (packet.has_detection()) {
    std::erase_if(cameras_,
                  [&](const auto& one) { return now_s - one.second.newest.heard_s > kForgottenAfter_s; });
    cameras_[packet.detection().camera_id()].take(datagram, now_s);
  }
  if (packet.has_geometry()) geometry_.take(datagram, now_s);
}

void HeardPackets::clear() {
  const std::lock_guard lock(mutex_);
  cameras_.clear();
  geometry_ = {};
}

std::map<std::uint32_t, HeardPacket> HeardPackets::detections(double now_s) const {
  std::map<std::uint32_t, HeardPacket> out;
  const std::lock_guard lock(mutex_);
  for (const auto& [id, camera] : cameras_) {
    if (now_s - camera.newest.heard_s <= kForgottenAfter_s) out.emplace(id, camera.at(now_s));
  }
  return out;
}

std::optional<HeardPacket> HeardPackets::geometry(double now_s) const {
  const std::lock_guard lock(mutex_);
  if (geometry_.newest.count == 0 || now_s - geometry_.newest.heard_s > kForgottenAfter_s) {
    return std::nullopt;
  }
  return geometry_.at(now_s);
}

std::string packet_json(std::span<const std::byte> datagram) {
  SSL_WrapperPacket packet;
  std::string text;
  if (!parse(packet, datagram)) return text;
  google::protobuf::util::JsonPrintOptions options;
  options.preserve_proto_field_names = true;
  const auto status = google::protobuf::util::MessageToJsonString(packet, &text, options);
  return status.ok() ? text : std::string();
}

}  // namespace sslv
