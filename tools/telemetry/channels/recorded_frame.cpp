#include "tools/telemetry/channels/recorded_frame.hpp"

#include <limits>
#include <utility>

#include "tools/telemetry/channels/channels.hpp"
#include "tools/telemetry/channels/depth_cdt1.hpp"
#include "tools/telemetry/channels/image_message.hpp"
#include "tools/telemetry/channels/json_parts.hpp"

namespace colift::telemetry {
namespace {

constexpr int kMaxSide = 8192;

tl::unexpected<hal::Error> damaged(const char* what) {
  return hal::failure(hal::ErrorCode::BadInput, "depth frame", what);
}

double number(const Json& j) {
  return j.is_null() ? std::numeric_limits<double>::quiet_NaN() : j.get<double>();
}

/// Everything but the pixels. Throws Json's own exception.
NumberedFrame fields_of(const Json& j) {
  NumberedFrame out;
  out.number = j.at("number").get<std::uint64_t>();
  hal::DepthFrame& f = out.frame;
  f.exposed_at = hal::Timestamp(j.at("exposed_at").get<std::int64_t>());
  hal::CameraIntrinsics& c = f.intrinsics;
  c.width = j.at("width").get<int>(), c.height = j.at("height").get<int>();
  c.fx = number(j.at("fx")), c.fy = number(j.at("fy")), c.cx = number(j.at("cx")), c.cy = number(j.at("cy"));
  if (const Json& up = j.at("up"); !up.is_null())
    f.up_C = hal::Vec3(number(up.at(0)), number(up.at(1)), number(up.at(2)));
  return out;
}

hal::Result<NumberedFrame> described(std::string_view message) {
  const Json j = Json::parse(message, nullptr, false);
  if (j.is_discarded()) return damaged("is described by what is no JSON");
  try {
    return fields_of(j);
  } catch (const Json::exception&) {
    return damaged("is described incompletely");
  }
}

}  // namespace

std::string frame_message(std::uint64_t number, const hal::DepthFrame& f) {
  const hal::CameraIntrinsics& c = f.intrinsics;
  return dumped({{"number", number},
                 {"exposed_at", f.exposed_at.count()},
                 {"width", c.width},
                 {"height", c.height},
                 {"fx", number_json(c.fx)},
                 {"fy", number_json(c.fy)},
                 {"cx", number_json(c.cx)},
                 {"cy", number_json(c.cy)},
                 {"up", f.up_C ? list_of(*f.up_C) : Json(nullptr)}});
}

hal::Result<NumberedFrame> decode_frame(const EncodedFrame& encoded) {
  if (is_cdt1(encoded.depth)) return decode_cdt1(encoded.depth);
  auto out = described(encoded.about);
  if (!out) return out;
  hal::DepthFrame& f = out->frame;
  if (f.intrinsics.width < 1 || f.intrinsics.height < 1 || f.intrinsics.width > kMaxSide ||
      f.intrinsics.height > kMaxSide)
    return damaged("has an impossible size");
  const auto image = parse_image(encoded.depth);
  if (!image) return tl::unexpected(image.error());
  if (image->stamp != f.exposed_at) return damaged("has an image of another time");
  auto depth_m = depth_of(*image);
  if (!depth_m) return tl::unexpected(depth_m.error());
  f.depth_m = std::move(*depth_m);
  if (!encoded.colour.empty()) {
    const auto colour = parse_image(encoded.colour);
    if (!colour) return tl::unexpected(colour.error());
    f.rgb.assign(colour->data.begin(), colour->data.end());
  }
  return out;
}

std::optional<EncodedFrame> FrameJoiner::add(std::string_view topic, std::string_view message) {
  const bool of_others = topic == channel_of(Topic::MoreFrame).topic;
  if (of_others || topic == channel_of(Topic::Frame).topic) {
    auto& next = of_others ? next_of_others_ : next_;
    next.reset();
    if (const auto about = described(message))
      next = EncodedFrame{about->number, std::string(message), {}, {}};
  } else if (topic == channel_of(Topic::MoreDepth).topic) {
    if (!next_of_others_) return std::nullopt;
    next_of_others_->depth = message;
    return std::exchange(next_of_others_, std::nullopt);
  } else if (topic == channel_of(Topic::Colour).topic) {
    if (next_) next_->colour = message;
  } else if (topic == channel_of(Topic::Depth).topic) {
    if (const auto number = cdt1_number(message)) return EncodedFrame{*number, {}, {}, std::string(message)};
    if (next_) {
      next_->depth = message;
      return std::exchange(next_, std::nullopt);
    }
  }
  return std::nullopt;
}

}  // namespace colift::telemetry
