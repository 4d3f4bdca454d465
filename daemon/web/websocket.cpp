// SPDX-License-Identifier: Apache-2.0
#include "web/websocket.h"

#include "base/log.h"
#include "base/params_json.h"
#include "web/http.h"
#include "web/socket.h"

#include <algorithm>
#include <chrono>
#include <deque>
#include <limits>
#include <string>
#include <tuple>
#include <vector>

#include <boost/asio/buffer.hpp>
#include <boost/asio/post.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/websocket/stream.hpp>
#include <fmt/format.h>

namespace sslv {

namespace asio = boost::asio;
namespace beast = boost::beast;

namespace {

constexpr std::chrono::milliseconds kStatusPeriod{500};
constexpr std::chrono::seconds kHandshakeTimeout{10};
constexpr std::chrono::seconds kSilenceTimeout{20};  // a viewer that answers no ping is gone
constexpr std::size_t kMaxMessageBytes = 16 * 1024;
constexpr int kMaxCameraId = std::numeric_limits<int>::max();

struct PreviewParams {
  int camera = 0;
  int width = PreviewWish{}.width;
  int quality = PreviewWish{}.quality;
  double fps = PreviewWish{}.fps;
  PictureKind picture = PreviewWish{}.picture;
  bool regions = PreviewWish{}.regions;
  static constexpr auto fields() {
    using P = PreviewParams;
    return std::tuple{number("camera", &P::camera, 0, kMaxCameraId, "", "camera id"),
                      number("width", &P::width, 1, 16384, "px", "pictures are scaled down to it"),
                      number("quality", &P::quality, 1, 100, "", "of the JPEG"),
                      number("fps", &P::fps, kMinFps, kMaxFps, "Hz", "at most that many pictures"),
                      choice("picture", &P::picture, kPictureChoices, "what to see"),
                      flag("regions", &P::regions, "also the frame's regions")};
  }
};

struct AckParams {
  int camera = 0;
  std::uint32_t frame = 0;
  static constexpr auto fields() {
    return std::tuple{number("camera", &AckParams::camera, 0, kMaxCameraId, "", "camera id"),
                      number("frame", &AckParams::frame, std::int64_t{0},
                             std::int64_t{std::numeric_limits<std::uint32_t>::max()}, "", "frame number")};
  }
};

template <class P>
P read_message(const Json& json, const std::string& path) {
  P params;
  read_params(params, json, path);
  return params;
}

}  // namespace

/// One viewer. Kept alive by its pending reads and writes.
class WebSocketSession : public std::enable_shared_from_this<WebSocketSession> {
 public:
  WebSocketSession(WebSocketHub& hub, CameraFeed::ViewerId id, asio::ip::tcp::socket socket,
                   ScopedCount connection, MayLook may_look)
      : hub_(hub),
        id_(id),
        connection_(std::move(connection)),
        may_look_(std::move(may_look)),
        stream_(std::move(socket)) {}

  CameraFeed::ViewerId id() const { return id_; }
  bool may_look() const { return may_look_(); }
  bool wants_status() const { return wants_status_; }
  bool wants_detections() const { return wants_detections_; }

  void leave() {
    if (left_) return;
    left_ = true;
    hub_.left(*this);
    viewer_.reset();
    beast::get_lowest_layer(stream_).close();
  }

  void start(const WebSocketHub::UpgradeRequest& request) {
    namespace websocket = beast::websocket;
    stream_.set_option(websocket::stream_base::timeout{kHandshakeTimeout, kSilenceTimeout, true});
    stream_.read_message_max(kMaxMessageBytes);
    stream_.auto_fragment(false);  // a picture leaves in one write
    stream_.set_option(websocket::stream_base::decorator([](websocket::response_type& answer) {
      for (const auto& [name, value] : kSecurityHeaders) answer.set(name, value);
    }));
    stream_.async_accept(request, [self = shared_from_this()](beast::error_code error) {
      if (error) return;
      self->viewer_.emplace(self->hub_.counters_.viewers);
      self->hub_.joined(*self);
      self->read();
    });
  }

  /// What waits to be sent: one message of each kind and camera. A newer one takes the place of an older one,
  /// so that a slow viewer skips messages and no queue grows.
  struct Topic {
    enum class Kind { kError, kStatus, kDetections, kPreview } kind;
    std::uint32_t camera = 0;
    bool operator==(const Topic&) const = default;
  };

  void send(const Topic& topic, CameraFeed::Message message) {
    const auto waiting =
        std::find_if(outbox_.begin(), outbox_.end(), [&](const Outgoing& one) { return one.topic == topic; });
    if (waiting != outbox_.end()) {
      waiting->message = std::move(message);
      return;
    }
    outbox_.push_back({topic, std::move(message)});
    write();
  }

  /// For a feed's thread: brings the message to the connection's own thread, if that is still open.
  CameraFeed::Sink sink(const Topic& topic) {
    return [weak = weak_from_this(), executor = stream_.get_executor(),
            topic](const CameraFeed::Message& message) {
      asio::post(executor, [weak, topic, message] {
        if (const auto self = weak.lock()) self->send(topic, message);
      });
    };
  }

 private:
  struct Outgoing {
    Topic topic;
    CameraFeed::Message message;
  };

  void read() {
    stream_.async_read(incoming_, [self = shared_from_this()](beast::error_code error, std::size_t) {
      if (error) return self->leave();
      const auto bytes = self->incoming_.cdata();
      self->handle({static_cast<const char*>(bytes.data()), bytes.size()});
      self->incoming_.consume(self->incoming_.size());
      self->read();
    });
  }

  void write() {
    if (writing_ || outbox_.empty()) return;
    writing_ = outbox_.front().message;
    stream_.binary(outbox_.front().topic.kind == Topic::Kind::kPreview);
    outbox_.pop_front();
    stream_.async_write(asio::buffer(*writing_),
                        [self = shared_from_this()](beast::error_code error, std::size_t) {
                          if (error) return self->leave();
                          self->writing_.reset();
                          self->write();
                        });
  }

  void handle(std::string_view text) try {
    const Json message = parse_json(text);
    if (!message.is_object()) throw HttpError(400, "expected an object");
    for (const auto& item : message.items()) handle(item.key(), item.value());
  } catch (const std::exception& error) {
    const Json answer{{"error", error.what()}};
    send({Topic::Kind::kError}, std::make_shared<const std::string>(to_text(answer)));
  }

  void handle(const std::string& key, const Json& value) {
    const std::string path = "/" + key;
    if (key == "subscribe" || key == "unsubscribe") {
      if (!value.is_array()) refuse(path, value, "a list of topics");
      for (const Json& topic : value) set_topic(topic, key == "subscribe");
    } else if (key == "preview") {
      const auto wanted = read_message<PreviewParams>(value, path);
      const auto camera = static_cast<std::uint32_t>(wanted.camera);
      hub_.feeds_.of(camera).start_preview(
          id_, {wanted.width, wanted.quality, wanted.fps, wanted.picture, wanted.regions},
          sink({Topic::Kind::kPreview, camera}));
    } else if (key == "ack") {
      const auto ack = read_message<AckParams>(value, path);
      hub_.feeds_.of(static_cast<std::uint32_t>(ack.camera)).acknowledge(id_, ack.frame);
    } else if (key == "stop_preview") {
      const int camera = read_number<int>(value, path, 0, kMaxCameraId, "");
      hub_.feeds_.of(static_cast<std::uint32_t>(camera)).stop_preview(id_);
    } else {
      throw HttpError(400,
                      path + ": no such message; known: subscribe, unsubscribe, preview, ack, stop_preview");
    }
  }

  void set_topic(const Json& topic, bool on) {
    if (topic == "status") {
      if (on && !wants_status_) hub_.send_status_soon(*this);
      wants_status_ = on;
    } else if (topic == "detections") {
      wants_detections_ = on;
      on ? hub_.follow_detections(*this) : hub_.feeds_.stop_detections(id_);
    } else {
      refuse("/subscribe", topic, "\"status\" or \"detections\"");
    }
  }

  WebSocketHub& hub_;
  const CameraFeed::ViewerId id_;
  const ScopedCount connection_;
  const MayLook may_look_;
  std::optional<ScopedCount> viewer_;  // once the handshake is done
  beast::websocket::stream<beast::tcp_stream> stream_;
  beast::flat_buffer incoming_;
  std::deque<Outgoing> outbox_;
  CameraFeed::Message writing_;  // null: no write is under way
  bool wants_status_ = false;
  bool wants_detections_ = false;
  bool left_ = false;
};

WebSocketHub::WebSocketHub(asio::io_context& io, asio::io_context& workers, const WebHost& host,
                           CameraFeeds& feeds, WebCounters& counters)
    : io_(io), workers_(workers), host_(host), feeds_(feeds), counters_(counters), timer_(io) {}

void WebSocketHub::accept(asio::ip::tcp::socket socket, ScopedCount connection, const UpgradeRequest& request,
                          MayLook may_look) {
  limit_unsent_bytes(socket);
  std::make_shared<WebSocketSession>(*this, feeds_.new_viewer(), std::move(socket), std::move(connection),
                                     std::move(may_look))
      ->start(request);
}

void WebSocketHub::joined(WebSocketSession& session) {
  sessions_.emplace(session.id(), &session);
  if (!ticking_) tick();
}

void WebSocketHub::left(WebSocketSession& session) {
  sessions_.erase(session.id());
  feeds_.stop_previews(session.id());
  feeds_.stop_detections(session.id());
}

void WebSocketHub::follow_detections(WebSocketSession& session) {
  for (const std::uint32_t camera_id : host_.camera_ids()) {
    const WebSocketSession::Topic topic{WebSocketSession::Topic::Kind::kDetections, camera_id};
    try {
      feeds_.of(camera_id).start_detections(session.id(), session.sink(topic));
    } catch (const HttpError&) {
      // It was removed since its id was asked for.
    } catch (const std::exception& error) {  // no thread to be had: the next tick tries again
      complain(fmt::format("no detections of camera {} for viewers: {}", camera_id, error.what()));
    }
  }
}

void WebSocketHub::complain(const std::string& problem) {
  if (problem != last_problem_) log::error("web: {}", problem);
  last_problem_ = problem;
}

void WebSocketHub::send_status_soon(WebSocketSession& session) {
  if (last_status_) {
    session.send({WebSocketSession::Topic::Kind::kStatus}, last_status_);
  } else {
    timer_.cancel();  // ticks at once
  }
}

void WebSocketHub::tick() {
  try {
    look_at_sessions();
  } catch (const std::exception& error) {  // whatever it is, the next tick must come
    complain(error.what());
  }
  const bool wanted = std::any_of(sessions_.begin(), sessions_.end(),
                                  [](const auto& entry) { return entry.second->wants_status(); });
  ticking_ = !sessions_.empty();
  if (!wanted) return send_status(nullptr);
  asio::post(workers_, [this] {
    CameraFeed::Message status;
    try {
      status = std::make_shared<const std::string>(to_text({{"topic", "status"}, {"data", host_.status()}}));
    } catch (const std::exception& error) {
      log::error("web: no status for viewers: {}", error.what());
    }
    asio::post(io_, [this, status] { send_status(status); });
  });
}

void WebSocketHub::look_at_sessions() {
  std::vector<std::shared_ptr<WebSocketSession>> uninvited;
  for (const auto& [id, session] : sessions_) {
    if (!session->may_look()) uninvited.push_back(session->shared_from_this());
  }
  for (const auto& session : uninvited) session->leave();
  for (const auto& [id, session] : sessions_) {
    if (session->wants_detections()) follow_detections(*session);  // a camera may have been added
  }
}

void WebSocketHub::send_status(const CameraFeed::Message& status) {
  last_status_ = status;
  if (status) {
    for (const auto& [id, session] : sessions_) {
      if (session->wants_status()) session->send({WebSocketSession::Topic::Kind::kStatus}, status);
    }
  }
  if (!ticking_) return;
  timer_.expires_after(kStatusPeriod);
  timer_.async_wait([this](beast::error_code) { tick(); });
}

}  // namespace sslv
