#pragma once

#include <boost/asio/ip/tcp.hpp>
#include <memory>

#include "tools/live/hub.hpp"

namespace colift::live {

/// Serves one accepted TCP connection until it ends: HTTP requests, or after an upgrade the channels. Keeps
/// itself alive by what it waits for. For .cpp files of this folder only.
void serve_connection(boost::asio::ip::tcp::socket socket, std::shared_ptr<Hub> hub);

}  // namespace colift::live
