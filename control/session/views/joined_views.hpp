#pragma once

#include <span>
#include <vector>

#include "control/session/views/camera_view.hpp"
#include "perception/bodies/body_finder.hpp"

namespace colift::control {

/// What one camera's newest frame shows of the partner. `camera`: 0 is the first.
struct ViewOfPartner {
  std::size_t camera = 0;
  PartnerSighting sighting;
};

/// What all cameras together show of the partner; the first of `views` leads. A hand that only one shows is
/// seen; contacts of the same hand are averaged by their covariances. His hand is hidden, or an edge of the
/// object, where no view shows it. Needs at least one view.
[[nodiscard]] PartnerSighting join_sightings(std::span<const ViewOfPartner> views, double same_hand_m);

/// Centre of gravity of one object by several views, into the first: each completes the shape from its own
/// side. Views whose shape does not hold what the others show of the object, up to `covered_m`, see a part of
/// it (the arm is before the rest) and do not count; of the rest the mean, by how sure each is. Where they
/// differ by more than their covariances explain, or none is whole, the covariance grows by it.
void join_cogs(std::span<perception::Target* const> targets, double covered_m);

/// What one camera shows of the bodies in the room.
struct ViewOfBodies {
  std::span<const perception::Body> bodies;
  std::span<const perception::BodyPoint> points;  ///< Body::first and count refer to them.
};

/// Bodies of several views in one list: those whose boxes are at most `same_body_m` apart in two views are
/// one body with the points of both. Keeps its buffers. One thread.
class JoinedBodies {
 public:
  /// Largest first; valid until the next call.
  std::span<const perception::Body> join(std::span<const ViewOfBodies> views, double same_body_m);
  [[nodiscard]] std::span<const perception::BodyPoint> points() const { return points_; }

 private:
  struct Part {
    std::size_t view;
    const perception::Body* body;
    std::size_t group;
  };
  std::vector<Part> parts_;
  std::vector<perception::Body> bodies_;
  std::vector<perception::BodyPoint> points_;
};

}  // namespace colift::control
