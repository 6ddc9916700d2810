#pragma once

#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/message.hpp>
#include <boost/beast/websocket.hpp>
#include <memory>

#include "tools/live/hub.hpp"

namespace colift::live {

/// Answers the request for an upgrade and serves the channels until the client leaves or breaks a limit. For
/// .cpp files of this folder only.
void serve_channels(boost::beast::tcp_stream stream,
                    boost::beast::http::request<boost::beast::http::empty_body> request,
                    std::shared_ptr<Hub> hub, bool operates);

}  // namespace colift::live
