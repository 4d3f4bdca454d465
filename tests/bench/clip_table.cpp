// SPDX-License-Identifier: Apache-2.0
// The cost of the image ring and of writing clips, as a table in Markdown: clip_table [FOLDER]. Threads
// simulate cameras: each gets noise images at a fixed rate, reads each once like segmentation, and stores it
// in the ring, while a low-priority thread writes the clip to FOLDER (default: the temporary folder).
#include "base/background.h"
#include "base/clock.h"
#include "clips/clip_writer.h"
#include "clips/image_ring.h"
#include "support/temporary_folder.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include <fmt/format.h>

namespace sslv {
namespace {

struct Camera {
  int width = 0, height = 0;
  double rate_hz = 0;
  std::size_t bytes() const { return static_cast<std::size_t>(width) * static_cast<std::size_t>(height); }
};

double thread_cpu_us() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) * 1e6 + static_cast<double>(now.tv_nsec) * 1e-3;
}

/// A camera's thread; measures the cost of storing each image.
class PlayedCamera {
 public:
  PlayedCamera(const Camera& camera, std::uint32_t id, std::size_t ring_bytes)
      : camera_(camera),
        id_(id),
        ring_(ring_bytes),
        thread_([this](const std::stop_token& stop) { play(stop); }) {}
  ~PlayedCamera() {
    thread_.request_stop();
    thread_.join();
  }
  PlayedCamera(const PlayedCamera&) = delete;
  PlayedCamera& operator=(const PlayedCamera&) = delete;

  ImageRing& ring() { return ring_; }
  double seconds() const {
    const ImageRing::Extent extent = ring_.extent();
    return static_cast<double>(extent.newest_ns - extent.oldest_ns) * 1e-9;
  }
  void stop() {
    thread_.request_stop();
    thread_.join();
    thread_ = std::jthread([] {});
  }
  /// CPU time to store each frame, in us; valid after stop().
  std::vector<double> put_us;
  std::uint64_t late = 0;  // frames due before the previous one was done

 private:
  void play(const std::stop_token& stop) {
    // As many buffers as a driver has, so that an image is not in the cache yet when it is read.
    std::vector<std::vector<std::uint8_t>> buffers(16);
    std::uint32_t chance = id_ + 1;
    for (auto& buffer : buffers) {
      buffer.resize(camera_.bytes());
      for (std::uint8_t& byte : buffer)
        byte = static_cast<std::uint8_t>((chance = chance * 1664525U + 1013904223U) >> 24U);
    }
    put_us.reserve(1 << 16);
    const std::vector<std::byte> packet(1500), memory(6000);
    const auto interval = std::chrono::nanoseconds(static_cast<std::int64_t>(1e9 / camera_.rate_hz));
    auto next = std::chrono::steady_clock::now();
    for (std::uint32_t number = 0; !stop.stop_requested(); ++number) {
      next += interval;
      if (next < std::chrono::steady_clock::now()) {
        ++late;
        next = std::chrono::steady_clock::now();
      }
      std::this_thread::sleep_until(next);
      const auto& pixels = buffers[number % buffers.size()];
      ClipFrame frame;
      frame.info.camera_id = id_;
      frame.info.number = number;
      frame.info.times.t_capture_s = unix_time_s();
      frame.info.times.arrived_ns = steady_ns();
      frame.image = {pixels.data(), camera_.width, camera_.height, camera_.width, PixelFormat::kBayerRg8};
      frame.packet = packet;
      if (number % 19 == 0) frame.memory = memory;
      std::uint64_t sum = 0;
      for (const std::uint8_t pixel : pixels) sum += pixel;
      seen_.fetch_add(sum, std::memory_order_relaxed);
      const double begin_us = thread_cpu_us();
      ring_.put(frame);
      put_us.push_back(thread_cpu_us() - begin_us);
    }
  }

  const Camera camera_;
  const std::uint32_t id_;
  ImageRing ring_;
  std::atomic<std::uint64_t> seen_{0};
  std::jthread thread_;
};

struct Measured {
  double put_us = 0, put_p99_us = 0, core_percent = 0;
  double clip_s = 0, written_s = 0, megabytes = 0;
  std::uint64_t frames = 0, gaps = 0, dropped = 0, late = 0;
};

void write_clip(const std::filesystem::path& file, std::vector<std::unique_ptr<PlayedCamera>>& cameras,
                std::int64_t from_ns, std::int64_t to_ns, Measured& out) {
  become_background_thread("clips", 15);
  ClipWriter writer(file, {.site = "bench"});
  std::vector<std::int64_t> last(cameras.size(), -1);
  for (std::uint32_t id = 0; id < cameras.size(); ++id)
    writer.add(ClipSetup{.camera_id = static_cast<int>(id)});
  for (bool is_last = false;;) {
    bool any = false;
    for (std::size_t i = 0; i < cameras.size(); ++i) {
      ImageRing& ring = cameras[i]->ring();
      ring.hold(from_ns, to_ns);
      const ClipFrame* const held = ring.oldest_held();
      if (held == nullptr) continue;
      any = true;
      ClipFrame frame = *held;
      frame.setup = static_cast<std::uint32_t>(i);
      writer.add(frame);
      if (last[i] >= 0) out.gaps += static_cast<std::uint64_t>(frame.info.number - last[i] - 1);
      last[i] = frame.info.number;
      ++out.frames;
      ring.let_go();
    }
    if (any) continue;
    if (is_last) break;
    is_last = steady_ns() > to_ns + 300'000'000;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  writer.finish();
  out.megabytes = static_cast<double>(writer.bytes()) * 1e-6;
}

Measured measure(const std::vector<Camera>& wanted, double memory_mb, double before_s, double after_s,
                 const std::filesystem::path& folder) {
  double all = 0;
  for (const Camera& camera : wanted) all += static_cast<double>(camera.bytes()) * camera.rate_hz;
  std::vector<std::unique_ptr<PlayedCamera>> cameras;
  for (std::uint32_t id = 0; id < wanted.size(); ++id) {
    const double share = static_cast<double>(wanted[id].bytes()) * wanted[id].rate_hz / all;
    cameras.push_back(
        std::make_unique<PlayedCamera>(wanted[id], id, static_cast<std::size_t>(memory_mb * 1e6 * share)));
  }
  while (std::ranges::any_of(cameras, [&](const auto& camera) { return camera->seconds() < before_s; }))
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  Measured out;
  out.clip_s = before_s + after_s;
  const std::int64_t now_ns = steady_ns();
  const auto to_ns = now_ns + static_cast<std::int64_t>(after_s * 1e9);
  const auto from_ns = now_ns - static_cast<std::int64_t>(before_s * 1e9);
  for (const auto& camera : cameras) camera->ring().hold(from_ns, to_ns);
  std::jthread([&] { write_clip(folder / "bench.clip", cameras, from_ns, to_ns, out); }).join();
  out.written_s = static_cast<double>(steady_ns() - now_ns) * 1e-9;
  std::filesystem::remove(folder / "bench.clip");
  std::vector<double> put_us;
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    cameras[i]->stop();
    out.dropped += cameras[i]->ring().extent().dropped;
    out.late += cameras[i]->late;
    double sum = 0;
    for (const double us : cameras[i]->put_us) sum += us;
    out.core_percent += sum / static_cast<double>(cameras[i]->put_us.size()) * wanted[i].rate_hz * 1e-4;
    put_us.insert(put_us.end(), cameras[i]->put_us.begin(), cameras[i]->put_us.end());
  }
  std::ranges::sort(put_us);
  out.put_us = put_us[put_us.size() / 2];
  out.put_p99_us = put_us[put_us.size() * 99 / 100];
  return out;
}

void print(const std::string& name, const Measured& m) {
  fmt::print(
      "| {} | {:.0f} ({:.0f}) | {:.2f} % | {:.1f} s: {} frames, {:.0f} MB, in {:.1f} s | {} | {} | {} |\n",
      name, m.put_us, m.put_p99_us, m.core_percent, m.clip_s, m.frames, m.megabytes, m.written_s, m.gaps,
      m.dropped, m.late);
  std::fflush(stdout);
}

}  // namespace
}  // namespace sslv

int main(int argc, char** argv) {
  using namespace sslv;
  const test::TemporaryFolder temporary;
  const std::filesystem::path folder = argc > 1 ? argv[1] : temporary.path();
  fmt::print(
      "| cameras (8-bit Bayer), memory | keeping an image, us of a core: median (p99) | of one core | clip | "
      "frames "
      "missing | dropped | late |\n|---|---|---|---|---|---|---|\n");
  const std::vector<Camera> two(2, Camera{1280, 1024, 75});
  print("2 of 1280x1024 at 75 Hz, 2400 MB", measure(two, 2400, 10, 0, folder));
  print("2 of 1280x1024 at 75 Hz, 512 MB", measure(two, 512, 2, 8, folder));
  print("1 of 2448x2048 at 72 Hz, 1000 MB", measure({{2448, 2048, 72}}, 1000, 2, 3, folder));
}
