// SPDX-License-Identifier: Apache-2.0
#include "web/picture_stream.h"

#include "web/route.h"
#include "web/socket.h"

#include <array>
#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include <boost/asio/buffer.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/socket_base.hpp>
#include <boost/beast/core/buffers_suffix.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <fmt/format.h>

namespace sslv {

namespace asio = boost::asio;
namespace beast = boost::beast;

namespace {

constexpr std::chrono::seconds kStallTimeout{30};
constexpr int kSendBufferBytes = 64 * 1024;
constexpr std::string_view kPartEnd = "\r\n";

/// Kept alive by its pending read.
class PictureStream : public std::enable_shared_from_this<PictureStream> {
 public:
  PictureStream(asio::ip::tcp::socket socket, ScopedCount connection, Connections::Seat& seat,
                CameraFeeds& feeds, CameraFeed& feed, MayLook may_look)
      : may_look_(std::move(may_look)),
        feeds_(feeds),
        feed_(feed),
        id_(feeds.new_viewer()),
        connection_(std::move(connection)),
        seat_(seat),
        stream_(std::move(socket)) {
    beast::error_code ignored;
    stream_.socket().set_option(asio::socket_base::send_buffer_size(kSendBufferBytes), ignored);
    limit_unsent_bytes(stream_.socket());
  }

  void start(const PreviewWish& wish) {
    seat_.closes_by([weak = weak_from_this()] {
      if (const auto self = weak.lock()) self->leave();
    });
    read();
    feed_.start_preview(
        id_, wish,
        [weak = weak_from_this(), executor = stream_.get_executor()](const CameraFeed::Message& message) {
          asio::post(executor, [weak, message] {
            if (const auto self = weak.lock()) self->send(message);
          });
        });
  }

 private:
  using Buffers = std::array<asio::const_buffer, 3>;

  /// Reads only to detect that the client disconnects; discards what it sends.
  void read() {
    stream_.expires_never();
    stream_.async_read_some(asio::buffer(ignored_),
                            [self = shared_from_this()](beast::error_code error, std::size_t) {
                              error ? self->leave() : self->read();
                            });
  }

  void send(const CameraFeed::Message& message) {
    if (left_) return;
    if (!may_look_()) return leave();
    std::string ignored;
    if (!seat_.holds(message->size(), ignored)) return feed_.acknowledge(id_);  // skip this image
    message_ = message;
    const std::span<const char> jpeg = jpeg_in(*message_);
    part_head_ = fmt::format(
        "--ssl-visiond-picture\r\nContent-Type: image/jpeg\r\nContent-Length: {}\r\n\r\n", jpeg.size());
    unsent_.emplace(Buffers{asio::buffer(part_head_), asio::buffer(jpeg.data(), jpeg.size()),
                            asio::buffer(kPartEnd.data(), kPartEnd.size())});
    write();
  }

  void write() {
    stream_.expires_after(kStallTimeout);  // applies to each write: a slow client does not count as gone
    stream_.async_write_some(*unsent_,
                             [self = shared_from_this()](beast::error_code error, std::size_t size) {
                               if (error) return self->leave();
                               self->seat_.makes_progress();
                               self->unsent_->consume(size);
                               if (beast::buffer_bytes(*self->unsent_) > 0) return self->write();
                               self->message_.reset();
                               std::string ignored;
                               self->seat_.holds(0, ignored);
                               self->feed_.acknowledge(self->id_);
                             });
  }

  void leave() {
    if (left_) return;
    left_ = true;
    feeds_.stop_previews(id_);
    stream_.close();
  }

  const MayLook may_look_;
  CameraFeeds& feeds_;
  CameraFeed& feed_;
  const CameraFeed::ViewerId id_;
  const ScopedCount connection_;  // holds the seat
  Connections::Seat& seat_;
  beast::tcp_stream stream_;
  std::array<char, 1024> ignored_;
  CameraFeed::Message message_;  // being sent, or null
  std::string part_head_;
  std::optional<beast::buffers_suffix<Buffers>> unsent_;
  bool left_ = false;
};

}  // namespace

void stream_pictures(asio::ip::tcp::socket socket, ScopedCount connection, Connections::Seat& seat,
                     CameraFeeds& feeds, const StreamWish& wish, MayLook may_look) try {
  std::make_shared<PictureStream>(std::move(socket), std::move(connection), seat, feeds,
                                  feeds.of(wish.camera_id), std::move(may_look))
      ->start(wish.preview);
} catch (const HttpError&) {  // the camera was just removed: the stream ends before its first image
}

}  // namespace sslv
