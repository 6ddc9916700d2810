#include "planner/motion/collision/exact_checker.hpp"

#include <fcl/fcl.h>
#include <octomap/octomap.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "planner/motion/collision/collision_scene.hpp"
#include "planner/motion/collision/collision_spheres.hpp"

namespace colift::planner {
namespace {

using hal::LinkShape;
using hal::Pose;
using hal::Vec3;
using With = Touch::With;
using Object = fcl::CollisionObjectd;

std::shared_ptr<fcl::CollisionGeometryd> primitive(const LinkShape& shape) {
  const Vec3& s = shape.size;
  switch (shape.kind) {
    case LinkShape::Kind::Box:
      return std::make_shared<fcl::Boxd>(s.x(), s.y(), s.z());
    case LinkShape::Kind::Cylinder:
      return std::make_shared<fcl::Cylinderd>(s.x(), s.y());
    case LinkShape::Kind::Sphere:
      break;
  }
  return std::make_shared<fcl::Sphered>(s.x());
}

/// How far a shape reaches against a direction, from its middle.
double reach_down(const LinkShape& shape, const Vec3& up_S) {
  const Vec3& s = shape.size;
  switch (shape.kind) {
    case LinkShape::Kind::Box:
      return 0.5 * up_S.cwiseAbs().dot(s);
    case LinkShape::Kind::Cylinder:
      return s.x() * up_S.head<2>().norm() + 0.5 * s.y() * std::abs(up_S.z());
    case LinkShape::Kind::Sphere:
      break;
  }
  return s.x();
}

/// A shape of the robot as FCL sees it.
struct Part {
  int link = 0, body = 0;
  LinkShape shape;
  Object object;
};

std::shared_ptr<fcl::OcTreed> as_geometry(std::shared_ptr<octomap::OcTree> tree) {
  tree->updateInnerOccupancy();
  tree->prune();
  return std::make_shared<fcl::OcTreed>(tree);
}

bool collide(const Object& a, const Object& b) {
  if (!a.getAABB().overlap(b.getAABB())) return false;
  fcl::CollisionRequestd request;
  fcl::CollisionResultd result;
  return fcl::collide(&a, &b, request, result) > 0;
}

}  // namespace

struct ExactChecker::Impl {
  hal::RobotModel model;
  hal::Plane ground;
  hal::HandPosture hand;
  Contacts contacts = Contacts::None;
  Pose X_WH_before = Pose::Identity();
  std::vector<Part> parts;
  std::vector<std::pair<std::size_t, std::size_t>> pairs;
  std::unique_ptr<Object> obstacles, target;
  std::vector<Pose> X_WL;

  void make_parts() {
    const std::vector<int> body = arm_body(model);
    for (std::size_t l = 0; l < model.links.size(); ++l) {
      for (const LinkShape& shape : model.links[l].shapes) {
        parts.push_back({static_cast<int>(l), body[l], shape, Object(primitive(shape))});
      }
    }
    // by structure, not by FastChecker's samples: all that may meet are asked
    for (std::size_t a = 0; a < parts.size(); ++a) {
      for (std::size_t b = a + 1; b < parts.size(); ++b) {
        if (may_meet(model, body, parts[a].link, parts[b].link)) pairs.emplace_back(a, b);
      }
    }
  }

  void make_world(const perception::WorldMap& map) {
    const perception::CellGrid& grid = map.grid();
    const octomap::OcTree& all = map.tree();
    auto scene = std::make_shared<octomap::OcTree>(all.getResolution());
    for (auto leaf = all.begin_leafs(), end = all.end_leafs(); leaf != end; ++leaf) {
      if (!all.isNodeOccupied(*leaf)) continue;
      // pruned leaves are taken apart: the ground may cut through them
      const int n = 1 << (all.getTreeDepth() - leaf.getDepth());
      const Vec3 corner = Vec3(leaf.getX(), leaf.getY(), leaf.getZ()) - Vec3::Constant(0.5 * leaf.getSize());
      for (int i = 0; i < n * n * n; ++i) {
        const Vec3 middle = corner + grid.cell_m * Vec3(i % n + 0.5, i / n % n + 0.5, i / n / n + 0.5);
        if (ground.height(middle) < kGroundCells * grid.cell_m) continue;
        scene->updateNode(middle.x(), middle.y(), middle.z(), true, true);
      }
    }
    auto object = std::make_shared<octomap::OcTree>(all.getResolution());
    for (const Vec3& p : map.target_cells()) object->updateNode(p.x(), p.y(), p.z(), true, true);
    if (scene->size() > 0) obstacles = std::make_unique<Object>(as_geometry(scene));
    if (object->size() > 0) target = std::make_unique<Object>(as_geometry(object));
  }

  [[nodiscard]] bool meets_target(const Part& part) const {
    return contacts == Contacts::None || !model.in_hand(part.link);
  }

  void place(const hal::JointVector& q_rad) {
    hal::link_poses(model, q_rad, hand, X_WL);
    for (Part& part : parts) {
      part.object.setTransform(X_WL[static_cast<std::size_t>(part.link)] * part.shape.X_LS);
      part.object.computeAABB();
    }
    if (!target) return;
    target->setTransform(contacts == Contacts::Carrying
                             ? X_WL[static_cast<std::size_t>(model.palm)] * X_WH_before.inverse()
                             : Pose::Identity());
    target->computeAABB();
  }

  [[nodiscard]] Touch touch(With with, const Part& part, double depth_m = 0.0) const {
    return {with, model.links[static_cast<std::size_t>(part.link)].name, depth_m};
  }

  [[nodiscard]] Touch check(const hal::JointVector& q_rad);
};

Touch ExactChecker::Impl::check(const hal::JointVector& q_rad) {
  const hal::JointVector lower = model.lower_rad(), upper = model.upper_rad();
  for (int i = 0; i < hal::kArmJoints; ++i) {
    const double beyond = std::max(lower[i] - q_rad[i], q_rad[i] - upper[i]);
    if (beyond <= 1e-6) continue;
    const auto link = static_cast<std::size_t>(model.arm[static_cast<std::size_t>(i)]);
    return {With::Limits, model.links[link].joint, beyond};
  }
  place(q_rad);
  for (const Part& part : parts) {
    if (part.body == 0) continue;
    if (part.body > 1) {
      const Pose X_WS = X_WL[static_cast<std::size_t>(part.link)] * part.shape.X_LS;
      const double height = ground.height(X_WS.translation()) -
                            reach_down(part.shape, X_WS.linear().transpose() * ground.normal);
      if (height < 0.0) return touch(With::Ground, part, -height);
    }
    if (obstacles && collide(part.object, *obstacles)) return touch(With::Obstacle, part);
    if (target && meets_target(part) && collide(part.object, *target)) return touch(With::Target, part);
  }
  for (const auto& [a, b] : pairs) {
    if (!collide(parts[a].object, parts[b].object)) continue;
    Touch met = touch(With::Itself, parts[a]);
    met.part += " and " + model.links[static_cast<std::size_t>(parts[b].link)].name;
    return met;
  }
  return {};
}

ExactChecker::ExactChecker(const hal::RobotModel& model, const perception::WorldMap& map,
                           const hal::Plane& ground)
    : impl_(std::make_unique<Impl>()) {
  impl_->model = model;
  impl_->ground = ground;
  impl_->make_parts();
  impl_->make_world(map);
}
ExactChecker::~ExactChecker() = default;
ExactChecker::ExactChecker(ExactChecker&&) noexcept = default;

void ExactChecker::set_hand(const hal::HandPosture& hand) {
  impl_->hand = hand;
}

void ExactChecker::allow(Contacts contacts) {
  impl_->contacts = contacts;
}

void ExactChecker::set_carry_origin(const hal::Pose& X_WH) {
  impl_->X_WH_before = X_WH;
}

Touch ExactChecker::what_touches(const hal::JointVector& q_rad) {
  return impl_->check(q_rad);
}

}  // namespace colift::planner
