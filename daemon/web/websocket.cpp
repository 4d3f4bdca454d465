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
#include <boost/beast/core/basic_stream.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/rate_policy.hpp>
#include <boost/beast/websocket/stream.hpp>
#include <fmt/format.h>

namespace sslv {

namespace asio = boost::asio;
namespace beast = boost::beast;

namespace {

constexpr std::chrono::milliseconds kLookPeriod{500};  // between checks of the viewers
constexpr std::chrono::seconds kHandshakeTimeout{10};
constexpr std::chrono::seconds kSilenceTimeout{20};  // a viewer that answers no ping counts as gone
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
                      number("width", &P::width, 1, 16384, "px", "images are scaled down to it"),
                      number("quality", &P::quality, 1, 100, "", "of the JPEG"),
                      number("fps", &P::fps, kMinFps, kMaxFps, "Hz", "maximum number of images per second"),
                      choice("picture", &P::picture, kPictureChoices, "what the image shows"),
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

/// A Beast rate policy without a limit. Beast reports only to the rate policy how much of a message the
/// client has received.
class TellsProgress {
 public:
  /// Weak: a ping may still be in flight after the viewer has gone.
  explicit TellsProgress(std::weak_ptr<Connections::Seat> seat) : seat_(std::move(seat)) {}

 private:
  friend beast::rate_policy_access;
  static constexpr std::size_t kNoLimit = std::numeric_limits<std::size_t>::max();
  static std::size_t available_read_bytes() { return kNoLimit; }
  static std::size_t available_write_bytes() { return kNoLimit; }
  static void transfer_read_bytes(std::size_t) {}
  void transfer_write_bytes(std::size_t size) {
    const auto seat = size > 0 ? seat_.lock() : nullptr;
    if (seat) seat->makes_progress();
  }
  static void on_timer() {}

  std::weak_ptr<Connections::Seat> seat_;
};
using Stream = beast::basic_stream<asio::ip::tcp, asio::ip::tcp::socket::executor_type, TellsProgress>;

template <class P>
P read_message(const Json& json, const std::string& path) {
  P params;
  read_params(params, json, path);
  return params;
}

}  // namespace

std::vector<Route> websocket_routes() {
  return {{"GET", WebSocketHub::kPath.data(), [](const Request&) {
             Response response = json_response({{"error", "this address speaks WebSocket only"}}, 426);
             response.headers.emplace_back("Upgrade", "websocket");
             return response;
           }}};
}

/// One viewer. Kept alive by its pending reads and writes.
class WebSocketSession : public std::enable_shared_from_this<WebSocketSession> {
 public:
  WebSocketSession(WebSocketHub& hub, CameraFeed::ViewerId id, asio::ip::tcp::socket socket,
                   ScopedCount connection, Connections::Seat& seat, MayLook may_look)
      : hub_(hub),
        id_(id),
        connection_(std::move(connection)),
        seat_(seat),
        may_look_(std::move(may_look)),
        stream_(TellsProgress(seat.weak_from_this()), std::move(socket)),
        wanted_topics_(hub.topics_.size()) {}

  CameraFeed::ViewerId id() const { return id_; }
  bool may_look() const { return may_look_(); }
  bool wants_topic(std::size_t topic) const { return wanted_topics_[topic]; }
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
    // Posted, because this is called while messages are being distributed.
    seat_.closes_by([weak = weak_from_this(), executor = stream_.get_executor()] {
      asio::post(executor, [weak] {
        if (const auto self = weak.lock()) self->leave();
      });
    });
    stream_.set_option(websocket::stream_base::timeout{kHandshakeTimeout, kSilenceTimeout, true});
    stream_.read_message_max(kMaxMessageBytes);
    stream_.auto_fragment(false);  // an image leaves in one write
    stream_.set_option(websocket::stream_base::decorator([](websocket::response_type& answer) {
      for (const auto& [name, value] : kSecurityHeaders) answer.set(name, value);
    }));
    const bool is_second = request.target() == WebSocketHub::kSecondPath.data();
    stream_.async_accept(request, [self = shared_from_this(), is_second](beast::error_code error) {
      if (error) return;
      if (!is_second) self->viewer_.emplace(self->hub_.counters_.viewers);
      self->hub_.joined(*self);
      self->read();
    });
  }

  /// Key of a message that waits to be sent. At most one message of a kind waits for each camera or topic: a
  /// newer one replaces it, so that a slow viewer skips messages and no queue grows. Messages are also
  /// skipped while too much data waits for all viewers together.
  struct Slot {
    enum class Kind { kError, kTopic, kDetections, kPreview } kind;
    std::uint32_t number = 0;  // index of the topic, or id of the camera
    bool operator==(const Slot&) const = default;
  };

  void send(const Slot& slot, CameraFeed::Message message) {
    const auto waiting =
        std::find_if(outbox_.begin(), outbox_.end(), [&](const Outgoing& one) { return one.slot == slot; });
    const std::size_t before = waiting == outbox_.end() ? 0 : waiting->message->size();
    std::string ignored;
    if (!seat_.holds(unsent_bytes_ - before + message->size(), ignored)) return skip(slot);
    unsent_bytes_ += message->size() - before;
    if (waiting != outbox_.end()) {
      waiting->message = std::move(message);
      return;
    }
    outbox_.push_back({slot, std::move(message)});
    write();
  }

  /// For a feed's thread: posts the message to the connection's thread if the connection is still open.
  CameraFeed::Sink sink(const Slot& slot) {
    return [weak = weak_from_this(), executor = stream_.get_executor(),
            slot](const CameraFeed::Message& message) {
      asio::post(executor, [weak, slot, message] {
        if (const auto self = weak.lock()) self->send(slot, message);
      });
    };
  }

 private:
  struct Outgoing {
    Slot slot;
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

  /// Acknowledges a skipped preview, so that the feed does not wait for the client to acknowledge it.
  void skip(const Slot& slot) {
    if (slot.kind != Slot::Kind::kPreview) return;
    if (CameraFeed* feed = hub_.feeds_.find(slot.number)) feed->acknowledge(id_);
  }

  void write() {
    if (writing_ || outbox_.empty()) return;
    writing_ = outbox_.front().message;
    stream_.binary(outbox_.front().slot.kind == Slot::Kind::kPreview);
    outbox_.pop_front();
    stream_.async_write(asio::buffer(*writing_),
                        [self = shared_from_this()](beast::error_code error, std::size_t) {
                          if (error) return self->leave();
                          self->unsent_bytes_ -= self->writing_->size();
                          self->writing_.reset();
                          std::string ignored;
                          self->seat_.holds(self->unsent_bytes_, ignored);
                          self->write();
                        });
  }

  void handle(std::string_view text) try {
    const Json message = parse_json(text);
    if (!message.is_object()) throw HttpError(400, "expected an object");
    for (const auto& item : message.items()) handle(item.key(), item.value());
  } catch (const std::exception& error) {
    const Json answer{{"error", error.what()}};
    send({Slot::Kind::kError}, std::make_shared<const std::string>(to_text(answer)));
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
          sink({Slot::Kind::kPreview, camera}));
    } else if (key == "ack") {
      const auto ack = read_message<AckParams>(value, path);
      if (CameraFeed* feed = hub_.feeds_.find(static_cast<std::uint32_t>(ack.camera)))
        feed->acknowledge(id_, ack.frame);
    } else if (key == "stop_preview") {
      const int camera = read_number<int>(value, path, 0, kMaxCameraId, "");
      if (CameraFeed* feed = hub_.feeds_.find(static_cast<std::uint32_t>(camera))) feed->stop_preview(id_);
    } else {
      throw HttpError(400,
                      path + ": no such message; known: subscribe, unsubscribe, preview, ack, stop_preview");
    }
  }

  void set_topic(const Json& name, bool on) {
    if (name == "detections") {
      wants_detections_ = on;
      on ? static_cast<void>(hub_.follow_detections(*this)) : hub_.feeds_.stop_detections(id_);
      return;
    }
    std::string known;
    for (std::size_t topic = 0; topic < hub_.topics_.size(); ++topic) {
      known += fmt::format("\"{}\" or ", hub_.topics_[topic]->topic_name());
      if (name != hub_.topics_[topic]->topic_name()) continue;
      if (on && !wanted_topics_[topic]) hub_.send_topic_soon(*this, topic);
      wanted_topics_[topic] = on;
      return;
    }
    refuse("/subscribe", name, known + "\"detections\"");
  }

  WebSocketHub& hub_;
  const CameraFeed::ViewerId id_;
  const ScopedCount connection_;  // holds the seat
  Connections::Seat& seat_;
  const MayLook may_look_;
  std::optional<ScopedCount> viewer_;  // set after the handshake of a client's first connection
  beast::websocket::stream<Stream> stream_;
  beast::flat_buffer incoming_;
  std::deque<Outgoing> outbox_;
  CameraFeed::Message writing_;   // null: no write in progress
  std::size_t unsent_bytes_ = 0;  // size of outbox_ and writing_ together
  std::vector<bool> wanted_topics_;
  bool wants_detections_ = false;
  bool left_ = false;
};

WebSocketHub::WebSocketHub(asio::io_context& io, asio::io_context& workers, ViewSource& views,
                           std::vector<Topic*> topics, CameraFeeds& feeds, WebCounters& counters)
    : io_(io),
      workers_(workers),
      views_(views),
      topics_(std::move(topics)),
      feeds_(feeds),
      counters_(counters),
      timer_(io),
      last_messages_(topics_.size()),
      topic_due_(topics_.size()) {}

void WebSocketHub::accept(asio::ip::tcp::socket socket, ScopedCount connection, Connections::Seat& seat,
                          const UpgradeRequest& request, MayLook may_look) {
  limit_unsent_bytes(socket);
  std::make_shared<WebSocketSession>(*this, feeds_.new_viewer(), std::move(socket), std::move(connection),
                                     seat, std::move(may_look))
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

std::string WebSocketHub::follow_detections(WebSocketSession& session) {
  std::string problem;
  for (const std::uint32_t camera_id : views_.camera_ids()) {
    const WebSocketSession::Slot slot{WebSocketSession::Slot::Kind::kDetections, camera_id};
    try {
      feeds_.of(camera_id).start_detections(session.id(), session.sink(slot));
    } catch (const HttpError&) {
      // The camera was removed after its id was read.
    } catch (const std::exception& error) {  // no thread can start
      problem = fmt::format("no detections for viewers: {}", error.what());
    }
  }
  return problem;
}

void WebSocketHub::send_topic_soon(WebSocketSession& session, std::size_t topic) {
  if (const auto& message = last_messages_[topic]) {
    session.send({WebSocketSession::Slot::Kind::kTopic, static_cast<std::uint32_t>(topic)}, message);
  } else {
    timer_.cancel();  // triggers a tick at once
  }
}

void WebSocketHub::tick() {
  const auto now = Clock::now();
  if (now >= look_due_) {
    look_due_ = now + kLookPeriod;
    std::string problem;
    try {
      problem = look_at_sessions();
    } catch (const std::exception& error) {  // the next tick must be scheduled after any error
      problem = error.what();
    }
    if (!problem.empty() && problem != last_problem_) log::error("web: {}", problem);
    last_problem_ = problem;
  }
  ticking_ = !sessions_.empty();
  next_tick_ = look_due_;
  std::vector<bool> wanted(topics_.size());
  for (std::size_t topic = 0; topic < topics_.size(); ++topic) {
    const bool is_wanted = std::any_of(sessions_.begin(), sessions_.end(),
                                       [&](const auto& one) { return one.second->wants_topic(topic); });
    if (!is_wanted) {
      last_messages_[topic].reset();
      topic_due_[topic] = {};
      continue;
    }
    // A topic that is due within kEarly is made now, not in a tick of its own. Timers never fire early.
    constexpr std::chrono::milliseconds kEarly{2};
    if (now + kEarly >= topic_due_[topic]) {
      wanted[topic] = true;
      topic_due_[topic] = std::max(topic_due_[topic], now - kEarly) + topics_[topic]->topic_period();
    }
    next_tick_ = std::min(next_tick_, topic_due_[topic]);
  }
  if (std::none_of(wanted.begin(), wanted.end(), [](bool one) { return one; }))
    return send_topics(TopicMessages(topics_.size()));
  asio::post(workers_, [this, wanted] {
    asio::post(io_, [this, messages = make_messages(wanted)]() mutable { send_topics(std::move(messages)); });
  });
}

std::string WebSocketHub::look_at_sessions() {
  std::vector<std::shared_ptr<WebSocketSession>> uninvited;
  for (const auto& [id, session] : sessions_) {
    if (!session->may_look()) uninvited.push_back(session->shared_from_this());
  }
  for (const auto& session : uninvited) session->leave();
  std::string problem;
  for (const auto& [id, session] : sessions_) {
    if (!session->wants_detections()) continue;
    const std::string own = follow_detections(*session);  // includes cameras that were added
    if (problem.empty()) problem = own;
  }
  return problem;
}

WebSocketHub::TopicMessages WebSocketHub::make_messages(const std::vector<bool>& wanted) const {
  TopicMessages messages(topics_.size());
  for (std::size_t i = 0; i < topics_.size(); ++i) {
    if (!wanted[i]) continue;
    Topic& topic = *topics_[i];
    try {
      messages[i] = std::make_shared<const std::string>(
          to_text({{"topic", topic.topic_name()}, {"data", topic.topic_data()}}));
    } catch (const std::exception& error) {
      log::error("web: no {} for viewers: {}", topic.topic_name(), error.what());
    }
  }
  return messages;
}

void WebSocketHub::send_topics(TopicMessages messages) {
  for (std::size_t topic = 0; topic < topics_.size(); ++topic) {
    const CameraFeed::Message& message = messages[topic];
    if (!message) continue;
    last_messages_[topic] = message;
    for (const auto& [id, session] : sessions_) {
      if (session->wants_topic(topic))
        session->send({WebSocketSession::Slot::Kind::kTopic, static_cast<std::uint32_t>(topic)}, message);
    }
  }
  if (!ticking_) return;
  timer_.expires_at(next_tick_);
  timer_.async_wait([this](beast::error_code) { tick(); });
}

}  // namespace sslv
