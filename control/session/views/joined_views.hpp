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

/// One camera's view of the object.
struct ViewOfObject {
  perception::Target* target = nullptr;
  const perception::OrganisedCloud* cloud = nullptr;
};

/// Centre of gravity of one object by several views, into the first's target: each completes the shape from
/// its own side, and they are averaged by how sure each is. A view that misses a part which another one shows
/// (the arm is before it, or the image ends) does not count; nor does one that takes something for the object
/// where the first sees something else. Where views contradict each other the covariance grows by it.
/// `margin_m`: by which points may lie outside of a completed shape.
void join_cogs(std::span<const ViewOfObject> views, double margin_m);

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
