#include "tools/live/channel_client.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/beast/http/field.hpp>
#include <chrono>
#include <functional>
#include <map>
#include <utility>
#include <vector>

#include "hal/types/time.hpp"
#include "tools/live/visitor.hpp"

namespace colift::live {
namespace {

namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using Request = http::request<http::empty_body>;

/// A service for operators: what it does, and what its caller is answered. A confirmation counts only where
/// the run waits for it, which only the run itself knows.
struct OperatorCall {
  OperatorService service;
  std::function<void()> act;
  const char* answer;
};

std::vector<OperatorCall> operator_calls(const ServerConfig& config) {
  std::vector<OperatorCall> all{
      {{1, "/operator/stop", "The run ends safely: as at Ctrl-C."},
       config.on_stop,
       R"({"done":true,"what":"the run is being ended safely"})"},
      {{2, "/operator/lower", "Confirms that a paused object may be lowered."},
       config.on_lower,
       R"({"done":true,"what":"the confirmation is passed on: a paused object is lowered"})"},
      {{3, "/operator/continue", "Confirms that an arm which stopped for somebody may continue."},
       config.on_continue,
       R"({"done":true,"what":"the confirmation is passed on: an arm that waits for it continues"})"}};
  std::erase_if(all, [](const OperatorCall& call) { return !call.act; });
  return all;
}

/// How long a client may take for one message, or for the answer to a ping that waits behind others. A page
/// that draws slowly is behind, not gone: the operator's is given more time.
constexpr auto kWatcherTimeout = std::chrono::seconds(20), kOperatorTimeout = std::chrono::seconds(60);
/// What the system keeps for a client that is behind (bytes). With what it chooses by itself, megabytes, a
/// slow client gets minutes of what has been; beyond this the outbox keeps the newest of each topic.
constexpr int kSendBuffer = 64 * 1024;

/// One client of the channels. Everything happens in the server's thread.
class ChannelClient final : public Listener, public std::enable_shared_from_this<ChannelClient> {
 public:
  ChannelClient(beast::tcp_stream stream, std::shared_ptr<Hub> hub, bool operates)
      : ws_(std::move(stream)),
        hub_(std::move(hub)),
        operates_(operates && hub_->config().on_stop != nullptr),
        calls_(operates_ ? operator_calls(hub_->config()) : std::vector<OperatorCall>()),
        timeout_(operates_ ? kOperatorTimeout : kWatcherTimeout),
        talk_(hub_->config().messages_per_second, 4.0 * hub_->config().messages_per_second) {
    beast::error_code ignored;
    beast::get_lowest_layer(ws_).socket().set_option(boost::asio::socket_base::send_buffer_size(kSendBuffer),
                                                     ignored);
    hub_->take_place();
    ++hub_->clients;
  }
  ~ChannelClient() override {
    hub_->leave(this);
    hub_->leave_place();
    --hub_->clients;
  }

  void accept(Request request) {
    request_ = std::move(request);
    const auto offered = request_[http::field::sec_websocket_protocol];
    const auto protocol = chosen_sub_protocol({offered.data(), offered.size()});
    // who reads nothing answers no ping either, and is gone after this time
    ws_.set_option(websocket::stream_base::timeout{std::chrono::seconds(10), timeout_, true});
    ws_.set_option(websocket::stream_base::decorator([protocol](websocket::response_type& response) {
      response.set(http::field::server, "CoLift");
      if (protocol) response.set(http::field::sec_websocket_protocol, *protocol);
    }));
    ws_.auto_fragment(false);  // a message is one frame, and one call of the system
    ws_.read_message_max(hub_->config().largest_message);
    ws_.async_accept(request_,
                     [self = shared_from_this(), spoken = protocol.has_value()](beast::error_code error) {
                       if (!error) self->welcome(spoken);
                     });
  }

  void deliver(Post& post) override {
    const auto found = subscriptions_.find(static_cast<std::uint32_t>(post.topic()));
    if (found == subscriptions_.end()) return;
    // who talks without ever reading is not idle, and would stay for good
    if (sending_ && clock_.now() - sending_since_ > timeout_) return cut();
    queue(found->second, post);
    send();
  }

  void tell_time(hal::Timestamp now) override {
    outbox_.push_time(server_time(now));
    send();
  }

 private:
  void welcome(bool spoken) {
    if (!spoken)
      return close(websocket::close_code::protocol_error,
                   "offer the sub-protocol foxglove.sdk.v1 or foxglove.websocket.v1");
    hub_->join(this);
    ++hub_->clients_ever;
    outbox_.push_control(server_info(hub_->config().name, hub_->session(), operates_), false);
    outbox_.push_control(advertise(telemetry::channels().first(kLiveTopics)), false);
    if (operates_) {
      std::vector<OperatorService> services;
      for (const OperatorCall& call : calls_) services.push_back(call.service);
      outbox_.push_control(advertise_services(services), false);
    }
    if (const auto now = hub_->now()) outbox_.push_time(server_time(*now));
    send();
    read();
  }

  void read() {
    ws_.async_read(buffer_, [self = shared_from_this()](beast::error_code error, std::size_t) {
      if (error) return self->hub_->leave(self.get());
      self->hear();
    });
  }

  void hear() {
    // a polite end would read the rest of the flood, in search of the answer
    if (!talk_.take(hal::seconds(clock_.now()))) return cut();
    const auto data = buffer_.data();
    const std::string_view bytes(static_cast<const char*>(data.data()), data.size());
    const auto message = ws_.got_binary() ? parse_binary(bytes) : parse_text(bytes);
    if (message)
      std::visit([this](const auto& m) { act(m); }, *message);
    else
      outbox_.push_control(status(StatusLevel::Error, message.error().detail), false);
    buffer_.consume(buffer_.size());
    if (outbox_.hopeless()) return cut();  // nothing of the answers is read
    send();
    read();
  }

  void act(const Subscribe& message) {
    for (const Subscription& wanted : message.subscriptions) {
      if (wanted.channel >= kLiveTopics) {
        outbox_.push_control(
            status(StatusLevel::Error, fmt::format("there is no channel {}", wanted.channel)), false);
        continue;
      }
      const bool taken = std::any_of(subscriptions_.begin(), subscriptions_.end(),
                                     [&](const auto& s) { return s.second == wanted.id; });
      if (taken || subscriptions_.count(wanted.channel) != 0) {
        outbox_.push_control(
            status(StatusLevel::Warning,
                   fmt::format("subscription {} or channel {} is in use already", wanted.id, wanted.channel)),
            false);
        continue;
      }
      subscriptions_[wanted.channel] = wanted.id;
      for (const auto& post : hub_->board().history(static_cast<telemetry::Topic>(wanted.channel)))
        queue(wanted.id, *post);
    }
  }

  void act(const Unsubscribe& message) {
    for (const std::uint32_t id : message.ids)
      for (auto it = subscriptions_.begin(); it != subscriptions_.end(); ++it)
        if (it->second == id) {
          subscriptions_.erase(it);
          break;
        }
  }

  void act(const ServiceCall& call) {
    const auto asked = std::find_if(calls_.begin(), calls_.end(),
                                    [&](const OperatorCall& c) { return c.service.id == call.service; });
    if (asked == calls_.end()) {
      const char* why =
          operates_ ? "there is no such service" : "this connection only watches: it has no operator's token";
      outbox_.push_control(service_failure(call.service, call.call, why), false);
      return;
    }
    asked->act();
    outbox_.push_control(service_response(call.service, call.call, asked->answer), true);
  }

  void queue(std::uint32_t subscription, Post& post) {
    const std::uint64_t before = outbox_.dropped();
    outbox_.push(post.topic(), message_data(subscription, post.at(), post.text()));
    hub_->dropped += outbox_.dropped() - before;
  }

  void send() {
    if (sending_ || closing_ || outbox_.empty()) return;
    sending_ = true;
    sending_since_ = clock_.now();
    flying_ = outbox_.take();
    ws_.binary(flying_.binary);
    ws_.async_write(boost::asio::buffer(flying_.message),
                    [self = shared_from_this()](beast::error_code error, std::size_t) {
                      self->sending_ = false;
                      if (error) return self->hub_->leave(self.get());
                      ++self->hub_->sent;
                      if (self->closing_) return self->close_now();
                      self->send();
                    });
  }

  /// Without a word: it would not be read.
  void cut() {
    closing_ = true;
    boost::system::error_code ignored;
    beast::get_lowest_layer(ws_).socket().close(ignored);
  }
  void close(websocket::close_code code, const char* why) {
    hub_->leave(this);
    closing_ = true;
    reason_ = websocket::close_reason(code, why);
    if (!sending_) close_now();
  }
  void close_now() {
    ws_.async_close(reason_, [self = shared_from_this()](beast::error_code) {});
  }

  websocket::stream<beast::tcp_stream> ws_;
  std::shared_ptr<Hub> hub_;
  const bool operates_;
  const std::vector<OperatorCall> calls_;
  const std::chrono::seconds timeout_;
  TalkLimit talk_;
  Request request_;
  beast::flat_buffer buffer_;
  std::map<std::uint32_t, std::uint32_t> subscriptions_;  ///< Channel -> the client's id.
  Outbox outbox_;
  Outbox::Item flying_;
  bool sending_ = false, closing_ = false;
  hal::Timestamp sending_since_{0};
  const hal::SteadyClock clock_;
  websocket::close_reason reason_;
};

}  // namespace

void serve_channels(beast::tcp_stream stream, Request request, std::shared_ptr<Hub> hub, bool operates) {
  std::make_shared<ChannelClient>(std::move(stream), std::move(hub), operates)->accept(std::move(request));
}

}  // namespace colift::live
