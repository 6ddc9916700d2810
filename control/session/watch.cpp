#include "control/session/watch.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "perception/ground_and_target/slivers.hpp"
#include "perception/motion/moved_object.hpp"
#include "perception/reference_image.hpp"
#ifdef COLIFT_THESIS
#include "perception/thesis/thesis_partner.hpp"
#include "perception/thesis/thesis_target.hpp"
#endif

namespace colift::control {
namespace {

using perception::PartnerKind;

// The thesis's chain takes some 0.3 s a frame with voxels of 5 mm: at 30 frames a second it gets every tenth,
// the others say nothing.
constexpr int kThesisEvery = 10;
constexpr double kThesisBeside_m = 0.3;  // of the object's box: farther away nobody is looked for

bool shows_anything(const hal::DepthFrame& frame) {
  if (frame.depth_m.size() !=
      static_cast<std::size_t>(frame.intrinsics.width) * static_cast<std::size_t>(frame.intrinsics.height))
    return false;
  return std::any_of(frame.depth_m.begin(), frame.depth_m.end(), [](float d) { return d > 0.0f; });
}

}  // namespace

struct Watch::Impl {
  Impl(Method m, const Config& c, const RigView& r, const hal::Clock& s)
      : method(m), config(c), rig(r), stopwatch(s), map(c.map), tracker(c.tracker) {}

  Method method;
  const Config& config;
  RigView rig;
  const hal::Clock& stopwatch;

  std::vector<hal::DepthFrame> frames;
  std::optional<hal::DepthFrame> with_robot;  ///< The first of them, before the robot was taken out.
  RobotPosture robot_then;
  std::optional<perception::SelfFilter> filter;
  Look look;
  perception::WorldMap map;
  std::optional<perception::PartnerFinder> finder;
  std::optional<perception::ObjectFollower> follower;
  perception::PartnerTracker tracker;
  std::vector<Eigen::Vector3f> partner_points;
#ifdef COLIFT_THESIS
  perception::PclCloud thesis_before;
  perception::ThesisConfig thesis_near;  ///< Passes what lies around the object only.
#endif
  int thesis_frames = 0;
  std::vector<char> robot_hid;             ///< By pixel, in any frame of the reference.
  std::vector<std::uint32_t> never_seen;   ///< Pixels that showed the robot or lay in its shadow then.
  perception::PartnerSighting last_sight;  ///< Of the thesis's method.

  // the robot's own pixels are nobody's
  const std::vector<std::uint32_t>& hide_robot(hal::DepthFrame& frame, const RobotPosture& robot) {
    if (!filter) filter.emplace(rig.model, frame.intrinsics, rig.X_WC, config.noise, config.self_filter);
    return filter->remove(frame, robot.q_rad, robot.hand);
  }

  hal::Result<> take_look(const perception::ReferenceImage& reference, hal::DepthFrame frame) {
    LookInput input;
    input.frame = std::move(frame);
    input.frame.depth_m = reference.cloud.depth_m;
    input.X_WC = rig.X_WC;
    input.base_frame_known = true;
    auto seen = control::look(std::move(input), method, config, rig.hand, stopwatch, rig.hand_tables);
    if (!seen) return tl::unexpected(seen.error());
    look = std::move(*seen);
    return {};
  }

  hal::Result<> make_rest(const perception::ReferenceImage& reference, const RobotPosture& robot) {
    if (!look.scene.target || !look.scene.ground) return {};
    if (auto made = make_finders(reference); !made) return made;
    make_map(robot);
    return {};
  }

  [[nodiscard]] std::vector<std::uint32_t> slivers() const {
    return perception::find_slivers(look.cloud, *look.scene.target, *look.scene.ground, config.noise,
                                    config.target.slivers);
  }

  /// Of the target and of the slivers that go where it goes, ascending.
  [[nodiscard]] std::vector<std::uint32_t> target_pixels(const std::vector<std::uint32_t>& slivers) const {
    std::vector<std::uint32_t> pixels = look.scene.target->pixels;
#ifdef COLIFT_THESIS
    if (method == Method::Thesis)
      pixels = perception::thesis_pixels(look.cloud, *look.scene.target, config.thesis);
#endif
    const auto own = static_cast<std::ptrdiff_t>(pixels.size());
    pixels.insert(pixels.end(), slivers.begin(), slivers.end());
    std::inplace_merge(pixels.begin(), pixels.begin() + own, pixels.end());
    return pixels;
  }

  hal::Result<> make_finders(const perception::ReferenceImage& reference) {
    const auto& target = *look.scene.target;
    if (method == Method::Fast) {
      auto made = perception::PartnerFinder::make(reference, target, *look.scene.ground, config.noise,
                                                  config.partner);
      if (!made) return tl::unexpected(made.error());
      finder.emplace(std::move(*made));
      auto followed = perception::ObjectFollower::make(reference, target, config.noise, config.object_motion);
      if (!followed) return tl::unexpected(followed.error());
      follower.emplace(std::move(*followed));
    }
#ifdef COLIFT_THESIS
    if (method == Method::Thesis) {
      thesis_near = config.thesis;
      const hal::Vec3 beside = hal::Vec3::Constant(kThesisBeside_m);
      thesis_near.crop_min_m = config.thesis.crop_min_m.cwiseMax(target.aabb.min() - beside);
      thesis_near.crop_max_m = config.thesis.crop_max_m.cwiseMin(target.aabb.max() + beside);
      thesis_before = perception::thesis_cloud(look.cloud, thesis_near);
      perception::Target seen = target;
      seen.pixels = perception::thesis_pixels(look.cloud, target, config.thesis);
      auto followed = perception::ObjectFollower::make(reference, seen, config.noise, config.object_motion);
      if (!followed) return tl::unexpected(followed.error());
      follower.emplace(std::move(*followed));
      find_never_seen();
    }
#endif
    return {};
  }

  // What the robot hid from the reference and uncovers later is new to a difference of clouds, though nothing
  // has changed there. Where the projector's light did not come past it there is no depth beside it in the
  // row.
  void find_never_seen() {
    never_seen.clear();
    const auto width = static_cast<std::size_t>(look.cloud.width());
    if (width == 0 || robot_hid.size() != look.cloud.depth_m.size()) return;
    for (std::size_t row = 0; row < robot_hid.size(); row += width) {
      for (std::size_t i = row; i < row + width;) {
        std::size_t end = i;
        bool by_robot = false;
        const auto dark = [&](std::size_t p) { return robot_hid[p] != 0 || !(look.cloud.depth_m[p] > 0.0f); };
        for (; end < row + width && dark(end); ++end) by_robot = by_robot || robot_hid[end] != 0;
        for (; by_robot && i < end; ++i) never_seen.push_back(static_cast<std::uint32_t>(i));
        i = end + 1;
      }
    }
  }

  hal::Result<perception::PartnerSighting> sight_fast(const hal::DepthFrame& frame) {
    const perception::OrganisedCloud cloud = perception::deproject(frame, rig.X_WC);
    auto sighting = finder->find(cloud);
    if (!sighting) return sighting;
    partner_points.clear();
    for (const std::uint32_t p : sighting->pixels)
      partner_points.emplace_back(cloud.x[p], cloud.y[p], cloud.z[p]);
    return sighting;
  }

  void make_map(const RobotPosture& robot) {
    const std::vector<std::uint32_t> own_slivers = slivers();
    map = perception::WorldMap(config.map);
    map.insert(look.cloud, target_pixels(own_slivers));
    map.carve_robot(rig.model, robot.q_rad, robot.hand);
    std::vector<hal::Vec3> points;
    points.reserve(look.scene.target->points.size() + own_slivers.size());
    for (const auto& p : look.scene.target->points) points.emplace_back(p.cast<double>());
    for (const std::uint32_t i : own_slivers) points.push_back(look.cloud.point(i));
    map.set_target(points);
  }

  hal::Result<perception::PartnerSighting> sight_thesis([[maybe_unused]] hal::DepthFrame& frame) {
#ifdef COLIFT_THESIS
    perception::PartnerSighting sighting;
    for (const std::uint32_t p : never_seen)
      if (p < frame.depth_m.size()) frame.depth_m[p] = NAN;
    const auto now = perception::thesis_cloud(perception::deproject(frame, rig.X_WC), thesis_near);
    const auto changed = perception::changed_points(thesis_before, now, thesis_near);
    sighting.grasp =
        perception::thesis_grasp(changed, look.scene.target->points, thesis_near, &sighting.because);
    sighting.kind = sighting.grasp ? PartnerKind::Grasp : PartnerKind::None;
    partner_points.clear();
    if (sighting.grasp) partner_points = perception::thesis_person(changed, *sighting.grasp, config.thesis);
    return sighting;
#else
    return hal::failure(hal::ErrorCode::BadConfig, "method",
                        "this build has no thesis method (COLIFT_THESIS=OFF)");
#endif
  }
};

Watch::Watch(Method method, const Config& config, const RigView& rig, const hal::Clock& stopwatch)
    : impl_(std::make_unique<Impl>(method, config, rig, stopwatch)) {}
Watch::~Watch() = default;

void Watch::add_reference(hal::DepthFrame frame, const RobotPosture& robot) {
  if (!shows_anything(frame)) return;
  if (impl_->frames.empty() && impl_->config.pose_check.on) {
    impl_->with_robot = frame;
    impl_->robot_then = robot;
  }
  const auto& hidden = impl_->hide_robot(frame, robot);
  if (impl_->frames.empty()) impl_->robot_hid.assign(frame.depth_m.size(), 0);
  for (const std::uint32_t p : hidden)
    if (p < impl_->robot_hid.size()) impl_->robot_hid[p] = 1;
  impl_->frames.push_back(std::move(frame));
}

int Watch::reference_frames() const {
  return static_cast<int>(impl_->frames.size());
}

void Watch::forget_reference() {
  impl_->frames.clear();
}

hal::Result<> Watch::understand(const RobotPosture& robot) {
  Impl& i = *impl_;
  const auto reference =
      perception::build_reference(i.frames, i.rig.X_WC, i.config.noise, i.config.partner.reference);
  if (!reference) return tl::unexpected(reference.error());

  if (auto seen = i.take_look(*reference, i.frames.back()); !seen) return seen;
  i.frames.clear();
  if (i.with_robot) {
    std::optional<hal::Plane> ground;
    if (i.look.scene.ground) ground = i.look.scene.ground->plane;
    const auto check = perception::check_pose(*i.with_robot, i.rig.X_WC, ground, i.rig.model,
                                              i.robot_then.q_rad, i.robot_then.hand, i.config.pose_check);
    i.with_robot.reset();
    if (!check.good) return hal::failure(hal::ErrorCode::BadConfig, kCameraOff, check.because);
  }
  return i.make_rest(*reference, robot);
}

hal::Result<> Watch::object_moved(const hal::Pose& X, const RobotPosture& robot) {
  Impl& i = *impl_;
  if (!i.look.scene.target || !i.look.scene.ground)
    return hal::failure(hal::ErrorCode::NotFound, "watch", "there is no object");
  const hal::DepthFrame moved =
      perception::move_object(i.look.cloud, i.target_pixels(i.slivers()), X, i.config.object_motion.moved);
  const auto reference =
      perception::build_reference({&moved, 1}, i.rig.X_WC, i.config.noise, i.config.partner.reference);
  if (!reference) return tl::unexpected(reference.error());
  if (auto seen = i.take_look(*reference, i.look.frame); !seen) return seen;
  forget_partner();
  return i.make_rest(*reference, robot);
}

const Look& Watch::look() const {
  return impl_->look;
}
Look& Watch::look() {
  return impl_->look;
}
const perception::WorldMap& Watch::map() const {
  return impl_->map;
}

hal::Result<Sight> Watch::watch_partner(hal::DepthFrame frame, const RobotPosture& robot) {
  Impl& i = *impl_;
  Sight out;
  const hal::Timestamp start = i.stopwatch.now();
  if (i.method == Method::Thesis && i.thesis_frames++ % kThesisEvery != 0) {
    out.partner = i.last_sight;
    return out;
  }
  i.hide_robot(frame, robot);
  const hal::Timestamp at = frame.exposed_at;
  auto sighting = i.method == Method::Fast ? i.sight_fast(frame) : i.sight_thesis(frame);
  if (!sighting) return tl::unexpected(sighting.error());
  if (i.method == Method::Thesis) i.last_sight = *sighting;
  // a scene that moved says nothing about hands
  if (sighting->kind != PartnerKind::ObjectMoved) out.event = i.tracker.update(at, *sighting);
  out.partner = std::move(*sighting);
  out.compute_ms = 1e3 * hal::seconds(i.stopwatch.now() - start);
  return out;
}

std::optional<perception::PartnerEvent> Watch::no_frame(hal::Timestamp now) {
  return impl_->tracker.tick(now);
}
void Watch::looked_away(hal::Duration how_long) {
  impl_->tracker.looked_away(how_long);
}
const perception::PartnerTracker& Watch::tracker() const {
  return impl_->tracker;
}
void Watch::forget_partner() {
  impl_->tracker = perception::PartnerTracker(impl_->config.tracker);
}
const std::vector<Eigen::Vector3f>& Watch::partner_points() const {
  return impl_->partner_points;
}

std::optional<perception::ObjectMotion> Watch::watch_object(hal::DepthFrame frame,
                                                            const RobotPosture& robot) {
  Impl& i = *impl_;
  if (!i.follower || !shows_anything(frame)) return std::nullopt;
  i.hide_robot(frame, robot);
  return i.follower->update(perception::deproject(frame, i.rig.X_WC));
}
void Watch::object_stands_again() {
  if (impl_->follower) impl_->follower->start_again();
}

}  // namespace colift::control
