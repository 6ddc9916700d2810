#include "sim_hal/emulator/krc/krc_emulator.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "hal/os/udp_link.hpp"
#include "hal/types/units.hpp"
#include "sim_hal/emulator/krc/plant/krc_measurement.hpp"

namespace colift::sim_hal {
namespace {

using Kind = KrcFault::Kind;
constexpr std::size_t kMostRules = 1000, kMostChanges = 10000;
constexpr double kSilent_s = 1.0;  // a client that says nothing for so long is gone

std::int16_t newer_by(std::uint16_t a, std::uint16_t b) {
  return static_cast<std::int16_t>(static_cast<std::uint16_t>(a - b));
}

}  // namespace

std::string_view name(FriState state) {
  static constexpr std::array<std::string_view, 3> kNames{"off", "monitor", "command"};
  return kNames[static_cast<std::size_t>(state)];
}

std::string_view name(FriQuality quality) {
  static constexpr std::array<std::string_view, 4> kNames{"unacceptable", "bad", "ok", "perfect"};
  return kNames[static_cast<std::size_t>(quality)];
}

KrcEmulator::KrcEmulator(KrcConfig config, const hal::ArmDynamics& dynamics, KrcPlant& plant,
                         hal::DatagramLink& link, OnEvent on_event)
    : config_(std::move(config)),
      dynamics_(dynamics),
      plant_(plant),
      link_(link),
      on_event_(std::move(on_event)),
      motion_(dynamics, config_.X_FT, config_.limits, config_.cycle),
      quality_(config_.quality, config_.cycle),
      in_(config_.faults, KrcFault::Direction::ToKrc, config_.seed,
          [this](auto bytes, const hal::Endpoint& from, hal::Timestamp at) { take(bytes, from, at); }),
      out_(config_.faults, KrcFault::Direction::ToClient, config_.seed,
           [this](auto bytes, const hal::Endpoint& to, hal::Timestamp) { (void)link_.send(to, bytes); }),
      cycle_(config_.cycle),
      fault_began_(config_.faults.size(), false),
      fault_ended_(config_.faults.size(), false) {}

KrcEmulator::~KrcEmulator() = default;

hal::Result<> KrcEmulator::start(hal::Timestamp now) {
  using std::chrono::milliseconds;
  if (cycle_ < milliseconds(1) || cycle_ > milliseconds(100) || cycle_ % milliseconds(1) != hal::Duration(0))
    return hal::failure(hal::ErrorCode::BadConfig, "krc.cycle",
                        fmt::format("the cycle is {:g} ms, expected whole milliseconds from 1 to 100",
                                    1e3 * hal::seconds(cycle_)));
  script_ = make_krl_script(config_.script, config_.program);
  if (!script_) {
    std::string names;
    for (const auto known : krl_script_names())
      names += fmt::format("{}{}", names.empty() ? "" : ", ", known);
    return hal::failure(hal::ErrorCode::BadConfig, "krc.script",
                        fmt::format("\"{}\" is no KRL program; there are {}", config_.script, names));
  }
  if (auto done = plant_.set_cycle(cycle_); !done) return done;
  began_ = next_cycle_ = wire_now_ = now;
  motion_.set_measured(plant_.state());
  motion_.start_at(plant_.state().q_rad);
  script_->begin(*this);
  next_poll_s_ = script_->period_s();
  return {};
}

hal::Timestamp KrcEmulator::next_event() const {
  hal::Timestamp next = next_cycle_;
  for (const auto& due : {in_.next_due(), out_.next_due()})
    if (due && *due < next) next = *due;
  return next;
}

bool KrcEmulator::ended() const {
  return script_ && script_->ended() && !config_.restart_s;
}

void KrcEmulator::poll(hal::Timestamp now) {
  // more than a datagram of Ethernet, so that the true size of a long one is told
  std::array<std::byte, 2048> buffer;
  for (;;) {
    const hal::Datagram got = link_.receive(buffer, hal::Duration(0));
    if (got.kind != hal::Datagram::Kind::Data) break;
    deliver({buffer.data(), std::min(got.size, buffer.size())}, got.from, now);
  }
  flush(now);
}

void KrcEmulator::flush(hal::Timestamp now) {
  wire_now_ = now;
  in_.flush(hal::seconds(now - began_), now);
  out_.flush(hal::seconds(now - began_), now);
}

void KrcEmulator::deliver(std::span<const std::byte> bytes, const hal::Endpoint& from, hal::Timestamp at) {
  ++report_.received;
  if (unplugged_) return;
  in_.pass(bytes, from, hal::seconds(at - began_), at);
}

void KrcEmulator::reject(const std::string& why, bool of_client) {
  if (++report_.rejected[why] == 1) event(fmt::format("datagram refused: {}", why));
  if (of_client) broke(KrcRule::BadDatagram, why);
}

void KrcEmulator::take(std::span<const std::byte> bytes, const hal::Endpoint& from, hal::Timestamp at) {
  if (state_ == FriState::Off) return;  // nobody listens
  if (from.address != config_.to.address || (client_ && from != *client_))
    return reject(fmt::format("foreign sender {}", hal::to_string(from)), false);
  const DecodedCommand decoded = decode_command(bytes);
  if (!decoded.command) {
    const std::string why =
        decoded.why == NoCommand::WrongLength
            ? fmt::format("{} ({} bytes, expected {})", words(decoded.why), bytes.size(), kCommandBytes)
            : std::string(words(decoded.why));
    return reject(why, true);
  }
  const KrcCommand& c = *decoded.command;
  const bool answers = awaiting_ && c.reflected == send_;
  // a client that was started anew counts from its own beginning; in command mode that is no client's right
  const bool newer = !last_send_ || newer_by(c.send, *last_send_) > 0 ||
                     (answers && !answered_ && state_ != FriState::Command);
  if (last_send_ && c.send == *last_send_ && !(answers && !answered_)) {
    ++report_.duplicate;
    return;
  }
  // what is not taken is no answer: a client whose counter jumped back loses the quality, and command mode
  if (!newer) {
    report_.late += answers ? 0 : 1;
    ++report_.reordered;
    return;
  }
  if (answers && !answered_) {
    answered_ = true;
    latency_ = at - sent_at_;
  } else if (!answers) {
    ++report_.late;
  }
  if (!client_there_) {
    client_there_ = true;
    event(fmt::format("a client answers from {}", hal::to_string(from)));
  }
  client_ = from;
  last_send_ = reflected_ = c.send;
  from_pc_ = c.krl;
  last_command_ = c;
  fresh_ = true;
  heard_s_ = hal::seconds(at - began_);
}

void KrcEmulator::count_answer() {
  if (!awaiting_) return;
  awaiting_ = false;
  if (answered_) {
    quality_.answered(latency_);
    ++report_.answered;
    ever_answered_ = true;
  } else {
    quality_.missed();
    ++report_.missed;
    if (state_ == FriState::Command) ++report_.missed_in_command;
    if (ever_answered_)
      report_.most_missed_in_a_row = std::max(report_.most_missed_in_a_row, quality_.missed_in_a_row());
  }
}

void KrcEmulator::watch_quality() {
  quality_now_ = quality_.quality();
  if (const KrcFault* forced = active(Kind::Quality))
    quality_now_ = std::min(quality_now_, static_cast<FriQuality>(static_cast<int>(forced->value)));
  const FriQuality wanted = config_.strict ? FriQuality::Perfect : FriQuality::Ok;
  good_cycles_ = quality_now_ >= wanted ? good_cycles_ + 1 : 0;
  ++report_.quality_cycles[static_cast<std::size_t>(quality_now_)];
  if (quality_now_ != quality_published_ && t_s_ - quality_published_s_ > 0.5) {
    event(fmt::format("quality {} (answers {:.0f} %, latency {:.2f} ms)", name(quality_now_),
                      100.0 * quality_.answer_rate(), 1e3 * quality_.latency_s()));
    quality_published_ = quality_now_;
    quality_published_s_ = t_s_;
  }
}

void KrcEmulator::watch_client() {
  if (!client_there_ || t_s_ - heard_s_ < kSilent_s) return;
  event(fmt::format("the client says nothing since {:.1f} s", t_s_ - heard_s_));
  client_there_ = false;
  client_.reset();
}

void KrcEmulator::cycle() {
  move_plant();
  const hal::Timestamp now = next_cycle_;
  poll(now);
  t_s_ = hal::seconds(now - began_);
  next_cycle_ = now + cycle_;

  motion_.set_measured(plant_.state());
  note_faults();
  if (state_ != FriState::Off) {
    count_answer();
    watch_quality();
    watch_client();
  }
  act_on_faults();
  watch_idle();
  follow_client();
  run_program();
  try_start();
  restart_when_due();

  plant_.set_brakes(!powered());
  plant_.command(motion_.set_point());
  Vector6 wrench = Vector6::Zero();
  if (const KrcFault* push = active(Kind::Contact)) wrench[2] -= push->value;
  if (const KrcFault* load = active(Kind::LoadData)) wrench[2] -= hal::kGravity_m_s2 * load->value;
  plant_.set_push(wrench);
  if (state_ != FriState::Off) send_measurement();
  fresh_ = false;
  plant_moved_ = false;
  report_.duration_s = hal::seconds(next_cycle_ - began_);
}

void KrcEmulator::move_plant() {
  if (plant_moved_) return;
  plant_moved_ = true;
  plant_.advance(cycle_);
}

void KrcEmulator::follow_client() {
  if (braking_ && motion_.come_to_rest()) {
    braking_ = false;
    if (off_after_braking_) trip();
  }
  if (state_ != FriState::Command) return;
  ++report_.command_cycles;
  if (quality_.missed_in_a_row() > config_.extrapolated)
    return leave_for(
        {KrcRule::MissedAnswers, fmt::format("{} answers in a row were missing or late (limit {})",
                                             quality_.missed_in_a_row(), config_.extrapolated)});
  const FriQuality least = config_.strict ? FriQuality::Ok : FriQuality::Bad;
  if (quality_now_ < least)
    return leave_for({KrcRule::QualityLost, fmt::format("quality fell to {} (answers {:.0f} %)",
                                                        name(quality_now_), 100.0 * quality_.answer_rate())});
  if (!powered()) {
    // without drives the arm is not where a moving client believes it to be
    const KrcJudgedAt at = motion_.judged_at();
    if (fresh_ && (last_command_->flags & fri_flag::kJointPosition) != 0 &&
        at.control != FriControl::CartesianImpedance) {
      const double off = (joints_of(last_command_->q_rad) - motion_.q_rad()).cwiseAbs().maxCoeff();
      if (off > config_.limits.entry_pose_rad)
        return leave_for({KrcRule::MovedWithoutPower,
                          fmt::format("the client commands {:.4f} rad away while the drives are off", off)});
    }
    return;
  }
  if (!fresh_) {
    if (quality_.missed_in_a_row() > 0)
      motion_.extrapolate();
    else
      motion_.repeat();
    return;
  }
  if (const auto breach = check_command(*last_command_, motion_.judged_at(), config_.limits))
    return leave_for(*breach);
  motion_.follow(*last_command_);
}

void KrcEmulator::run_program() {
  const bool restarting = restart_at_s_ && state_ == FriState::Off;
  if (unplugged_ || halted_ || restarting || t_s_ + 1e-9 < next_poll_s_) return;
  next_poll_s_ += script_->period_s();
  script_->poll(*this);
}

void KrcEmulator::send_measurement() {
  KrcMeasurement m;
  if (active(Kind::Freeze) && frozen_) {
    m = *frozen_;
  } else {
    KrcPlantState arm = plant_.state();
    const KrcFault* offset = active(Kind::TorqueOffset);
    if (offset) {
      arm.tau_nm[offset->joint] += offset->value;
      arm.tau_external_nm[offset->joint] -= offset->value;
    }
    fill_arm(m, motion_, arm, dynamics_, config_.X_FT);
    m.krl = to_pc_;
    m.timestamp_s = static_cast<float>(t_s_);
    m.state = state_;
    m.quality = quality_now_;
    m.measurement_period_s = m.command_period_s = static_cast<float>(hal::seconds(cycle_));
    m.safety_limits = static_cast<float>(safety_limits_);
    m.answer_rate = static_cast<float>(quality_.answer_rate());
    m.latency_s = static_cast<float>(quality_.latency_s());
    m.jitter_s = static_cast<float>(quality_.jitter_s());
    m.miss_rate = static_cast<float>(1.0 - quality_.answer_rate());
    m.missed = quality_.missed_in_all();
    m.power = powered() ? 0x7F : 0;
    m.control = motion_.control();
    const auto bit = [](const KrcFault* f) { return static_cast<std::uint16_t>(f ? 1U << f->joint : 0U); };
    m.error = bit(active(Kind::DriveError));
    m.warning = bit(active(Kind::DriveWarning));
    const KrcFault* hot = active(Kind::Temperature);
    m.temperature_c.fill(static_cast<float>(hot ? hot->value : config_.temperature_c));
    if (const KrcFault* f = active(Kind::Jump))
      m.q_rad[static_cast<std::size_t>(f->joint)] += static_cast<float>(f->value);
    if (const KrcFault* f = active(Kind::NotANumber))
      m.q_rad[static_cast<std::size_t>(f->joint)] = std::numeric_limits<float>::quiet_NaN();
    frozen_ = m;
  }
  m.send = ++send_;
  m.reflected = reflected_;
  const auto bytes = encode(m);
  sent_at_ = wire_now_;
  awaiting_ = true;
  answered_ = false;
  ++report_.sent;
  out_.pass(bytes, config_.to, t_s_, wire_now_);
}

void KrcEmulator::set_state(FriState state, const std::string& reason) {
  if (state == state_) return;
  if (report_.mode_changes.size() < kMostChanges)
    report_.mode_changes.push_back({t_s_, state_, state, reason});
  if (state_ == FriState::Command)
    event(fmt::format("command mode left: {}", reason));
  else
    event(fmt::format("{} mode: {}", name(state), reason));
  state_ = state;
}

void KrcEmulator::broke(KrcRule rule, const std::string& reason) {
  if (injected(rule)) return;
  ++report_.broken_rules_in_all;
  if (report_.broken_rules.size() < kMostRules) report_.broken_rules.push_back({t_s_, rule, reason});
}

KrcReport KrcEmulator::report() const {
  KrcReport r = report_;
  r.quality = quality_now_;
  r.state = state_;
  r.answer_rate = quality_.answer_rate();
  r.latency_s = quality_.latency_s();
  r.jitter_s = quality_.jitter_s();
  return r;
}

void KrcEmulator::event(const std::string& text) const {
  if (on_event_) on_event_(t_s_, text);
}

}  // namespace colift::sim_hal
