#pragma once

#include <limits>
#include <optional>
#include <string>

#include "perception/scene.hpp"
#include "perception/target/outline.hpp"
#include "perception/target/regions/fragments.hpp"
#include "perception/target/regions/silhouette.hpp"
#include "perception/target/target_config.hpp"

namespace colift::perception {

/// Something above the ground that was not chosen, and why.
struct RejectedObject {
  enum class Kind { Small, Flat, Far, Person, Cut, Wall, Lesser, Floating, Large, Attached, Unsure };
  Kind kind = Kind::Small;
  Vec3 center = Vec3::Zero();  ///< Middle of its box in W (m).
  std::size_t pixels = 0;
  std::string reason;
  bool whole = false;  ///< It stands alone, as a person does: nothing is cut out of it.
  double away_m = std::numeric_limits<double>::infinity();  ///< From the point that was given, if any.
};

/// The side of the view that takes the largest part of an object's extent along it.
struct SideCut {
  double fraction = 0.0;
  const char* side = "";
};
[[nodiscard]] SideCut lateral_cut(const Fragment& object);

/// Part of an object's upper side that the view cuts; its footprint may still be whole.
[[nodiscard]] double top_cut(const Fragment& object);

/// What the size, place and rim of an object say against it as a target; nothing for a free-standing one.
[[nodiscard]] std::optional<RejectedObject> object_to(const Fragment& object, const TargetConfig& config);

/// What the bulk of an object says against it: it is closed down to the ground and too large to be carried.
[[nodiscard]] std::optional<RejectedObject> object_to_bulk(const OrganisedCloud& cloud,
                                                           const Components& components,
                                                           const Fragment& object,
                                                           const Silhouette& silhouette, const Ground& ground,
                                                           const TargetConfig& config);

/// What the outline says against an object: a part of something larger goes on beyond it.
[[nodiscard]] std::optional<RejectedObject> object_to_outline(const Fragment& object, const Outline& outline,
                                                              const TargetConfig& config);

}  // namespace colift::perception
