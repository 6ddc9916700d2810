#include "tools/telemetry/record/cycle_inputs.hpp"

#include <fmt/format.h>

#include <limits>

#include "tools/telemetry/channels/json_parts.hpp"

namespace colift::telemetry {
namespace {

constexpr int kLastCode = static_cast<int>(hal::ErrorCode::NotFound);
constexpr int kLastHealth = static_cast<int>(hal::DeviceHealth::State::Failed);

// One list of fields for both directions: a Saver turns values into JSON, a Loader takes them back. What a
// Loader does not find throws Json's own exception, which parse_inputs() turns into an error.

struct Saver {
  Json& j;
  template <class T>
  void added(const char* key, T& v) {
    (*this)(key, v);
  }
  void operator()(const char* key, double& v) { j[key] = number_json(v); }
  void operator()(const char* key, bool& v) { j[key] = v; }
  void operator()(const char* key, int& v) { j[key] = v; }
  void operator()(const char* key, std::uint32_t& v) { j[key] = v; }
  void operator()(const char* key, std::uint64_t& v) { j[key] = v; }
  void operator()(const char* key, hal::Timestamp& v) { j[key] = v.count(); }
  void operator()(const char* key, hal::ShortText& v) {
    if (!v.empty()) j[key] = v.str();
  }
  void operator()(const char* key, hal::JointVector& v) { j[key] = numbers_json(v); }
  void operator()(const char* key, hal::Vec3& v) { j[key] = list_of(v); }
  template <std::size_t kCount>
  void operator()(const char* key, std::array<double, kCount>& v) {
    j[key] = numbers_json(v);
  }
  template <class Enum>
  void choice(const char* key, Enum& v, int) {
    j[key] = static_cast<int>(v);
  }
  /// Only what a hand with tactile sensors has measured.
  template <std::size_t kCount>
  void tactile(const char* key, const std::array<hal::TactileArray, kCount>& arrays) {
    for (std::size_t i = 0; i < kCount; ++i)
      if (arrays[i].measured_at != hal::Timestamp{0})
        j[key].push_back({{"array", i},
                          {"at", arrays[i].measured_at.count()},
                          {"cells", numbers_json(arrays[i].pressure_n_cm2)}});
  }
  template <class Enum>
  void added_choice(const char* key, Enum& v, int last) {
    choice(key, v, last);
  }
};

double number(const Json& j) {
  return j.is_null() ? std::numeric_limits<double>::quiet_NaN() : j.get<double>();
}

struct Loader {
  const Json& j;
  /// Of a key that older recordings do not have.
  template <class T>
  void added(const char* key, T& v) {
    if (j.contains(key)) (*this)(key, v);
  }
  void operator()(const char* key, double& v) { v = number(j.at(key)); }
  void operator()(const char* key, bool& v) { v = j.at(key).get<bool>(); }
  void operator()(const char* key, int& v) { v = j.at(key).get<int>(); }
  void operator()(const char* key, std::uint32_t& v) { v = j.at(key).get<std::uint32_t>(); }
  void operator()(const char* key, std::uint64_t& v) { v = j.at(key).get<std::uint64_t>(); }
  void operator()(const char* key, hal::Timestamp& v) { v = hal::Timestamp(j.at(key).get<std::int64_t>()); }
  void operator()(const char* key, hal::ShortText& v) {
    if (j.contains(key)) v.set(j.at(key).get<std::string>());
  }
  void operator()(const char* key, hal::JointVector& v) { fill(key, v.data(), hal::kArmJoints); }
  void operator()(const char* key, hal::Vec3& v) { fill(key, v.data(), 3); }
  template <std::size_t kCount>
  void operator()(const char* key, std::array<double, kCount>& v) {
    fill(key, v.data(), kCount);
  }
  template <class Enum>
  void choice(const char* key, Enum& v, int last) {
    const int n = j.at(key).get<int>();
    if (n >= 0 && n <= last) v = static_cast<Enum>(n);
  }
  template <class Enum>
  void added_choice(const char* key, Enum& v, int last) {
    if (j.contains(key)) choice(key, v, last);
  }
  template <std::size_t kCount>
  void tactile(const char* key, std::array<hal::TactileArray, kCount>& arrays) {
    if (!j.contains(key)) return;
    for (const Json& one : j.at(key)) {
      hal::TactileArray& a = arrays.at(one.at("array").get<std::size_t>());
      a.measured_at = hal::Timestamp(one.at("at").get<std::int64_t>());
      for (std::size_t i = 0; i < hal::kArrayCells; ++i)
        a.pressure_n_cm2[i] = static_cast<float>(number(one.at("cells").at(i)));
    }
  }
  void fill(const char* key, double* to, std::size_t count) {
    const Json& list = j.at(key);
    for (std::size_t i = 0; i < count; ++i) to[i] = number(list.at(i));
  }
};

template <class Visitor>
void visit(Visitor& v, hal::ArmState& s) {
  v("at", s.measured_at);
  v("q", s.q_rad);
  v("q_commanded", s.q_commanded_rad);
  v("tau", s.tau_nm);
  v("tau_external", s.tau_external_nm);
  v("may_command", s.may_command);
  v("slow", s.slow);
}

template <class Visitor>
void visit(Visitor& v, hal::HandState& s) {
  v("at", s.measured_at);
  v("finger", s.finger_rad);
  v("outer", s.outer_rad);
  v("spread", s.spread_rad);
  v("torque", s.torque_nm);
  v("tip_force", s.tip_force_n);
  v.added("palm_force", s.palm_force_n);
  v.tactile("tactile", s.tactile);
  v("moving", s.moving);
  v("held", s.held);
  v("slips", s.slips);
  v("hot", s.hot);
  v("warning", s.warning);
}

template <class Visitor>
void visit(Visitor& v, control::ArmView& w) {
  v("answered", w.answered);
  v("commanded", w.commanded_rad);
  v("running", w.running);
  v("at_rest", w.at_rest);
  v("done", w.done);
  v("progress", w.progress);
  v("starts", w.starts);
  v.choice("blocked", w.blocked.why, static_cast<int>(control::SetpointGenerator::Contact::Lag));
  v("blocked_n", w.blocked.force_n);
  v("blocked_limit_n", w.blocked.force_limit_n);
  v("blocked_joint", w.blocked.joint);
  v("blocked_rad", w.blocked.lag_rad);
  v("blocked_limit_rad", w.blocked.lag_limit_rad);
  v.added_choice("unexpected_force", w.force.kind, static_cast<int>(control::ForceFinding::Kind::Joint));
  v.added("unexpected_force_measured", w.force.measured);
  v.added("unexpected_force_limit", w.force.limit);
  v.added("unexpected_force_joint", w.force.joint);
  v.added("force_quiet", w.force_quiet);
  v("way_refused", w.trajectory_refused);
  v("slow", w.slow);
  v("load_n", w.load_n);
  v.added("stalled", w.stalled);
  v.added("stalls", w.stalls);
  v.added("stall_s", w.stall_s);
  v("height_m", w.height_m);
  v("lift_at_rest", w.lift_at_rest);
  v("end_of_reach", w.end_of_reach);
  v.choice("role", w.role, 1);
  v.added("palm_springs", w.palm_springs);
  v.added("energy_j", w.energy_j);
  v.added("min_energy_j", w.min_energy_j);
  v("cycles", w.cycles);
  v("missed", w.missed);
  v("misses", w.misses);
  v("link_lost", w.link_lost);
  v("refused_commands", w.refused_commands);
  v("trouble", w.fault);
  v("refusal", w.refusal);
}

template <class T>
Json saved(T value) {
  Json j = Json::object();
  Saver save{j};
  visit(save, value);
  return j;
}

template <class T>
T loaded(const Json& j) {
  T value{};
  Loader load{j};
  visit(load, value);
  return value;
}

Json saved_error(const hal::Error& e) {
  return {{"code", static_cast<int>(e.code)}, {"where", e.where}, {"detail", e.detail}};
}

hal::Error loaded_error(const Json& j) {
  const int code = j.at("code").get<int>();
  if (code < 0 || code > kLastCode) return {hal::ErrorCode::BadReply, "recording", "an unknown error"};
  return {static_cast<hal::ErrorCode>(code), j.at("where").get<std::string>(),
          j.at("detail").get<std::string>()};
}

template <class T>
Json saved_all(const std::vector<hal::Result<T>>& results) {
  Json all = Json::array();
  for (const auto& r : results) {
    if (!r)
      all.push_back({{"error", saved_error(r.error())}});
    else if constexpr (std::is_void_v<T>)
      all.push_back(Json::object());
    else
      all.push_back(saved(*r));
  }
  return all;
}

template <class T>
void load_all(const Json& j, const char* key, std::vector<hal::Result<T>>& to) {
  if (!j.contains(key)) return;
  for (const Json& one : j.at(key)) {
    if (one.contains("error"))
      to.push_back(tl::unexpected(loaded_error(one.at("error"))));
    else if constexpr (std::is_void_v<T>)
      to.emplace_back();
    else
      to.push_back(loaded<T>(one));
  }
}

Json saved_view(const control::ArmView& view) {
  Json j = saved(view);
  j["state"] = saved(view.state);
  if (view.wrench_W) {
    j["force"] = list_of(view.wrench_W->force);
    j["torque"] = list_of(view.wrench_W->torque);
  }
  return j;
}

control::ArmView loaded_view(const Json& j) {
  auto view = loaded<control::ArmView>(j);
  view.state = loaded<hal::ArmState>(j.at("state"));
  if (j.contains("force")) {
    view.wrench_W.emplace();
    Loader load{j};
    load("force", view.wrench_W->force);
    load("torque", view.wrench_W->torque);
  }
  return view;
}

CycleInputs load(const Json& j) {
  CycleInputs in;
  in.cycle = j.at("cycle").get<std::uint64_t>();
  in.clock_ns = j.at("clock").get<std::vector<std::int64_t>>();
  load_all(j, "arm", in.arm);
  if (j.contains("view")) in.view = loaded_view(j.at("view"));
  if (j.contains("arm_health"))
    for (const Json& one : j.at("arm_health")) {
      hal::DeviceHealth health;
      Loader from{one};
      from.choice("state", health.state, kLastHealth);
      health.last_error = one.at("last_error").get<std::string>();
      in.arm_health.push_back(std::move(health));
    }
  load_all(j, "hand", in.hand);
  if (j.contains("camera"))
    for (const Json& one : j.at("camera")) {
      CameraReading reading;
      if (one.contains("frame")) reading.frame = one.at("frame").get<std::uint64_t>();
      if (one.contains("error")) reading.error = loaded_error(one.at("error"));
      in.camera.push_back(std::move(reading));
    }
  load_all(j, "answers", in.answers);
  in.interrupted = j.contains("interrupted") && j.at("interrupted").get<bool>();
  in.lower_confirmed = j.contains("lower_confirmed") && j.at("lower_confirmed").get<bool>();
  in.continue_confirmed = j.contains("continue_confirmed") && j.at("continue_confirmed").get<bool>();
  return in;
}

}  // namespace

std::string inputs_message(const CycleInputs& in) {
  Json j = {{"cycle", in.cycle}, {"clock", in.clock_ns}};
  if (!in.arm.empty()) j["arm"] = saved_all(in.arm);
  if (in.view) j["view"] = saved_view(*in.view);
  for (const hal::DeviceHealth& health : in.arm_health)
    j["arm_health"].push_back({{"state", static_cast<int>(health.state)}, {"last_error", health.last_error}});
  if (!in.hand.empty()) j["hand"] = saved_all(in.hand);
  for (const CameraReading& reading : in.camera) {
    Json one = Json::object();
    if (reading.frame)
      one["frame"] = *reading.frame;
    else if (reading.error.code != hal::ErrorCode::Timeout)
      one["error"] = saved_error(reading.error);
    j["camera"].push_back(std::move(one));
  }
  if (!in.answers.empty()) j["answers"] = saved_all(in.answers);
  if (in.interrupted) j["interrupted"] = true;
  if (in.lower_confirmed) j["lower_confirmed"] = true;
  if (in.continue_confirmed) j["continue_confirmed"] = true;
  return dumped(j);
}

hal::Result<CycleInputs> parse_inputs(std::string_view message) {
  const Json j = Json::parse(message, nullptr, false);
  if (j.is_discarded()) return hal::failure(hal::ErrorCode::BadInput, "/inputs", "a message is no JSON");
  try {
    return load(j);
  } catch (const Json::exception& e) {
    return hal::failure(hal::ErrorCode::BadInput, "/inputs",
                        fmt::format("a message is incomplete: {}", e.what()));
  }
}

}  // namespace colift::telemetry
