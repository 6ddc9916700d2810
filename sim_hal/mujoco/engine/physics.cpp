#include "sim_hal/mujoco/engine/physics.hpp"

#include <fmt/format.h>
#include <mujoco/mujoco.h>

#include <algorithm>
#include <cstring>
#include <vector>

#include "sim_hal/mujoco/engine/cylinder_contact.hpp"
#include "sim_hal/mujoco/engine/mjcf.hpp"

namespace colift::sim_hal {
namespace {

enum class Kind { Static, Support, Object, Arm, Palm, Finger, Person };

/// What a body of the model is.
struct BodyRole {
  Kind kind = Kind::Static;
  int finger = -1;
  bool outer = false;
};

struct Freed {
  void operator()(mjModel* m) const { mj_deleteModel(m); }
  void operator()(mjData* d) const { mj_deleteData(d); }
};
using Model = std::unique_ptr<mjModel, Freed>;

/// MuJoCo would write MUJOCO_LOG.TXT into the working directory. Set once: trials of an experiment make and
/// step worlds in several threads, and all of them read it.
void silence_mujoco() {
  static const bool done = [] {
    mju_user_warning = [](const char*) {};
    return true;
  }();
  static_cast<void>(done);
}

hal::Result<Model> load(const std::string& xml) {
  silence_mujoco();
  const auto files = std::make_unique<mjVFS>();
  mj_defaultVFS(files.get());
  mj_makeEmptyFileVFS(files.get(), "colift.xml", static_cast<int>(xml.size()));
  const auto at = static_cast<std::size_t>(mj_findFileVFS(files.get(), "colift.xml"));
  std::memcpy(files->filedata[at], xml.data(), xml.size());
  std::array<char, 500> error{};
  Model model(mj_loadXML("colift.xml", files.get(), error.data(), static_cast<int>(error.size())));
  mj_deleteVFS(files.get());
  if (!model) return hal::failure(hal::ErrorCode::BadConfig, "simulation", error.data());
  return model;
}

Eigen::Map<const Vec3> vec(const mjtNum* p) {
  return Eigen::Map<const Vec3>(p);
}

Pose pose(const mjtNum* position, const mjtNum* quaternion) {
  Pose X = Pose::Identity();
  X.translation() = vec(position);
  X.linear() = Eigen::Quaterniond(quaternion[0], quaternion[1], quaternion[2], quaternion[3]).matrix();
  return X;
}

}  // namespace

struct Physics::Impl {
  Model model;
  std::unique_ptr<mjData, Freed> data;
  std::vector<int> link_body;
  std::vector<BodyRole> roles;  // of each body
  std::array<int, hal::kArmJoints> arm_joint{}, arm_dof{}, arm_qpos{};
  std::array<int, hal::kFingers> inner_joint{}, outer_joint{};
  std::array<int, 2> spread_joint{};
  int object_body = -1, palm_body = -1, support_body = -1, object_qpos = 0, object_dof = 0;
  ContactReading contacts;
  /// What people do to links in this step, and to all joints together.
  struct Push {
    BodyRole role;
    Vec3 at_W, force_W;
    double normal_n;
  };
  std::vector<Push> pushes;
  Eigen::VectorXd pushed_nm;
  hal::JointVector external_nm = hal::JointVector::Zero();

  void index(const hal::RobotModel& robot);
  [[nodiscard]] int joint(int link) const {
    return mj_name2id(model.get(), mjOBJ_JOINT, fmt::format("J{}", link).c_str());
  }
  [[nodiscard]] double q(int joint_id) const { return data->qpos[model->jnt_qposadr[joint_id]]; }
  [[nodiscard]] double dq(int joint_id) const { return data->qvel[model->jnt_dofadr[joint_id]]; }
  void torque(int joint_id, double nm) { data->qfrc_applied[model->jnt_dofadr[joint_id]] = nm; }
  [[nodiscard]] const BodyRole& role_of_geom(int geom) const {
    return roles[static_cast<std::size_t>(model->geom_bodyid[geom])];
  }
  void read_contacts();
  void push(int body, const Vec3& at_W, const Vec3& force_W);
  [[nodiscard]] Vec3 velocity_W(int body, const Vec3& at_W) const {
    std::array<mjtNum, 6> turning_and_linear{};
    mj_objectVelocity(model.get(), data.get(), mjOBJ_BODY, body, turning_and_linear.data(), 0);
    return vec(turning_and_linear.data() + 3) +
           vec(turning_and_linear.data()).cross(at_W - vec(data->xpos + 3 * body));
  }
  void add_finger_contact(const BodyRole& role, const BodyRole& other, const Vec3& p, const Vec3& force,
                          const Vec3& torque_W, double normal_n);
  [[nodiscard]] hal::JointVector external() const;
};

void Physics::Impl::index(const hal::RobotModel& robot) {
  const mjModel* m = model.get();
  roles.resize(static_cast<std::size_t>(m->nbody));
  for (int link = 0; link < static_cast<int>(robot.links.size()); ++link) {
    const int body = mj_name2id(m, mjOBJ_BODY, fmt::format("L{}", link).c_str());
    link_body.push_back(body);
    roles[static_cast<std::size_t>(body)].kind = robot.in_hand(link) ? Kind::Palm : Kind::Arm;
  }
  const auto as_finger = [&](int link, int finger, bool outer) {
    roles[static_cast<std::size_t>(link_body[static_cast<std::size_t>(link)])] = {Kind::Finger, finger,
                                                                                  outer};
  };
  for (std::size_t f = 0; f < hal::kFingers; ++f) {
    as_finger(robot.inner[f], static_cast<int>(f), false);
    as_finger(robot.outer[f], static_cast<int>(f), true);
    inner_joint[f] = joint(robot.inner[f]);
    outer_joint[f] = joint(robot.outer[f]);
  }
  for (std::size_t s = 0; s < 2; ++s) spread_joint[s] = joint(robot.spread[s]);
  for (std::size_t a = 0; a < hal::kArmJoints; ++a) {
    arm_joint[a] = joint(robot.arm[a]);
    arm_dof[a] = m->jnt_dofadr[arm_joint[a]];
    arm_qpos[a] = m->jnt_qposadr[arm_joint[a]];
  }
  palm_body = link_body[static_cast<std::size_t>(robot.palm)];
  object_body = mj_name2id(m, mjOBJ_BODY, kObjectBody);
  roles[static_cast<std::size_t>(object_body)].kind = Kind::Object;
  object_dof = m->body_dofadr[object_body];
  object_qpos = m->jnt_qposadr[m->body_jntadr[object_body]];
  support_body = mj_name2id(m, mjOBJ_BODY, kSupportBody);
  if (support_body >= 0) roles[static_cast<std::size_t>(support_body)].kind = Kind::Support;
}

void Physics::Impl::add_finger_contact(const BodyRole& role, const BodyRole& other, const Vec3& p,
                                       const Vec3& force, const Vec3& torque_W, double normal_n) {
  const auto f = static_cast<std::size_t>(role.finger);
  if (other.kind != Kind::Finger) contacts.link_force_n[f] += normal_n;
  if (!role.outer) return;
  contacts.tip_force_n[f] += normal_n;
  const int j = outer_joint[f];
  const Vec3 about_joint = (p - vec(data->xanchor + 3 * j)).cross(force) + torque_W;
  contacts.strain_nm[f] -= vec(data->xaxis + 3 * j).dot(about_joint);
}

void Physics::Impl::read_contacts() {
  const bool hit_before = contacts.robot_hit;
  contacts = {};
  contacts.robot_hit = hit_before;
  const Vec3 palm_W = vec(data->xpos + 3 * palm_body);
  Vec3 grip = Vec3::Zero();
  double grip_n = 0.0;
  for (int i = 0; i < data->ncon; ++i) {
    const mjContact& c = data->contact[i];
    if (c.efc_address < 0) continue;
    std::array<mjtNum, 6> wrench{};
    mj_contactForce(model.get(), data.get(), i, wrench.data());
    const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> frame(c.frame);
    const Vec3 force = frame.transpose() * vec(wrench.data());  // on the second body
    const Vec3 torque = frame.transpose() * vec(wrench.data() + 3);
    const Vec3 p = vec(c.pos);
    for (const bool second : {false, true}) {
      const BodyRole& self = role_of_geom(second ? c.geom2 : c.geom1);
      const BodyRole& other = role_of_geom(second ? c.geom1 : c.geom2);
      const double sign = second ? 1.0 : -1.0;
      if (self.kind == Kind::Finger)
        add_finger_contact(self, other, p, sign * force, sign * torque, wrench[0]);
      if (self.kind == Kind::Arm || (self.kind == Kind::Palm && other.kind != Kind::Object))
        contacts.robot_hit = true;
      if (self.kind != Kind::Object) continue;
      switch (other.kind) {
        case Kind::Static:
          contacts.static_force_W += sign * force;
          break;
        case Kind::Support:
          contacts.support_force_W += sign * force;
          break;
        case Kind::Object:
        case Kind::Person:
          break;
        case Kind::Arm:
        case Kind::Palm:
        case Kind::Finger:
          contacts.robot_force_W += sign * force;
          contacts.robot_torque_W += sign * ((p - palm_W).cross(force) + torque);
          contacts.robot_touches_object = true;
          grip += wrench[0] * p;
          grip_n += wrench[0];
          break;
      }
    }
  }
  if (grip_n > 0.0) contacts.grip_W = grip / grip_n;
  for (const Push& push : pushes) {
    contacts.robot_hit = true;
    if (push.role.kind == Kind::Finger)
      add_finger_contact(push.role, {Kind::Person}, push.at_W, push.force_W, Vec3::Zero(), push.normal_n);
  }
}

void Physics::Impl::push(int body, const Vec3& at_W, const Vec3& force_W) {
  if (pushed_nm.size() == 0) pushed_nm.setZero(model->nv);
  const Vec3 none = Vec3::Zero();
  mj_applyFT(model.get(), data.get(), force_W.data(), none.data(), at_W.data(), body, pushed_nm.data());
}

// constraint torque of the arm's joints without that of their own limits
hal::JointVector Physics::Impl::external() const {
  hal::JointVector tau;
  for (int a = 0; a < hal::kArmJoints; ++a)
    tau[a] = data->qfrc_constraint[arm_dof[static_cast<std::size_t>(a)]];
  if (pushed_nm.size() > 0)
    for (int a = 0; a < hal::kArmJoints; ++a) tau[a] += pushed_nm[arm_dof[static_cast<std::size_t>(a)]];
  for (int row = 0; row < data->nefc; ++row) {
    if (data->efc_type[row] != mjCNSTR_LIMIT_JOINT) continue;
    for (int a = 0; a < hal::kArmJoints; ++a) {
      const auto i = static_cast<std::size_t>(a);
      if (data->efc_id[row] != arm_joint[i]) continue;
      // the row of a joint limit is +1 at its lower, -1 at its upper end
      const double sign = data->qpos[arm_qpos[i]] < 0.5 * (model->jnt_range[2 * arm_joint[i]] +
                                                           model->jnt_range[2 * arm_joint[i] + 1])
                              ? 1.0
                              : -1.0;
      tau[a] -= sign * data->efc_force[row];
    }
  }
  return tau;
}

Physics::Physics(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Physics::~Physics() = default;

hal::Result<std::unique_ptr<Physics>> Physics::make(const std::string& xml, const hal::RobotModel& model,
                                                    const hal::JointVector& q_rad) {
  auto impl = std::make_unique<Impl>();
  auto loaded = load(xml);
  if (!loaded) return tl::unexpected(loaded.error());
  impl->model = std::move(*loaded);
  correct_cylinder_contacts();
  impl->data.reset(mj_makeData(impl->model.get()));
  impl->index(model);
  for (int a = 0; a < hal::kArmJoints; ++a)
    impl->data->qpos[impl->arm_qpos[static_cast<std::size_t>(a)]] = q_rad[a];
  mj_forward(impl->model.get(), impl->data.get());
  return std::unique_ptr<Physics>(new Physics(std::move(impl)));
}

void Physics::read(ArmReading& arm, HandReading& hand) const {
  const mjModel* m = impl_->model.get();
  const mjData* d = impl_->data.get();
  for (int a = 0; a < hal::kArmJoints; ++a) {
    const int dof = impl_->arm_dof[static_cast<std::size_t>(a)];
    arm.q_rad[a] = d->qpos[impl_->arm_qpos[static_cast<std::size_t>(a)]];
    arm.dq_rad_s[a] = d->qvel[dof];
    arm.bias_nm[a] = d->qfrc_bias[dof];
    arm.inertia[a] = d->qM[m->dof_Madr[dof]];
  }
  arm.external_nm = impl_->external_nm;
  for (std::size_t f = 0; f < hal::kFingers; ++f) {
    hand.inner_rad[f] = impl_->q(impl_->inner_joint[f]);
    hand.inner_rad_s[f] = impl_->dq(impl_->inner_joint[f]);
    hand.outer_rad[f] = impl_->q(impl_->outer_joint[f]);
    hand.outer_rad_s[f] = impl_->dq(impl_->outer_joint[f]);
  }
  for (std::size_t s = 0; s < 2; ++s) {
    hand.spread_rad[s] = impl_->q(impl_->spread_joint[s]);
    hand.spread_rad_s[s] = impl_->dq(impl_->spread_joint[s]);
  }
  hand.strain_nm = impl_->contacts.strain_nm;
  hand.tip_force_n = impl_->contacts.tip_force_n;
  hand.link_force_n = impl_->contacts.link_force_n;
}

void Physics::set_torque(const hal::JointVector& arm_nm, const HandTorque& hand) {
  for (int a = 0; a < hal::kArmJoints; ++a)
    impl_->data->qfrc_applied[impl_->arm_dof[static_cast<std::size_t>(a)]] = arm_nm[a];
  for (std::size_t f = 0; f < hal::kFingers; ++f) {
    impl_->torque(impl_->inner_joint[f], hand.inner_nm[f]);
    impl_->torque(impl_->outer_joint[f], hand.outer_nm[f]);
  }
  for (std::size_t s = 0; s < 2; ++s) impl_->torque(impl_->spread_joint[s], hand.spread_nm[s]);
}

void Physics::set_object_load(const Vec3& at_W, const Vec3& force_W, const Vec3& torque_W) {
  const Vec3 lever = at_W - vec(impl_->data->xipos + 3 * impl_->object_body);
  Eigen::Map<Eigen::Matrix<double, 6, 1>> load(impl_->data->xfrc_applied + 6 * impl_->object_body);
  load << force_W, torque_W + lever.cross(force_W);
}

void Physics::push_link(int link, const Vec3& at_W, const Vec3& force_W, double normal_n) {
  const int body = impl_->link_body[static_cast<std::size_t>(link)];
  impl_->push(body, at_W, force_W);
  impl_->pushes.push_back({impl_->roles[static_cast<std::size_t>(body)], at_W, force_W, normal_n});
}

void Physics::push_object(const Vec3& at_W, const Vec3& force_W) {
  impl_->push(impl_->object_body, at_W, force_W);
}

void Physics::pull_link(int link, const Vec3& force_W) {
  const int body = impl_->link_body[static_cast<std::size_t>(link)];
  impl_->push(body, vec(impl_->data->xpos + 3 * body), force_W);
}

void Physics::step() {
  // a run in which nobody is pushed has not a rounding more than one without people
  const bool pushed = impl_->pushed_nm.size() > 0;
  Eigen::Map<Eigen::VectorXd> applied(impl_->data->qfrc_applied, impl_->model->nv);
  if (pushed) applied += impl_->pushed_nm;
  mj_step2(impl_->model.get(), impl_->data.get());
  // forces belong to the contacts of the old state: read them before the new one finds its own
  impl_->read_contacts();
  impl_->external_nm = impl_->external();
  if (pushed) {
    applied.segment(impl_->object_dof, 6)
        .setZero();  // those of the robot's joints are set anew in every step
    impl_->pushed_nm.resize(0);
    impl_->pushes.clear();
  }
  mj_step1(impl_->model.get(), impl_->data.get());
}

const ContactReading& Physics::contacts() const {
  return impl_->contacts;
}

Pose Physics::link_pose(int link) const {
  const int body = impl_->link_body[static_cast<std::size_t>(link)];
  return pose(impl_->data->xpos + 3 * body, impl_->data->xquat + 4 * body);
}

Pose Physics::object_pose() const {
  const mjtNum* q = impl_->data->qpos + impl_->object_qpos;
  return pose(q, q + 3);
}

Vec3 Physics::object_velocity_W() const {
  return vec(impl_->data->qvel + impl_->object_dof);
}

Vec3 Physics::object_turning_W() const {
  return object_pose().linear() * vec(impl_->data->qvel + impl_->object_dof + 3);
}

Vec3 Physics::link_velocity_W(int link, const Vec3& at_W) const {
  return impl_->velocity_W(impl_->link_body[static_cast<std::size_t>(link)], at_W);
}

Vec3 Physics::object_velocity_W(const Vec3& at_W) const {
  return impl_->velocity_W(impl_->object_body, at_W);
}

void Physics::place_clutter(std::size_t index, const Vec3& center_W) {
  const int body = mj_name2id(impl_->model.get(), mjOBJ_BODY, clutter_body(index).c_str());
  if (body < 0) return;
  Eigen::Map<Vec3>(impl_->data->mocap_pos + 3 * impl_->model->body_mocapid[body]) = center_W;
}

void Physics::place_support(const Vec3& center_W) {
  if (impl_->support_body < 0) return;
  const int mocap = impl_->model->body_mocapid[impl_->support_body];
  Eigen::Map<Vec3>(impl_->data->mocap_pos + 3 * mocap) = center_W;
}

Overlap Physics::overlap() const {
  Overlap overlap;
  const mjData* d = impl_->data.get();
  for (int i = 0; i < d->ncon; ++i) {
    const Kind a = impl_->role_of_geom(d->contact[i].geom1).kind;
    const Kind b = impl_->role_of_geom(d->contact[i].geom2).kind;
    const double depth = -d->contact[i].dist;
    const bool object = a == Kind::Object || b == Kind::Object;
    const bool still = a == Kind::Static || b == Kind::Static;
    double& deepest = object && still ? overlap.object_static_m
                      : object        ? overlap.robot_object_m
                                      : overlap.robot_static_m;
    deepest = std::max(deepest, depth);
  }
  return overlap;
}

int Physics::divergences() const {
  const mjWarningStat* w = impl_->data->warning;
  return w[mjWARN_BADQPOS].number + w[mjWARN_BADQVEL].number + w[mjWARN_BADQACC].number +
         w[mjWARN_CONTACTFULL].number + w[mjWARN_CNSTRFULL].number;
}

}  // namespace colift::sim_hal
