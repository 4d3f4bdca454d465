// SPDX-License-Identifier: Apache-2.0
//
// Prints the vision's packets, or with --tracks the tracks of robots and balls. Copy it into your team's
// software; README.md describes how to build it separately.
#include "ssl_vision_wrapper.pb.h"
#include "ssl_vision_wrapper_tracked.pb.h"

#include <array>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <map>
#include <string>

#include <arpa/inet.h>
#include <sys/socket.h>

[[noreturn]] static void fail(const std::string& why) {
  std::fprintf(stderr, "sample_client: %s\n", why.c_str());
  std::exit(1);
}

static in_addr parse_address(const std::string& text) {
  in_addr address{};
  if (inet_pton(AF_INET, text.c_str(), &address) != 1) fail("'" + text + "' is not an IPv4 address");
  return address;
}

static unsigned parse_number(const std::string& text, unsigned long max) {
  char* end = nullptr;
  const unsigned long value = std::strtoul(text.c_str(), &end, 10);
  if (end == text.c_str() || *end != '\0' || value > max)
    fail("'" + text + "' is not 0 .. " + std::to_string(max));
  return static_cast<unsigned>(value);
}

/// Opens a socket that receives packets to the group on the network card with the address `interface`. If
/// `group` is a broadcast address, receives on all cards.
static int join(in_addr group, unsigned port, in_addr interface) {
  const int fd = socket(AF_INET, SOCK_DGRAM, 0);
  const int yes = 1;  // so that several programs on one computer can listen
  const timeval patience{5, 0};
  setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
  sockaddr_in local{};
  local.sin_family = AF_INET;
  local.sin_port = htons(static_cast<in_port_t>(port));
  local.sin_addr = group;  // not INADDR_ANY, which would also receive other groups on this port
  if (bind(fd, reinterpret_cast<const sockaddr*>(&local), sizeof local) != 0) {
    fail(std::string("cannot listen to the group: ") + std::strerror(errno));
  }
  const ip_mreq membership{group, interface};
  if (IN_MULTICAST(ntohl(group.s_addr)) &&
      setsockopt(fd, IPPROTO_IP, IP_ADD_MEMBERSHIP, &membership, sizeof membership) != 0) {
    fail(std::string("cannot join the group: ") + std::strerror(errno) +
         "; give --interface the address of this computer's network card on the field's network");
  }
  return fd;
}

static void print_robots(const char* team,
                         const google::protobuf::RepeatedPtrField<SSL_DetectionRobot>& robots) {
  for (const SSL_DetectionRobot& robot : robots) {
    std::printf("  %s %u  x %.1f  y %.1f mm  orientation %.4f rad  height %.0f mm  confidence %.2f\n", team,
                robot.robot_id(), robot.x(), robot.y(), robot.orientation(), robot.height(),
                robot.confidence());
  }
}

static void print_detection(const SSL_DetectionFrame& frame) {
  struct Camera {
    unsigned last_frame, lost;
  };
  static std::map<unsigned, Camera> cameras;
  Camera& camera = cameras.try_emplace(frame.camera_id(), Camera{frame.frame_number(), 0}).first->second;
  if (frame.frame_number() > camera.last_frame) camera.lost += frame.frame_number() - camera.last_frame - 1;
  camera.last_frame = frame.frame_number();

  // Correct only if the clocks of both computers agree.
  const double now =
      std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
  std::printf("camera %u  frame %u  age %.2f ms  since sent %.2f ms  lost %u\n", frame.camera_id(),
              frame.frame_number(), (now - frame.t_capture()) * 1e3, (now - frame.t_sent()) * 1e3,
              camera.lost);
  print_robots("yellow", frame.robots_yellow());
  print_robots("blue", frame.robots_blue());
  for (const SSL_DetectionBall& ball : frame.balls()) {
    std::printf("  ball  x %.1f  y %.1f mm  area %u px  confidence %.2f\n", ball.x(), ball.y(), ball.area(),
                ball.confidence());
  }
}

static void print_geometry(const SSL_GeometryData& geometry) {
  const SSL_GeometryFieldSize& field = geometry.field();
  std::printf("geometry  field %d x %d mm  lines %d  arcs %d\n", field.field_length(), field.field_width(),
              field.field_lines_size(), field.field_arcs_size());
  for (const SSL_GeometryCameraCalibration& camera : geometry.calib()) {
    std::printf("  camera %u  at %.0f %.0f %.0f mm  focal length %.1f px\n", camera.camera_id(),
                camera.derived_camera_world_tx(), camera.derived_camera_world_ty(),
                camera.derived_camera_world_tz(), camera.focal_length());
  }
}

/// Metres, m/s. All values are valid at the time `timestamp`. A team uses the velocities to predict them to
/// the time at which its own commands arrive.
static void print_tracks(const TrackerWrapperPacket& packet) {
  const TrackedFrame& frame = packet.tracked_frame();
  const double now =
      std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
  std::printf("tracks of %s  frame %u  age %.2f ms\n", packet.source_name().c_str(), frame.frame_number(),
              (now - frame.timestamp()) * 1e3);
  for (const TrackedRobot& robot : frame.robots()) {
    std::printf(
        "  %s %u  x %.3f  y %.3f m  orientation %.4f rad  speed %.2f %.2f m/s  turns %.2f rad/s  %s\n",
        robot.robot_id().team() == BLUE ? "blue" : "yellow", robot.robot_id().id(), robot.pos().x(),
        robot.pos().y(), robot.orientation(), robot.vel().x(), robot.vel().y(), robot.vel_angular(),
        robot.visibility() < 1 ? "hidden" : "seen");
  }
  for (const TrackedBall& ball : frame.balls()) {
    std::printf("  ball  x %.3f  y %.3f  z %.3f m  speed %.2f %.2f %.2f m/s  %s\n", ball.pos().x(),
                ball.pos().y(), ball.pos().z(), ball.vel().x(), ball.vel().y(), ball.vel().z(),
                ball.visibility() < 1 ? "hidden" : "seen");
  }
  if (frame.has_kicked_ball()) {
    const KickedBall& kick = frame.kicked_ball();
    std::printf("  kicked %.3f s ago at x %.3f  y %.3f m  speed %.2f %.2f %.2f m/s\n",
                frame.timestamp() - kick.start_timestamp(), kick.pos().x(), kick.pos().y(), kick.vel().x(),
                kick.vel().y(), kick.vel().z());
  }
}

int main(int argc, char** argv) {
  std::map<std::string, std::string> options{
      {"--group", "224.5.23.2"}, {"--port", ""}, {"--interface", "0.0.0.0"}, {"--count", "0"}};
  bool tracks = false;
  for (int i = 1; i < argc; ++i) {
    const std::string name = argv[i];
    if (name == "--once") {
      options["--count"] = "1";
    } else if (name == "--tracks") {
      tracks = true;
    } else if (options.count(name) != 0 && i + 1 < argc) {
      options[name] = argv[++i];
    } else {
      fail("'" + name +
           "'? Options: --group ADDRESS --port N --interface ADDRESS --count PACKETS (0: for ever) --once "
           "--tracks");
    }
  }
  if (options["--port"].empty()) options["--port"] = tracks ? "10010" : "10006";
  const int fd = join(parse_address(options["--group"]), parse_number(options["--port"], 65535),
                      parse_address(options["--interface"]));
  const unsigned count = parse_number(options["--count"], 1'000'000'000);

  SSL_WrapperPacket packet;
  TrackerWrapperPacket track_packet;
  google::protobuf::MessageLite& expected =
      tracks ? static_cast<google::protobuf::MessageLite&>(track_packet) : packet;
  std::array<char, 65536> datagram;
  for (unsigned received = 0; count == 0 || received < count;) {
    const ssize_t size = recv(fd, datagram.data(), datagram.size(), 0);
    if (size < 0) {
      std::fprintf(stderr,
                   "sample_client: nothing for 5 s; does a vision send there, and is --interface right?\n");
    } else if (!expected.ParseFromArray(datagram.data(), static_cast<int>(size))) {
      std::fprintf(stderr, "sample_client: %zd bytes that are no %s packet\n", size,
                   tracks ? "tracker" : "vision");
    } else {
      if (tracks) print_tracks(track_packet);
      if (!tracks && packet.has_detection()) print_detection(packet.detection());
      if (!tracks && packet.has_geometry()) print_geometry(packet.geometry());
      std::fflush(stdout);
      ++received;
    }
  }
}
