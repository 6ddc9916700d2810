#include "tools/live/connection.hpp"

#include <fmt/format.h>

#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/version.hpp>
#include <chrono>
#include <memory>
#include <optional>
#include <utility>

#include "tools/live/channel_client.hpp"

namespace colift::live {
namespace {

namespace beast = boost::beast;
namespace http = beast::http;
using tcp = boost::asio::ip::tcp;

constexpr auto kRequestTime = std::chrono::seconds(20);
constexpr std::size_t kSlowest_bytes_s = 500'000;  ///< A large document may take longer.
constexpr std::size_t kLargestHeader = 8 * 1024;
constexpr std::string_view kStopPath = "/operator/stop";

std::string text_of(beast::string_view view) {
  return {view.data(), view.size()};
}

/// One connection as long as it speaks HTTP.
class HttpConnection final : public Caller, public std::enable_shared_from_this<HttpConnection> {
 public:
  HttpConnection(tcp::socket socket, std::shared_ptr<Hub> hub)
      : stream_(std::move(socket)), hub_(std::move(hub)) {
    hub_->call(this);
    ++hub_->clients;
  }
  ~HttpConnection() override {
    hub_->hang_up(this);
    --hub_->clients;
  }
  void turn_out() override {
    beast::error_code ignored;
    stream_.socket().close(ignored);  // what it waits for ends with an error, and it with that
  }

  void read() {
    parser_.emplace();
    parser_->header_limit(kLargestHeader);
    parser_->body_limit(0);  // nothing that is asked here has a body
    stream_.expires_after(kRequestTime);
    http::async_read(stream_, buffer_, *parser_,
                     [self = shared_from_this()](beast::error_code error, std::size_t) {
                       if (!error)
                         self->answer();
                       else
                         self->end();
                     });
  }

 private:
  void answer() {
    hub_->renew(this);
    const auto& request = parser_->get();
    Visitor visitor{text_of(request[http::field::host]), {}, text_of(request.target())};
    if (const auto origin = request.find(http::field::origin); origin != request.end())
      visitor.origin = text_of(origin->value());
    shared_with_ = shared_with(visitor, hub_->config().door);
    const bool upgrade = beast::websocket::is_upgrade(request);
    const bool asks_stop = request.method() == http::verb::post && clean_path(visitor.target) == kStopPath;
    // an ordinary request for the page may come from anywhere that a link may stand; what acts, and a
    // channel, may not
    if (!upgrade && !asks_stop) visitor.origin.reset();
    if (const auto why = turned_away(visitor, hub_->config().door)) {
      ++hub_->turned_away;
      return send(http::status::forbidden, {"text/plain; charset=utf-8", *why + "\n"});
    }
    if (upgrade) {
      const bool operates = has_token(visitor.target, hub_->config().door);
      if (!hub_->has_place(operates)) {
        ++hub_->turned_away;
        return send(http::status::service_unavailable,
                    {"text/plain; charset=utf-8", "all places are taken; close another page of this run\n"});
      }
      stream_.expires_never();  // from here on the WebSocket's own deadlines hold
      return serve_channels(std::move(stream_), parser_->release(), hub_, operates);
    }
    if (asks_stop) return stop(visitor);
    if (request.method() != http::verb::get && request.method() != http::verb::head)
      return send(http::status::method_not_allowed,
                  {"text/plain; charset=utf-8", "only GET and HEAD are served\n"});
    if (auto document = hub_->files().find(visitor.target))
      return send(http::status::ok, std::move(document));
    send(http::status::not_found, {"text/plain; charset=utf-8", "there is nothing here\n"});
  }

  /// The operator's stop as a request of its own: it waits behind no message of the channels, and needs no
  /// connection that has lasted.
  void stop(const Visitor& visitor) {
    const ServerConfig& config = hub_->config();
    if (!config.on_stop || !has_token(visitor.target, config.door)) {
      ++hub_->turned_away;
      return send(http::status::forbidden,
                  {"text/plain; charset=utf-8",
                   "only the operator's address, which holds the token, stops the run\n"});
    }
    config.on_stop();
    send(http::status::ok, {"application/json", R"({"done":true,"what":"the run is being ended safely"})"});
  }

  void send(http::status status, Document document) {
    send(status, std::make_shared<const Document>(std::move(document)));
  }

  void send(http::status status, std::shared_ptr<const Document> document) {
    const auto& request = parser_->get();
    response_.emplace(status, request.version());
    response_->set(http::field::server, "CoLift");
    response_->set(http::field::content_type, document->type);
    response_->set(http::field::cache_control, "no-store");
    response_->set("X-Content-Type-Options", "nosniff");
    // a viewer in a browser reads the robot's model from its own page
    if (shared_with_) response_->set(http::field::access_control_allow_origin, *shared_with_);
    response_->set(http::field::vary, "Origin");
    response_->set("Referrer-Policy", "no-referrer");  // the address may hold an operator's token
    response_->set("Content-Security-Policy",
                   "default-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data: blob:; "
                   "connect-src 'self' ws: wss:; frame-ancestors 'self'");
    response_->keep_alive(request.keep_alive() && status == http::status::ok);
    response_->content_length(document->body.size());
    if (request.method() != http::verb::head)
      response_->body() = {document->body.data(), document->body.size()};
    document_ = std::move(document);
    stream_.expires_after(kRequestTime + std::chrono::seconds(document_->body.size() / kSlowest_bytes_s));
    http::async_write(stream_, *response_, [self = shared_from_this()](beast::error_code error, std::size_t) {
      if (error || !self->response_->keep_alive()) return self->end();
      self->read();
    });
  }

  void end() {
    beast::error_code ignored;
    stream_.socket().shutdown(tcp::socket::shutdown_send, ignored);
  }

  beast::tcp_stream stream_;
  std::shared_ptr<Hub> hub_;
  beast::flat_buffer buffer_{kLargestHeader * 2};
  std::optional<http::request_parser<http::empty_body>> parser_;
  std::optional<std::string> shared_with_;  ///< Of the request that is being answered.
  std::optional<http::response<http::span_body<const char>>> response_;
  std::shared_ptr<const Document> document_;  ///< What the response shows: shared, however many read it.
};

}  // namespace

void serve_connection(tcp::socket socket, std::shared_ptr<Hub> hub) {
  std::make_shared<HttpConnection>(std::move(socket), std::move(hub))->read();
}

}  // namespace colift::live
