#include <fmt/format.h>
#include <urdf_model/model.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <optional>
#include <sstream>

#include "hal/robot_model/robot_joints.hpp"
#include "hal/robot_model/robot_model.hpp"
#include "hal/robot_model/urdf_text.hpp"
#include "hal/types/symmetric.hpp"

namespace colift::hal {
namespace {

constexpr std::size_t kMaxLinks = 500;

Pose pose_of(const urdf::Pose& pose) {
  Pose X = Pose::Identity();
  double x, y, z, w;
  pose.rotation.getQuaternion(x, y, z, w);
  X.linear() = Eigen::Quaterniond(w, x, y, z).normalized().toRotationMatrix();
  X.translation() = Vec3(pose.position.x, pose.position.y, pose.position.z);
  return X;
}

/// Positive definite, and no principal moment larger than the sum of the others: what a body can have.
bool is_inertia(const Eigen::Matrix3d& inertia) {
  if (!inertia.allFinite()) return false;
  const Vec3 m = small_symmetric_eigen(inertia).values;
  return m[0] > 0.0 && m[0] + m[1] >= m[2] * (1.0 - 1e-3);
}

/// Turns the reader's tree into a RobotModel, and refuses what is no LWR with a BarrettHand.
class RobotBuilder {
 public:
  explicit RobotBuilder(const UrdfText& text) : text_(text) {}

  Result<RobotModel> build() {
    model_.name = text_.model->getName();
    const auto root = text_.model->getRoot();
    if (!root) return at(text_.name, "has no root link");
    if (auto done = add(*root, -1); !done) return tl::unexpected(done.error());
    if (auto done = name_links(); !done) return tl::unexpected(done.error());
    return std::move(model_);
  }

 private:
  static tl::unexpected<Error> at(std::string where, std::string text) {
    return failure(ErrorCode::BadConfig, std::move(where), std::move(text));
  }

  Result<> add(const urdf::Link& source, int parent) {
    const std::string where = text_.place_of_link(source.name);
    if (model_.links.size() == kMaxLinks) return at(where, fmt::format("has more than {} links", kMaxLinks));
    RobotLink link;
    link.name = source.name;
    link.parent = parent;
    if (auto done = read_joint(source, link); !done) return done;
    if (auto done = read_inertia(source, where, link); !done) return done;
    if (auto done = read_shapes(source, where, link); !done) return done;
    const int index = static_cast<int>(model_.links.size());
    model_.links.push_back(std::move(link));
    for (const auto& child : source.child_links) {
      if (auto done = add(*child, index); !done) return done;
    }
    return {};
  }

  Result<> read_joint(const urdf::Link& source, RobotLink& link) const {
    if (!source.parent_joint) return {};
    const urdf::Joint& joint = *source.parent_joint;
    const std::string where = text_.place_of_joint(joint.name);
    link.joint = joint.name;
    link.X_PL0 = pose_of(joint.parent_to_joint_origin_transform);
    if (!link.X_PL0.matrix().allFinite())
      return at(where, fmt::format("joint {}: origin is not finite", joint.name));
    if (joint.type == urdf::Joint::FIXED) return {};
    if (joint.type != urdf::Joint::REVOLUTE) {
      return at(where, fmt::format("joint {} is neither revolute nor fixed", joint.name));
    }
    link.revolute = true;
    link.axis = Vec3(joint.axis.x, joint.axis.y, joint.axis.z);
    if (!(std::abs(link.axis.norm() - 1.0) < 1e-3)) {
      return at(where,
                fmt::format("joint {}: the axis has length {}, expected 1", joint.name, link.axis.norm()));
    }
    link.axis.normalize();
    if (!joint.limits) return at(where, fmt::format("joint {} has no limits", joint.name));
    link.lower_rad = joint.limits->lower;
    link.upper_rad = joint.limits->upper;
    link.velocity_rad_s = joint.limits->velocity;
    link.effort_nm = joint.limits->effort;
    if (!(link.lower_rad < link.upper_rad && std::isfinite(link.upper_rad - link.lower_rad))) {
      return at(where, fmt::format("joint {}: limits are {} to {} rad, expected lower < upper", joint.name,
                                   link.lower_rad, link.upper_rad));
    }
    if (!(link.velocity_rad_s > 0.0 && std::isfinite(link.velocity_rad_s))) {
      return at(where, fmt::format("joint {}: velocity limit is {}, expected more than 0 rad/s", joint.name,
                                   link.velocity_rad_s));
    }
    if (!(link.effort_nm > 0.0 && std::isfinite(link.effort_nm))) {
      return at(where, fmt::format("joint {}: effort limit is {}, expected more than 0 N m", joint.name,
                                   link.effort_nm));
    }
    return {};
  }

  static Result<> read_inertia(const urdf::Link& source, const std::string& where, RobotLink& link) {
    if (!source.inertial) {
      if (!link.revolute) return {};
      return at(where, fmt::format("link {} moves but has no inertial", source.name));
    }
    const urdf::Inertial& in = *source.inertial;
    link.mass_kg = in.mass;
    if (!(in.mass > 0.0 && std::isfinite(in.mass))) {
      return at(where, fmt::format("link {}: mass is {}, expected more than 0 kg", source.name, in.mass));
    }
    const Pose X_LC = pose_of(in.origin);
    link.com_m = X_LC.translation();
    Eigen::Matrix3d inertia;
    inertia << in.ixx, in.ixy, in.ixz, in.ixy, in.iyy, in.iyz, in.ixz, in.iyz, in.izz;
    link.inertia = X_LC.linear() * inertia * X_LC.linear().transpose();
    if (!link.com_m.allFinite() || !is_inertia(link.inertia)) {
      return at(where, fmt::format("link {}: no body has such an inertia", source.name));
    }
    return {};
  }

  static Result<> read_shapes(const urdf::Link& source, const std::string& where, RobotLink& link) {
    for (const auto& collision : source.collision_array) {
      LinkShape shape;
      shape.X_LS = pose_of(collision->origin);
      int sizes = 3;
      const urdf::Geometry* geometry = collision->geometry.get();
      if (!geometry) return at(where, fmt::format("link {}: a collision element has no shape", source.name));
      if (const auto* box = dynamic_cast<const urdf::Box*>(geometry)) {
        shape.kind = LinkShape::Kind::Box;
        shape.size = Vec3(box->dim.x, box->dim.y, box->dim.z);
      } else if (const auto* cylinder = dynamic_cast<const urdf::Cylinder*>(geometry)) {
        shape.kind = LinkShape::Kind::Cylinder;
        shape.size = Vec3(cylinder->radius, cylinder->length, 0.0);
        sizes = 2;
      } else if (const auto* sphere = dynamic_cast<const urdf::Sphere*>(geometry)) {
        shape.kind = LinkShape::Kind::Sphere;
        shape.size = Vec3(sphere->radius, 0.0, 0.0);
        sizes = 1;
      } else {
        return at(where,
                  fmt::format("link {}: a collision shape is a mesh, expected boxes, cylinders or spheres",
                              source.name));
      }
      if (!(shape.size.head(sizes).minCoeff() > 0.0) || !shape.size.allFinite() ||
          !shape.X_LS.matrix().allFinite()) {
        return at(where, fmt::format("link {}: a collision shape has a size that is not more than 0 m",
                                     source.name));
      }
      link.shapes.push_back(shape);
    }
    return {};
  }

  [[nodiscard]] std::optional<int> carried_by(const std::string& joint) const {
    for (std::size_t i = 0; i < model_.links.size(); ++i) {
      if (model_.links[i].joint == joint) return static_cast<int>(i);
    }
    return std::nullopt;
  }

  /// The link that the joint carries; has to hang below `ancestor` with no other joint that moves between.
  Result<int> moving(const std::string& joint, std::optional<int> ancestor, std::size_t slot) {
    const auto link = carried_by(joint);
    if (!link || !model_.links[static_cast<std::size_t>(*link)].revolute) {
      return at(text_.name, fmt::format("revolute joint {} is missing", joint));
    }
    model_.turned_by_[static_cast<std::size_t>(*link)] = static_cast<int>(slot);
    if (auto done = below(*link, ancestor); !done) return tl::unexpected(done.error());
    return *link;
  }

  /// Checks that the nearest joint that moves above `link` is the one that carries `ancestor` (none: the
  /// base).
  Result<> below(int link, std::optional<int> ancestor) const {
    int above = model_.links[static_cast<std::size_t>(link)].parent;
    while (above >= 0 && !model_.links[static_cast<std::size_t>(above)].revolute) {
      above = model_.links[static_cast<std::size_t>(above)].parent;
    }
    if (above == ancestor.value_or(-1)) return {};
    const RobotLink& found = model_.links[static_cast<std::size_t>(link)];
    return at(text_.place_of_link(found.name),
              fmt::format("link {} is carried by {}, expected {}", found.name,
                          above < 0 ? "the base" : model_.links[static_cast<std::size_t>(above)].joint,
                          ancestor ? model_.links[static_cast<std::size_t>(*ancestor)].joint : "the base"));
  }

  Result<int> frame(const std::string& name, int carrier) const {
    for (std::size_t i = 0; i < model_.links.size(); ++i) {
      if (model_.links[i].name != name) continue;
      if (model_.links[i].revolute)
        return at(text_.place_of_link(name), fmt::format("link {} moves, expected fixed", name));
      if (auto done = below(static_cast<int>(i), carrier); !done) return tl::unexpected(done.error());
      return static_cast<int>(i);
    }
    return at(text_.name, fmt::format("link {} is missing", name));
  }

  Result<> name_links() {
    RobotModel& m = model_;
    m.turned_by_.assign(m.links.size(), -1);
    std::optional<int> above;
    for (std::size_t i = 0; i < kArmJoints; ++i) {
      const auto link = moving(fmt::format("arm_{}", i + 1), above, i);
      if (!link) return tl::unexpected(link.error());
      above = m.arm[i] = *link;
    }
    const int a7 = *above;
    for (const auto& [name, slot] :
         {std::pair{"flange", &m.flange}, std::pair{"hand_base", &m.hand_base}, std::pair{"palm", &m.palm}}) {
      const auto link = frame(name, a7);
      if (!link) return tl::unexpected(link.error());
      *slot = *link;
    }
    for (std::size_t f = 0; f < kFingers; ++f) {
      std::optional<int> root = a7;
      if (f < m.spread.size()) {
        const auto spread = moving(fmt::format("finger_{}_spread", f + 1), root, kFirstSpread + f);
        if (!spread) return tl::unexpected(spread.error());
        root = m.spread[f] = *spread;
      }
      const auto inner = moving(fmt::format("finger_{}_inner", f + 1), root, kFirstInner + f);
      if (!inner) return tl::unexpected(inner.error());
      const auto outer = moving(fmt::format("finger_{}_outer", f + 1), *inner, kFirstOuter + f);
      if (!outer) return tl::unexpected(outer.error());
      m.inner[f] = *inner;
      m.outer[f] = *outer;
    }
    for (std::size_t i = 0; i < m.links.size(); ++i) {
      if (m.links[i].revolute && m.turned_by_[i] < 0) {
        return at(text_.place_of_joint(m.links[i].joint),
                  fmt::format("joint {} is none of the arm's or the hand's", m.links[i].joint));
      }
    }
    return find_hand();
  }

  Result<> find_hand() {
    RobotModel& m = model_;
    m.in_hand_.assign(m.links.size(), false);
    for (std::size_t i = 0; i < m.links.size(); ++i) {
      const int parent = m.links[i].parent;
      m.in_hand_[i] = static_cast<int>(i) == m.hand_base || (parent >= 0 && m.in_hand(parent));
    }
    if (!m.in_hand(m.palm)) return at(text_.place_of_link("palm"), "link palm is not part of hand_base");
    for (int i = m.palm; i >= 0; i = m.links[static_cast<std::size_t>(i)].parent) m.palm_chain_.push_back(i);
    m.X_FH = Pose::Identity();
    bool below_flange = false;
    for (const int i : m.palm_chain_) {
      if ((below_flange = i == m.flange)) break;
      m.X_FH = m.links[static_cast<std::size_t>(i)].X_PL0 * m.X_FH;
    }
    if (!below_flange) return at(text_.place_of_link("palm"), "link palm is not fixed to the flange");
    std::reverse(m.palm_chain_.begin(), m.palm_chain_.end());
    return {};
  }

  const UrdfText& text_;
  RobotModel model_;
};

}  // namespace

Result<RobotModel> parse_robot(const std::string& urdf, const std::string& name) {
  const auto text = read_urdf_text(urdf, name);
  if (!text) return tl::unexpected(text.error());
  return RobotBuilder(*text).build();
}

Result<RobotModel> load_robot(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::ostringstream text;
  if (!in || !(text << in.rdbuf())) {
    return failure(ErrorCode::BadInput, file.string(), "cannot be read, expected a URDF file");
  }
  return parse_robot(text.str(), file.string());
}

}  // namespace colift::hal
