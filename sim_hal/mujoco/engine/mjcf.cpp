#include "sim_hal/mujoco/engine/mjcf.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <vector>

namespace colift::sim_hal {
namespace {

// Who meets whom: statics meet object and robot, the object meets the robot, fingers meet other fingers. The
// arm does not meet itself: the planner answers for that, and the pairs would cost time in every step.
constexpr int kStatic = 1, kObject = 2, kFinger = 4;
constexpr double kBelowAll_m = -10.0;
constexpr double kPadFriction = 0.5;  // of a pad on anything but the object

using Out = std::back_insert_iterator<std::string>;

std::string placed(const Pose& X) {
  const Eigen::Quaterniond q(X.linear());
  const Vec3& p = X.translation();
  return fmt::format(R"(pos="{:.17g} {:.17g} {:.17g}" quat="{:.17g} {:.17g} {:.17g} {:.17g}")", p.x(), p.y(),
                     p.z(), q.w(), q.x(), q.y(), q.z());
}

std::string inertial(double mass_kg, const Vec3& com, const Eigen::Matrix3d& I) {
  return fmt::format(R"(<inertial pos="{:.17g} {:.17g} {:.17g}" mass="{:.17g}" )"
                     R"(fullinertia="{:.17g} {:.17g} {:.17g} {:.17g} {:.17g} {:.17g}"/>)",
                     com.x(), com.y(), com.z(), mass_kg, I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2),
                     I(1, 2));
}

std::string box_size(const Vec3& full) {
  return fmt::format(R"(type="box" size="{:.17g} {:.17g} {:.17g}")", 0.5 * full.x(), 0.5 * full.y(),
                     0.5 * full.z());
}

std::string cylinder_size(const Vec3& size) {
  return fmt::format(R"(type="cylinder" size="{:.17g} {:.17g}")", size.x(), 0.5 * size.y());
}

std::string sized(const hal::LinkShape& s) {
  switch (s.kind) {
    case hal::LinkShape::Kind::Box:
      return box_size(s.size);
    case hal::LinkShape::Kind::Cylinder:
      return cylinder_size(s.size);
    case hal::LinkShape::Kind::Sphere:
      break;
  }
  return fmt::format(R"(type="sphere" size="{:.17g}")", s.size.x());
}

// Friction that counts before that of geoms without a priority: the scenario's is the object's against
// anything. Turning on the spot is rubbed only where a pad takes part (condim 4): a soft pad is no point.
// Rolling is rubbed where the object is round (condim 6), with a lever of half a millimetre: a pipe on level
// blocks stays.
std::string rubbing(double friction) {
  return fmt::format("priority=\"1\" friction=\"{:.17g} 0.01 0.0005\"", friction);
}

bool is_finger(const hal::RobotModel& model, int link) {
  return std::find(model.inner.begin(), model.inner.end(), link) != model.inner.end() ||
         std::find(model.outer.begin(), model.outer.end(), link) != model.outer.end();
}

void write_link(const hal::RobotModel& model, int index, double friction, Out out) {
  const hal::RobotLink& link = model.links[static_cast<std::size_t>(index)];
  fmt::format_to(out, "<body name=\"L{}\" {}>\n", index, placed(link.X_PL0));
  if (link.mass_kg > 0.0) fmt::format_to(out, "{}\n", inertial(link.mass_kg, link.com_m, link.inertia));
  if (link.revolute) {
    const bool hand = model.in_hand(index);
    // the hand's end stops are those of its gears, which the drives keep
    fmt::format_to(out,
                   "<joint name=\"J{}\" type=\"hinge\" axis=\"{:.17g} {:.17g} {:.17g}\" damping=\"{}\" "
                   "armature=\"{}\" limited=\"{}\" range=\"{:.17g} {:.17g}\"/>\n",
                   index, link.axis.x(), link.axis.y(), link.axis.z(), hand ? 0.05 : 0.5, hand ? 0.002 : 0.1,
                   hand ? "false" : "true", link.lower_rad, link.upper_rad);
  }
  const bool finger = is_finger(model, index);
  for (const hal::LinkShape& shape : link.shapes) {
    fmt::format_to(out, "<geom {} {} contype=\"{}\" conaffinity=\"{}\"", sized(shape), placed(shape.X_LS),
                   finger ? kFinger : 0, kStatic | kObject | (finger ? kFinger : 0));
    // of two geoms with the same priority the greater friction counts: for finger and object the object's
    if (finger) fmt::format_to(out, " {} condim=\"4\"", rubbing(std::min(friction, kPadFriction)));
    fmt::format_to(out, "/>\n");
  }
  for (int child = index + 1; child < static_cast<int>(model.links.size()); ++child) {
    if (model.links[static_cast<std::size_t>(child)].parent == index) write_link(model, child, friction, out);
  }
  fmt::format_to(out, "</body>\n");
}

void write_object(const Scenario& scenario, const ObjectParts& object, Out out) {
  fmt::format_to(out, "<body name=\"{}\" {}>\n<freejoint/>\n{}\n", kObjectBody,
                 placed(object_pose(scenario.object)),
                 inertial(object.mass_kg, object.cog_T, object.inertia_T));
  for (const ObjectParts::Part& part : object.parts) {
    const Shape& s = part.shape;
    const bool round = s.kind != Shape::Kind::Box;
    fmt::format_to(out, "<geom {} {} {} condim=\"{}\" contype=\"{}\" conaffinity=\"{}\"/>\n",
                   round ? cylinder_size(s.size) : box_size(s.size), placed(s.X_WS),
                   rubbing(scenario.object.friction), round ? 6 : 3, kObject, kStatic);
  }
  fmt::format_to(out, "</body>\n");
}

void write_clutter(const Shape& s, const std::string& moved_as, Out out) {
  Pose X_WS = s.X_WS;
  if (!moved_as.empty()) {
    fmt::format_to(out, "<body name=\"{}\" mocap=\"true\" {}>\n", moved_as, placed(s.X_WS));
    X_WS = Pose::Identity();
  }
  fmt::format_to(out, "<geom {} {} contype=\"{}\" conaffinity=\"0\"/>\n",
                 s.kind == Shape::Kind::Box ? box_size(s.size) : cylinder_size(s.size), placed(X_WS),
                 kStatic);
  if (!moved_as.empty()) fmt::format_to(out, "</body>\n");
}

}  // namespace

std::string clutter_body(std::size_t index) {
  return fmt::format("C{}", index);
}

std::string mjcf(const Scenario& scenario, const hal::RobotModel& model, const ObjectParts& object,
                 const std::optional<SupportBlock>& support) {
  std::string xml;
  const Out out(xml);
  fmt::format_to(out, R"(<mujoco model="colift">
<compiler angle="radian" inertiafromgeom="false" balanceinertia="true"/>
<option timestep="0.001" cone="elliptic" impratio="10" noslip_iterations="0" solver="Newton" iterations="50" tolerance="1e-10" integrator="Euler"/>
<size njmax="1000" nconmax="250"/>
<default><geom condim="3" friction="0.8 0.01 0.0005" solref="0.004 1" solimp="0.95 0.99 0.001"/></default>
<worldbody>
<geom type="plane" size="0 0 1" contype="{}" conaffinity="0"/>
)",
                 kStatic);
  const std::vector<Shape> clutter = clutter_shapes(scenario);
  for (std::size_t i = 0; i < clutter.size(); ++i)
    write_clutter(clutter[i], scenario.clutter[i].moves.empty() ? "" : clutter_body(i), out);
  for (int link = 0; link < static_cast<int>(model.links.size()); ++link) {
    if (model.links[static_cast<std::size_t>(link)].parent < 0)
      write_link(model, link, scenario.object.friction, out);
  }
  write_object(scenario, object, out);
  if (support) {
    Pose X = Pose::Identity();
    X.linear() = Eigen::AngleAxisd(support->yaw_rad, Vec3::UnitZ()).toRotationMatrix();
    X.translation() = support->center_W + Vec3(0.0, 0.0, kBelowAll_m);
    fmt::format_to(
        out, "<body name=\"{}\" mocap=\"true\" {}>\n<geom {} contype=\"{}\" conaffinity=\"0\"/>\n</body>\n",
        kSupportBody, placed(X), box_size(support->size), kStatic);
  }
  fmt::format_to(out, "</worldbody>\n</mujoco>\n");
  return xml;
}

}  // namespace colift::sim_hal
