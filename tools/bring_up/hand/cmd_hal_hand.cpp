#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "hal/config/config_file.hpp"
#include "hal/drivers/barrett_can/calibration/hand_calibration.hpp"
#include "hal/drivers/barrett_can/emergency_open.hpp"
#include "hal/drivers/barrett_can/make_barrett_hand.hpp"
#include "hal/drivers/barrett_can/replay/hand_log.hpp"
#include "hal/guards/guarded_hand.hpp"
#include "hal/os/can_link.hpp"
#include "hal/os/make_can_bus.hpp"
#include "hal/os/realtime.hpp"
#include "hal/types/units.hpp"
#include "tools/bring_up/bring_up.hpp"
#include "tools/bring_up/bundle/bundle.hpp"
#include "tools/bring_up/finger/finger_words.hpp"
#include "tools/bring_up/hand/cmd_calibrate_finger.hpp"
#include "tools/bring_up/hand/hal_hand_task.hpp"
#include "tools/bring_up/hand/logged_bus.hpp"
#include "tools/bring_up/replay/hand_replay.hpp"
#include "tools/cli/interrupt.hpp"
#include "tools/cli/session.hpp"

namespace colift::tools {
namespace {

using How = HandTaskEnd::How;

constexpr auto kPause = std::chrono::milliseconds(2);
constexpr int kPriority = 70;  // as HandThread's

void emit(const std::string& json, std::string* document) {
  if (document != nullptr)
    *document = json;
  else
    std::puts(json.c_str());
}

struct Bench {
  hal::BarrettHandConfig barrett;
  hal::HandGuardConfig guard;
};

hal::Result<Bench> load_bench(const CommonOptions& common, const HalOptions& options) {
  const auto config = read_config("hal hand", common);
  if (!config) return tl::unexpected(config.error());
  const auto file = read_wired(options, kWiredHand);
  if (!file) return tl::unexpected(file.error());
  Bench bench{file->barrett, config->guard_hand};
  // nothing moves but on the verb that says so
  bench.barrett.initialise = options.verb == "init" ? "always" : "never";
  if (options.bus_log) bench.barrett.bus_log = options.bus_log->string();
  if (!bench.barrett.calibration_file.empty())
    if (const auto known = hal::load_hand_calibration(bench.barrett.calibration_file); !known)
      return tl::unexpected(known.error());
  return bench;
}

hal::Result<HandTask> task_of(const HalOptions& o, const Bench& bench) {
  if (auto done = check_time(o); !done) return tl::unexpected(done.error());
  HandTask task;
  task.although_loaded = o.yes;
  task.torque_nm = o.torque_nm;
  task.spread_rad = hal::deg_to_rad(o.spread_deg);
  if (o.verb == "watch" || o.verb == "tactile") {
    if (o.for_s) task.for_s = *o.for_s;
  } else if (o.verb == "init") {
    task.for_s = o.for_s.value_or(1.0);  // temperatures come every 0.4 s
  } else if (o.verb == "open") {
    task.kind = HandTask::Kind::Open;
  } else if (o.verb == "preshape") {
    task.kind = HandTask::Kind::Preshape;
    if (!(o.spread_deg >= 0.0 && o.spread_deg <= 180.0))
      return hal::failure(hal::ErrorCode::BadInput, "DEG",
                          fmt::format("a spread of {}, expected 0 to 180", o.spread_deg));
  } else {
    task.kind = o.verb == "grip" ? HandTask::Kind::Grip : HandTask::Kind::Close;
    task.for_s = o.for_s.value_or(5.0);
    const double most = std::min(bench.barrett.max_torque_nm, bench.guard.max_torque_nm);
    if (!(o.torque_nm > 0.0 && o.torque_nm <= most))
      return hal::failure(
          hal::ErrorCode::BadInput, "--torque",
          fmt::format("{} N m at the fingertips, expected more than 0 and at most {}", o.torque_nm, most));
  }
  return task;
}

/// Whether the hand knows its zeros and has its fingers closed: it may hold something then.
/// On a bus of its own: what a log tells begins with the calls of the verb.
bool may_hold(const hal::BarrettHandConfig& config, const hal::Clock& clock) {
  const auto bus = hal::make_can_bus(config.can);
  if (!bus) return false;  // the verb says so
  hal::BarrettHandConfig looking = config;
  looking.initialise = "never";
  hal::BarrettHand hand(**bus, looking, clock);
  return hand.configure() && hand.report().loaded;
}

/// A faulty hand is opened with what still works; nothing is configured, so that nothing can refuse.
int open_at_once(const CommonOptions& common, const HalOptions& options, const Bench& bench) {
  if (!options.yes) {
    std::fputs("colift hal hand emergency-open: what the hand holds will fall: support it, and say --yes\n",
               stderr);
    return kBadInput;
  }
  const hal::SteadyClock clock;
  auto bus = make_bus(bench.barrett, clock);
  if (!bus) return report_error("hal hand", bus.error());
  const InterruptGuard signals;
  const auto fingers =
      hal::emergency_open(*bus->bus, clock, bench.barrett, [] { return InterruptGuard::asked(); });
  if (!fingers) {
    report_failure("hand", options.verb, fingers.error().text(),
                   fmt::format("next: {}\n", hand_advice(fingers.error().code, bench.barrett.can)));
    return kDeviceFailed;
  }
  const auto opened = [](const hal::FingerOpening& f) { return f.answers && f.rests; };
  const bool all = std::all_of(fingers->begin(), fingers->end(), opened);
  if (common.json)
    std::puts(hand_emergency_document(*fingers).c_str());
  else
    std::fputs(hal::describe(*fingers).c_str(), stdout);
  return all ? 0 : kDeviceFailed;
}

/// Questions alone: a cold hand stays cold, and nothing that another program does with it is disturbed.
int read_state(const CommonOptions& common, const HalOptions& options, const Bench& bench) {
  const hal::SteadyClock clock;
  auto bus = make_bus(bench.barrett, clock);
  if (!bus) return report_error("hal hand", bus.error());
  const auto reading = hal::read_hand(*bus->bus, clock, bench.barrett);
  if (!reading) {
    report_failure("hand", options.verb, reading.error().text(),
                   fmt::format("next: {}\n", hand_advice(reading.error().code, bench.barrett.can)));
    return kDeviceFailed;
  }
  std::fputs((common.json ? hand_reading_document(bench.barrett.can, *reading) + "\n"
                          : hand_reading_text(bench.barrett.can, *reading))
                 .c_str(),
             stdout);
  const std::string fault = hand_reading_fault(*reading);
  if (fault.empty()) return 0;
  std::fflush(stdout);
  report_failure("hand", options.verb, fault, std::nullopt);
  return kDeviceFailed;
}

/// What a kernel says of the interface; a gateway's is not asked.
std::string link_text(const std::string& can) {
  constexpr std::string_view kSocketcan = "socketcan:";
  if (!can.starts_with(kSocketcan)) return fmt::format("{}: no interface of this machine\n", can);
  const std::string interface = can.substr(kSocketcan.size());
  const auto link = hal::read_can_link(interface);
  if (!link) return link.error().text() + "\n";
  const auto good = hal::check_can_link(interface, *link, 1'000'000);
  return fmt::format("{}: {}{}, bit rate {}, restart {} ms, errors sent {} received {}\n{}\n", interface,
                     link->index == 0 ? "not there"
                     : link->up       ? "up"
                                      : "down",
                     link->running ? ", has a carrier" : "", link->bitrate.value_or(0),
                     link->restart_ms.value_or(0), link->send_errors.value_or(0),
                     link->receive_errors.value_or(0), good ? "nothing wrong with it" : good.error().text());
}

/// All that is known of the hand without moving it, as one file that a person can send.
int make_bundle(const HalOptions& options, Bench bench, bool json) {
  const std::filesystem::path out = options.out.value_or("hand-doctor.tar");
  if (auto free = check_new_bundle(out); !free) return report_error("hal hand doctor", free.error());
  if (bench.barrett.bus_log.empty()) bench.barrett.bus_log = out.string() + ".log";
  std::vector<BundlePart> parts;
  std::string fault;
  std::filesystem::path log_file;
  {
    const hal::SteadyClock clock;
    auto bus = make_bus(bench.barrett, clock, options.bus_log.has_value());  // else it goes into the bundle
    if (!bus) return report_error("hal hand doctor", bus.error());
    log_file = bus->log->file();
    const auto reading = hal::read_hand(*bus->bus, clock, bench.barrett);
    if (reading) {
      fault = hand_reading_fault(*reading);
      parts.push_back({"state.txt", hand_reading_text(bench.barrett.can, *reading)});
      parts.push_back({"state.json", hand_reading_document(bench.barrett.can, *reading) + "\n"});
    } else {
      fault = reading.error().text();
      parts.push_back({"state.txt", fmt::format("{}\nnext: {}\n", fault,
                                                hand_advice(reading.error().code, bench.barrett.can))});
    }
    const hal::CanHealth health = bus->bus->health();
    parts.push_back(
        {"bus.txt",
         fmt::format("{}received {}, sent {}, not sent {}, dropped {}, error frames {}, "
                     "bus-offs {}, not acknowledged {}\n",
                     link_text(bench.barrett.can), health.received, health.sent, health.not_sent,
                     health.dropped, health.error_frames, health.bus_offs, health.not_acknowledged)});
  }  // the log is complete
  parts.push_back({"config.yaml", hal::effective_yaml(hal::table_of(bench.barrett), false)});
  std::ifstream log(log_file);
  parts.push_back({"bus.log", {std::istreambuf_iterator<char>(log), {}}});
  if (!options.bus_log) std::filesystem::remove(log_file);
  if (auto done = write_bundle(out, parts); !done) return report_error("hal hand doctor", done.error());
  const std::string said =
      json ? bundle_document(out.string(), fault)
           : fmt::format("{}: what the hand answered, its bus, settings, the log of both: send this file{}{}",
                         out.string(), fault.empty() ? "" : "\n", fault);
  std::puts(said.c_str());
  return fault.empty() ? kDone : kDeviceFailed;
}

/// One finger alone, with the pucks' own modes. 0 as asked, 1 stopped before. `document`: where its JSON goes
/// instead of stdout.
int move_one_finger(const CommonOptions& common, const HalOptions& options, const Bench& bench,
                    std::string* document = nullptr) {
  const std::string where = fmt::format("hal hand {}", options.verb);
  const auto finger = parse_finger(options.finger);
  if (!finger)
    return report_error(where.c_str(),
                        hal::Error{hal::ErrorCode::BadInput, "FINGER",
                                   fmt::format("\"{}\", expected F1, F2 or F3", options.finger)});
  auto motion = *finger_motion_of(options.verb, *finger, options.value);
  motion.torque_nm = options.torque_nm;
  motion.for_s = options.for_s.value_or(1.0);
  motion.although_closed = options.yes;
  if (motion.kind == hal::FingerMotion::Kind::Torque && !options.yes) {
    std::fputs(
        "colift hal hand torque: a puck in torque control knows no limits of the joint: keep clear, and say "
        "--yes\n",
        stderr);
    return kBadInput;
  }
  hal::BarrettHandConfig config = bench.barrett;
  config.max_torque_nm = std::min(config.max_torque_nm, bench.guard.max_torque_nm);
  const hal::SteadyClock clock;
  auto bus = make_bus(bench.barrett, clock);
  if (!bus) return report_error("hal hand", bus.error());
  (void)hal::ask_for_realtime(
      {.priority = kPriority, .lock_memory = false, .stack_bytes = 65536, .heap_bytes = 0});
  const InterruptGuard signals;
  const auto end = hal::move_finger(*bus->bus, clock, config, motion, [] { return InterruptGuard::asked(); });
  if (!end) {
    const bool typed = end.error().code == hal::ErrorCode::LimitExceeded ||
                       end.error().detail.find("--yes") != std::string::npos;
    if (typed) return report_error(where.c_str(), end.error()), kBadInput;
    report_failure("hand", options.verb, end.error().text(),
                   fmt::format("next: {}\n", hand_advice(end.error().code, bench.barrett.can)));
    return kDeviceFailed;
  }
  if (common.json)
    emit(finger_document(options.verb, *finger, *end), document);
  else
    std::fputs(finger_text(*finger, *end).c_str(), stdout);
  if (!end->rests) return kDeviceFailed;
  return end->as_asked ? kDone : InterruptGuard::asked() ? 130 : kNoGoal;
}

/// A recorded session against today's driver and the emulated hand. No device, no time but the log's.
int replay(const CommonOptions& common, const HalOptions& options) {
  const auto log = hal::read_candump(options.replay);
  if (!log) return report_error("hal hand replay", log.error());
  std::optional<hal::DriverReplay> driver;
  std::string why;
  if (auto played = hal::replay_driver(*log, options.replay.string()))
    driver = std::move(*played);
  else if (played.error().code != hal::ErrorCode::NotFound)
    return report_error("hal hand replay", played.error());
  else
    why = played.error().detail;
  const EmulatorReplay emulator = replay_emulator(*log);
  const std::string text = common.json
                               ? replay_document(options.replay.string(), driver, why, emulator) + "\n"
                               : replay_text(driver, why, emulator);
  std::fputs(text.c_str(), stdout);
  return (!driver || driver->equal()) && emulator.equal() ? kDone : kNoGoal;
}

/// `document`: where its JSON goes instead of stdout.
int run(const CommonOptions& common, const HalOptions& options, const Bench& bench, const HandTask& task,
        std::string* document = nullptr) {
  const hal::SteadyClock clock;
  auto bus = make_bus(bench.barrett, clock);
  if (!bus) return report_error("hal hand", bus.error());
  // looking for the stops opens the fingers, whatever is in them
  if (options.verb == "init" && !options.yes && may_hold(bench.barrett, clock)) {
    std::fputs(
        "colift hal hand init: its fingers are closed and may hold something, which would fall: support it, "
        "and say --yes\n",
        stderr);
    return kBadInput;
  }
  auto barrett = std::make_unique<hal::BarrettHand>(*bus->bus, bench.barrett, clock);
  const hal::BarrettHand& driver = *barrett;
  std::unique_ptr<hal::Hand> called = std::move(barrett);
  if (bus->log) {
    hal::note_hand_settings(*bus->log, bench.barrett, clock);
    called = std::make_unique<hal::LoggedHand>(std::move(called), *bus->log, clock);
  }
  hal::GuardedHand hand(std::move(called), bench.guard, &clock);

  // the driver runs in this thread: other programs' load must not make answers late
  (void)hal::ask_for_realtime(
      {.priority = kPriority, .lock_memory = false, .stack_bytes = 65536, .heap_bytes = 0});
  const InterruptGuard signals;
  LiveScreen screen = progress_screen(common, options, "state");
  const hal::Timestamp began = clock.now();
  const auto at_s = [&] { return hal::seconds(clock.now() - began); };
  HandView view;
  view.bus = bench.barrett.can;
  const auto look = [&](const std::optional<hal::HandState>& state) {
    view.health = driver.health();
    view.report = driver.report();
    view.state = state;
    view.at_s = at_s();
  };
  std::string said;
  HandTaskHooks hooks;
  hooks.interrupted = [] { return InterruptGuard::asked(); };
  hooks.pause = [] { std::this_thread::sleep_for(kPause); };
  hooks.report = [&] { return driver.report(); };
  hooks.progress = [&](std::string_view doing, const std::optional<hal::HandState>& state) {
    look(state);
    if (said != doing) {
      said = doing;
      if (!screen.live() || !state) screen.line(fmt::format("{:8.1f} s  {}", view.at_s, doing));
      return;
    }
    if (screen.live() && state)
      screen.draw(options.verb == "tactile" ? tactile_text(view) : hand_screen(view), view.at_s);
    else if (state)
      screen.line_now_and_then(hand_line(view), view.at_s);
  };
  if (options.verb == "init" && !common.quiet)
    std::fputs("the fingers open to their stops, then the spread turns: keep clear\n", stderr);
  const HandTaskEnd end = run_hand_task(hand, task, clock, hooks);
  look(end.states > 0 ? std::optional(end.after) : std::nullopt);

  if (common.json) {
    emit(hand_document(options.verb, view, task, end), document);
  } else {
    std::string text;
    if (task.kind != HandTask::Kind::Watch)
      text = hand_summary(task, end);
    else if (end.states > 0 && options.verb == "tactile")
      text = tactile_text(view);
    else if (end.states > 0)
      text = hand_screen(view);
    std::fputs(text.c_str(), stdout);
  }
  std::fflush(stdout);
  if (end.how != How::Done && end.how != How::Interrupted)
    report_failure("hand", options.verb, end.reason,
                   exit_code(end.how) == kDeviceFailed
                       ? std::optional(fmt::format("next: {}\n", hand_advice(end.code, bench.barrett.can)))
                       : std::nullopt);
  return exit_code(end.how);
}

/// The spread as asked, then all fingers to one angle: closed fingers would meet each other while it turns.
int preshape_with_fingers(const CommonOptions& common, const HalOptions& options, const Bench& bench,
                          const HandTask& task) {
  if (!(*options.fingers_deg >= 0.0 && *options.fingers_deg <= hal::rad_to_deg(hal::kMaxFinger_rad)))
    return report_error("hal hand preshape",
                        hal::Error{hal::ErrorCode::BadInput, "--fingers",
                                   fmt::format("{} degrees, expected 0 to {:.0f}", *options.fingers_deg,
                                               hal::rad_to_deg(hal::kMaxFinger_rad))});
  std::string hand;
  int code = run(common, options, bench, task, &hand);
  std::vector<std::string> fingers;
  for (const char* finger : {"F1", "F2", "F3"}) {
    if (code != kDone) break;
    HalOptions one = options;
    one.verb = "finger";
    one.finger = finger;
    one.value = *options.fingers_deg;
    std::string document;
    code = move_one_finger(common, one, bench, &document);
    if (!document.empty()) fingers.push_back(std::move(document));
  }
  if (common.json && !hand.empty()) std::puts(with_fingers(hand, fingers).c_str());
  return code;
}

}  // namespace

int cmd_hal_hand(const CommonOptions& common, const HalOptions& options) {
  if (options.verb == "replay") return replay(common, options);
  const auto bench = load_bench(common, options);
  if (!bench) return report_error("hal hand", bench.error());
  if (options.verb == "emergency-open") return open_at_once(common, options, *bench);
  if (options.verb == "state") return read_state(common, options, *bench);
  if (options.verb == "doctor") return make_bundle(options, *bench, common.json);
  if (options.verb == "calibrate") return cmd_calibrate_finger(common, options, bench->barrett);
  if (finger_motion_of(options.verb, hal::barrett::Puck::F1, 0.0))
    return move_one_finger(common, options, *bench);
  const auto task = task_of(options, *bench);
  if (!task) {
    const std::string where = fmt::format("hal hand {}", options.verb);
    return report_error(where.c_str(), task.error());
  }
  if (options.verb == "preshape" && options.fingers_deg)
    return preshape_with_fingers(common, options, *bench, *task);
  return run(common, options, *bench, *task);
}

}  // namespace colift::tools
