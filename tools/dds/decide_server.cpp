#include "tools/dds/decide_server.hpp"

#include <fmt/format.h>

#include <cmath>

#include "hal/drivers/ros2_camera/message_views.hpp"
#include "tools/dds/convert_parts.hpp"
#include "tools/telemetry/channels/messages.hpp"

namespace colift::ros2 {
namespace {

using Request = colift_msgs_msg_dds__DecideRequest_;
using Reply = colift_msgs_msg_dds__DecideReply_;
using hal::dds::Qos;
using hal::dds::text_of;

constexpr std::size_t kLongestClient = 64;
constexpr double kFar_m = 20.0;

hal::Result<DecideTask> task_of(const Request& request) {
  const auto camera = hal::ros2::model_of(hal::ros2::view_of(request.info));
  if (!camera) return tl::unexpected(camera.error());
  auto depth = hal::ros2::depth_of(hal::ros2::view_of(request.depth), *camera);
  if (!depth) return tl::unexpected(depth.error());
  DecideTask task;
  task.frame.intrinsics = camera->intrinsics;
  task.frame.depth_m = std::move(*depth);
  task.partner_C = {request.partner.x, request.partner.y, request.partner.z};
  if (!(task.partner_C.norm() < kFar_m))
    return hal::failure(hal::ErrorCode::BadInput, "partner",
                        fmt::format("is no point within {} m of the camera", kFar_m));
  if (!std::isnan(request.share)) {
    if (!(request.share > 0.0 && request.share < 1.0))
      return hal::failure(
          hal::ErrorCode::BadInput, "share",
          fmt::format("{}; expected a number between 0 and 1, or NaN for what is configured", request.share));
    task.share = request.share;
  }
  return task;
}

}  // namespace

struct DecideServer::Impl {
  Decide decide;
  std::unique_ptr<hal::dds::Participant> participant;
  dds_entity_t requests = 0, replies = 0, waitset = 0;

  ~Impl() {
    if (waitset > 0) (void)dds_delete(waitset);
  }

  bool answer(const Request& request) {
    const std::string_view client = text_of(request.client);
    if (client.empty() || client.size() > kLongestClient) return false;
    hal::dds::Sample<Reply> reply(colift_msgs_msg_dds__DecideReply__desc);
    hal::dds::set(reply->client, client);
    reply->sequence_number = request.sequence_number;
    reply->decision.chosen = -1;
    const auto task = task_of(request);
    auto result = task ? decide(*task) : tl::unexpected(task.error());
    if (result) {
      // the same message as on /colift/decision, by the same way
      const std::string bytes = telemetry::decision_message({0.0, std::move(result->outcome), result->cog_C});
      reply->ok = to_decision(reply->decision, {bytes, hal::Timestamp{0}});
      reply->decision.header.stamp = request.depth.header.stamp;
      hal::dds::set(reply->decision.header.frame_id, text_of(request.depth.header.frame_id));
    } else {
      hal::dds::set(reply->error, result.error().text());
    }
    return dds_write(replies, &*reply) == DDS_RETCODE_OK;
  }
};

DecideServer::DecideServer(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
DecideServer::~DecideServer() = default;

hal::Result<std::unique_ptr<DecideServer>> DecideServer::open(const hal::dds::DdsConfig& config,
                                                              Decide decide) {
  auto impl = std::make_unique<Impl>();
  impl->decide = std::move(decide);
  auto participant = hal::dds::Participant::open(config);
  if (!participant) return tl::unexpected(participant.error());
  impl->participant = std::move(*participant);
  const auto requests =
      impl->participant->reader(kDecideRequests, colift_msgs_msg_dds__DecideRequest__desc, Qos::Reliable);
  if (!requests) return tl::unexpected(requests.error());
  const auto replies =
      impl->participant->writer(kDecideReplies, colift_msgs_msg_dds__DecideReply__desc, Qos::Reliable);
  if (!replies) return tl::unexpected(replies.error());
  impl->requests = *requests, impl->replies = *replies;
  impl->waitset = dds_create_waitset(impl->participant->handle());
  if (impl->waitset < 0 || dds_set_status_mask(impl->requests, DDS_DATA_AVAILABLE_STATUS) != DDS_RETCODE_OK ||
      dds_waitset_attach(impl->waitset, impl->requests, 0) != DDS_RETCODE_OK)
    return hal::failure(hal::ErrorCode::DeviceFault, "ros2.decide", "Cyclone DDS gives no waitset");
  return std::unique_ptr<DecideServer>(new DecideServer(std::move(impl)));
}

int DecideServer::serve(std::chrono::milliseconds timeout) {
  dds_attach_t what = 0;
  (void)dds_waitset_wait(impl_->waitset, &what, 1, std::chrono::nanoseconds(timeout).count());
  const hal::dds::Taken<Request> all(impl_->requests);
  int answered = 0;
  for (int i = 0; i < all.size(); ++i)
    if (const Request* request = all.at(i)) answered += impl_->answer(*request);
  return answered;
}

}  // namespace colift::ros2
