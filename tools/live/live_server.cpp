#include "tools/live/live_server.hpp"

#include <fmt/format.h>
#include <sys/resource.h>
#include <unistd.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <thread>
#include <utility>

#include "tools/live/connection.hpp"
#include "tools/live/hub.hpp"

namespace colift::live {

namespace asio = boost::asio;
using tcp = asio::ip::tcp;

struct LiveServer::Impl {
  Impl(const ServerConfig& config, PageFiles files)
      : hub(std::make_shared<Hub>(config, std::move(files))), acceptor(context), pause(context) {}

  hal::Result<void> listen() {
    const ServerConfig& config = hub->config();
    boost::system::error_code error;
    const auto address = asio::ip::make_address(config.address, error);
    const std::string where = fmt::format("view {}:{}", config.address, config.port);
    if (error)
      return hal::failure(hal::ErrorCode::BadConfig, where, "expected a numeric address such as 127.0.0.1");
    const tcp::endpoint endpoint(address, config.port);
    const auto check = [&](const char* what) -> hal::Result<void> {
      if (!error) return {};
      return hal::failure(
          hal::ErrorCode::BadConfig, where,
          fmt::format("cannot {}: {}; choose another port with --view PORT", what, error.message()));
    };
    acceptor.open(endpoint.protocol(), error);
    if (auto r = check("open a socket"); !r) return r;
    acceptor.set_option(asio::socket_base::reuse_address(true), error);
    acceptor.bind(endpoint, error);
    if (auto r = check("bind"); !r) return r;
    acceptor.listen(asio::socket_base::max_listen_connections, error);
    if (auto r = check("listen"); !r) return r;
    // from here on the acceptor belongs to the server's thread
    port = acceptor.local_endpoint(error).port();
    return check("read the port");
  }

  void accept() {
    acceptor.async_accept([this](boost::system::error_code error, tcp::socket socket) {
      if (error == asio::error::operation_aborted) return;
      if (error) return wait_and_accept();  // out of descriptors, say: not at once again
      socket.set_option(tcp::no_delay(true), error);
      serve_connection(std::move(socket), hub);
      accept();
    });
  }

  void wait_and_accept() {
    pause.expires_after(std::chrono::milliseconds(100));
    pause.async_wait([this](boost::system::error_code error) {
      if (!error) accept();
    });
  }

  std::shared_ptr<Hub> hub;
  asio::io_context context{1};
  tcp::acceptor acceptor;
  std::uint16_t port = 0;  ///< What was asked for, or the free one that was given.
  asio::steady_timer pause;
  std::thread thread;
};

LiveServer::LiveServer(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}

hal::Result<std::unique_ptr<LiveServer>> LiveServer::open(const ServerConfig& config, PageFiles files) {
  auto impl = std::make_unique<Impl>(config, std::move(files));
  if (auto listening = impl->listen(); !listening) return tl::unexpected(listening.error());
  const auto born = std::chrono::system_clock::now().time_since_epoch();
  impl->hub->set_session(
      fmt::format("{}", std::chrono::duration_cast<std::chrono::milliseconds>(born).count()));
  impl->accept();
  impl->thread = std::thread([raw = impl.get()] {
    // whoever works goes before whoever watches
    (void)::setpriority(PRIO_PROCESS, static_cast<id_t>(::gettid()), 10);
    raw->context.run();
  });
  return std::unique_ptr<LiveServer>(new LiveServer(std::move(impl)));
}

LiveServer::~LiveServer() {
  impl_->context.stop();
  impl_->thread.join();
}

std::uint16_t LiveServer::port() const {
  return impl_->port;
}

std::string LiveServer::url() const {
  const ServerConfig& config = impl_->hub->config();
  const std::string host =
      config.address.find(':') == std::string::npos ? config.address : "[" + config.address + "]";
  const std::string query = config.door.token.empty() ? "" : "?token=" + config.door.token;
  return fmt::format("http://{}:{}/{}", host, port(), query);
}

void LiveServer::publish(const telemetry::Publication& publication) {
  if (impl_->hub->hand_in(publication)) asio::post(impl_->context, [hub = impl_->hub] { hub->pass_on(); });
}

ServerCounts LiveServer::counts() const {
  const Hub& hub = *impl_->hub;
  return {hub.clients, hub.clients_ever, hub.turned_away, hub.published, hub.dropped, hub.sent};
}

}  // namespace colift::live
