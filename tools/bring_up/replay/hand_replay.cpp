#include "tools/bring_up/replay/hand_replay.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>

#include "hal/drivers/barrett_can/hand_units.hpp"
#include "sim_hal/emulator/hand/hand_light_plant.hpp"
#include "sim_hal/emulator/hand/hand_lock_step.hpp"

namespace colift::tools {
namespace {

using namespace hal::barrett;
using hal::CandumpFrame;

constexpr std::size_t kMostDifferences = 200;
constexpr hal::Duration kAfterwards = std::chrono::milliseconds(100);
// Silences of boot and initialising end some milliseconds earlier or later.
constexpr hal::Duration kEdge = std::chrono::milliseconds(150);

// Between two rows of a scan; the answers to other questions may come there.
constexpr hal::Duration kRowPause = std::chrono::milliseconds(20);

struct Legal {
  std::int32_t low = std::numeric_limits<std::int32_t>::min(),
               high = std::numeric_limits<std::int32_t>::max();
};

// Of what the hand measures or is in; settings are whatever was set.
Legal legal(Puck puck, Property property) {
  const bool spread = puck == Puck::Spread;
  switch (property) {
    case Property::Stat:
      return {0, 2};
    case Property::Mode:
      return {0, 5};
    case Property::Sg:
      return {0, 4095};
    case Property::Temp:
    case Property::Therm:
      return {-20, 120};
    case Property::Vbus:
      return {0, 60};
    case Property::P:
      return spread ? Legal{-2'000, 40'000} : Legal{-10'000, 210'000};
    case Property::Jp:
      return {-5'000, 85'000};
    default:
      return {};
  }
}

// What kind of hand it is: the first answer of a puck.
std::optional<std::int32_t> first_answer(const std::vector<CandumpFrame>& frames, Puck puck,
                                         Property property) {
  for (const CandumpFrame& f : frames)
    if (const auto a = read_answer(f.frame); a && a->puck == puck && a->property == property) return a->value;
  return std::nullopt;
}

sim_hal::HandEmulatorConfig built_as(const std::vector<CandumpFrame>& frames) {
  sim_hal::HandEmulatorConfig config;
  config.judges_pace = false;
  config.puck.awake = first_answer(frames, Puck::F1, Property::Stat) == kStatReady;
  config.puck.firmware =
      std::clamp(first_answer(frames, Puck::F1, Property::Vers).value_or(config.puck.firmware), 132, 999);
  config.puck.finger_role = first_answer(frames, Puck::F1, Property::Role).value_or(config.puck.finger_role);
  config.puck.spread_role =
      first_answer(frames, Puck::Spread, Property::Role).value_or(config.puck.spread_role);
  for (const Puck puck : kAllPucks)
    if (const auto group = first_answer(frames, puck, Property::GrpC); group && *group >= 0 && *group < 32)
      config.group_c[index(puck)] = *group;
  return config;
}

// The recorded requests and what the emulated hand answers, as a log; times from zero.
std::vector<CandumpFrame> ask_emulated(const hal::Candump& log, const PuckSession& recorded) {
  hal::ManualClock clock;
  sim_hal::MemoryCan bus(clock);
  const auto far_end = bus.node();
  sim_hal::LightHandPlant plant;
  sim_hal::HandEmulator pucks(built_as(log.frames), plant, *far_end);
  const auto client = bus.node();
  (void)far_end->open();
  (void)client->open();
  (void)pucks.start(clock.now());
  std::vector<CandumpFrame> said;
  const auto run_to = [&](hal::Timestamp until) {
    sim_hal::run_until(pucks, clock, until);
    CandumpFrame answer;
    answer.direction = CandumpFrame::Direction::Received;
    while (client->receive(answer.frame, hal::Duration(0)) == hal::CanBus::Received::Frame)
      said.push_back(answer);
  };
  const hal::Timestamp start = log.frames.front().frame.arrived_at;
  for (const PuckRequest& request : recorded.requests) {
    CandumpFrame again = log.frames[request.frame];
    run_to(again.frame.arrived_at - start);
    again.frame.arrived_at = clock.now();
    again.direction = CandumpFrame::Direction::Sent;
    (void)client->send(again.frame);
    said.push_back(again);
  }
  run_to(clock.now() + kAfterwards);
  return said;
}

struct Side {
  const std::vector<CandumpFrame>& frames;
  const PuckSession& session;

  [[nodiscard]] hal::Timestamp at(std::size_t r) const {
    return frames[session.requests[r].frame].frame.arrived_at;
  }
  [[nodiscard]] const hal::CanFrame& frame(const PuckAnswer& a, std::size_t i) const {
    return frames[a.frames[i]].frame;
  }
};

using Latencies = std::map<Property, std::vector<double>>;

void count(AnswerForm& form, Latencies& latencies, const Side& side, std::size_t r, const PuckAnswer& a) {
  ++form.asked;
  if (a.count == 0) return;
  ++form.answered;
  const hal::CanFrame& last = side.frame(a, a.count - 1u);
  latencies[side.session.requests[r].says.property].push_back(1e3 *
                                                              hal::seconds(last.arrived_at - side.at(r)));
  const auto value = read_answer(last);
  if (!value || !value->value) return;
  form.lowest = std::min(form.lowest.value_or(*value->value), *value->value);
  form.highest = std::max(form.highest.value_or(*value->value), *value->value);
}

// An answer of the same puck and property soon after, or before: the silence only ends elsewhere.
bool at_an_edge(const Side& side, std::size_t r, Puck puck) {
  const Property property = side.session.requests[r].says.property;
  const auto answered = [&](std::size_t other) {
    const PuckRequest& request = side.session.requests[other];
    return request.says.property == property &&
           std::any_of(request.answers.begin(), request.answers.end(),
                       [&](const PuckAnswer& a) { return a.puck == puck && a.count > 0; });
  };
  for (std::size_t o = r + 1; o < side.session.requests.size() && side.at(o) - side.at(r) < kEdge; ++o)
    if (answered(o)) return true;
  for (std::size_t o = r; o-- > 0 && side.at(r) - side.at(o) < kEdge;)
    if (answered(o)) return true;
  return false;
}

// The recording ended before this scan's next row had to come.
bool ends_in_scan(const Side& side, const PuckAnswer& a, Property property) {
  const hal::CanFrame& row = side.frame(a, a.count - 1u);
  return property == Property::Tact && side.frames.back().frame.arrived_at - row.arrived_at < kRowPause;
}

// An empty text, or how the forms differ.
std::string compare(const Side& recorded, const PuckAnswer& then, const Side& emulated, const PuckAnswer& now,
                    Property property) {
  if (then.count != now.count)
    return fmt::format("{} frames, the emulated hand answers with {}", then.count, now.count);
  for (std::size_t i = 0; i < then.count; ++i) {
    const hal::CanFrame &a = recorded.frame(then, i), &b = emulated.frame(now, i);
    if (a.id != b.id || a.length != b.length)
      return fmt::format("{:03X} with {} bytes, the emulated hand answers as {:03X} with {}", a.id, a.length,
                         b.id, b.length);
    const auto value = read_answer(a);
    const Legal range = legal(then.puck, property);
    if (value && value->value && (*value->value < range.low || *value->value > range.high))
      return fmt::format("{} is beyond what the emulated hand keeps to, {} to {}", *value->value, range.low,
                         range.high);
  }
  return {};
}

void finish(AnswerForm& form, std::vector<double>& ms) {
  if (ms.empty()) return;
  std::sort(ms.begin(), ms.end());
  form.median_ms = ms[ms.size() / 2];
  form.worst_ms = ms.back();
}

}  // namespace

EmulatorReplay replay_emulator(const hal::Candump& log, std::uint64_t most_per_property) {
  EmulatorReplay replay;
  if (log.frames.empty()) return replay;
  const PuckSession then = read_puck_session(log.frames);
  const std::vector<CandumpFrame> frames = ask_emulated(log, then);
  const PuckSession now = read_puck_session(frames);
  const Side recorded{log.frames, then}, emulated{frames, now};
  std::map<Property, PropertyComparison> properties;
  Latencies recorded_ms, emulated_ms;
  const auto differ = [&](PropertyComparison& of, std::uint32_t line, std::string words) {
    if (++of.differences <= most_per_property && replay.differences.size() < kMostDifferences)
      replay.differences.push_back({line, std::move(words)});
    else
      ++replay.more;
  };
  for (std::size_t r = 0; r < std::min(then.requests.size(), now.requests.size()); ++r) {
    const Request& says = then.requests[r].says;
    for (std::size_t k = 0; k < then.requests[r].answers.size(); ++k) {
      const PuckAnswer &a = then.requests[r].answers[k], &b = now.requests[r].answers[k];
      PropertyComparison& of = properties[says.property];
      of.property = says.property;
      count(of.recorded, recorded_ms, recorded, r, a);
      count(of.emulated, emulated_ms, emulated, r, b);
      if (a.count == 0) continue;  // lost, or not answered: counted
      if (a.count < b.count && ends_in_scan(recorded, a, says.property)) continue;
      const std::uint32_t line = log.frames[a.frames[0]].line;
      if (b.count == 0) {
        if (says.property != Property::Tact && !at_an_edge(emulated, r, a.puck))
          differ(of, line,
                 fmt::format("{} answers {}, the emulated one says nothing", name(a.puck),
                             property_word(says.property)));
      } else if (std::string how = compare(recorded, a, emulated, b, says.property); !how.empty()) {
        differ(of, line, fmt::format("{} {}: {}", name(a.puck), property_word(says.property), how));
      }
    }
  }
  for (const std::uint32_t i : then.unasked) {
    const auto answer = read_answer(log.frames[i].frame);
    PropertyComparison& of = properties[answer->property];
    of.property = answer->property;
    differ(of, log.frames[i].line,
           fmt::format("{} answers {}, which was not asked", name(answer->puck),
                       property_word(answer->property)));
  }
  for (auto& [property, of] : properties) {
    finish(of.recorded, recorded_ms[property]);
    finish(of.emulated, emulated_ms[property]);
    if (of.recorded.asked >= 3 && of.recorded.answered == 0 && of.emulated.answered > 0)
      differ(
          of, 0,
          fmt::format("{} is never answered in the log, the emulated hand answers", property_word(property)));
    replay.properties.push_back(of);
  }
  std::stable_sort(replay.differences.begin(), replay.differences.end(),
                   [](const auto& a, const auto& b) { return a.line < b.line; });
  return replay;
}

namespace {

std::string differences_text(const std::vector<ReplayDifference>& differences, std::uint64_t more) {
  std::string t;
  for (const ReplayDifference& d : differences)
    t += d.line > 0 ? fmt::format("  line {:<7} {}\n", d.line, d.words) : fmt::format("  {}\n", d.words);
  if (more > 0) t += fmt::format("  and {} more\n", more);
  return t;
}

std::string range_text(const AnswerForm& f) {
  return f.lowest ? fmt::format("{}..{}", *f.lowest, *f.highest) : std::string("-");
}

}  // namespace

std::string replay_text(const std::optional<hal::DriverReplay>& driver, const std::string& why,
                        const EmulatorReplay& emulator) {
  std::string t;
  if (!driver) {
    t += fmt::format("driver    not asked: {}\n", why);
  } else {
    t += fmt::format(
        "driver    {}: {} calls, {} questions, {} settings in {:.1f} s; {} renewals more or less\n",
        driver->equal() ? "says what was recorded" : "DIFFERS from the recording", driver->calls,
        driver->questions, driver->settings, driver->recorded_s, driver->repeats);
    t += differences_text(driver->differences, driver->more);
  }
  t += fmt::format("emulator  {}\n", emulator.equal() ? "answers in the form of the recording"
                                                      : "DIFFERS in form from the recording");
  t += differences_text(emulator.differences, emulator.more);
  t += "\nproperty      answered       values                         ms, median and worst\n";
  t += "          recorded emulated  recorded       emulated        recorded        emulated\n";
  for (const PropertyComparison& p : emulator.properties)
    t +=
        fmt::format("{:8} {:>9} {:>8}  {:14} {:14} {:5.2f} {:7.2f}   {:5.2f} {:7.2f}{}\n",
                    property_word(p.property), fmt::format("{}/{}", p.recorded.answered, p.recorded.asked),
                    fmt::format("{}/{}", p.emulated.answered, p.emulated.asked), range_text(p.recorded),
                    range_text(p.emulated), p.recorded.median_ms, p.recorded.worst_ms, p.emulated.median_ms,
                    p.emulated.worst_ms, p.differences > 0 ? fmt::format("   {} differ", p.differences) : "");
  return t;
}

std::string replay_document(const std::string& file, const std::optional<hal::DriverReplay>& driver,
                            const std::string& why, const EmulatorReplay& emulator) {
  using Json = nlohmann::ordered_json;
  const auto list = [](const std::vector<ReplayDifference>& differences) {
    Json all = Json::array();
    for (const ReplayDifference& d : differences) all.push_back({{"line", d.line}, {"because", d.words}});
    return all;
  };
  const auto form = [](const AnswerForm& f) {
    Json j = {{"asked", f.asked}, {"answered", f.answered}, {"lowest", nullptr}, {"highest", nullptr}};
    if (f.lowest) j["lowest"] = *f.lowest, j["highest"] = *f.highest;
    j["median_ms"] = f.median_ms;
    j["worst_ms"] = f.worst_ms;
    return j;
  };
  Json j = {{"schema", "colift.hal.hand/1"}, {"verb", "replay"}, {"file", file}};
  j["equal"] = (!driver || driver->equal()) && emulator.equal();
  j["driver"] = nullptr;
  if (driver)
    j["driver"] = {{"equal", driver->equal()},
                   {"calls", driver->calls},
                   {"questions", driver->questions},
                   {"settings", driver->settings},
                   {"repeats", driver->repeats},
                   {"recorded_s", driver->recorded_s},
                   {"differences", list(driver->differences)},
                   {"more", driver->more}};
  else
    j["driver_because"] = why;
  j["emulator"] = {{"equal", emulator.equal()},
                   {"differences", list(emulator.differences)},
                   {"more", emulator.more},
                   {"properties", Json::array()}};
  for (const PropertyComparison& p : emulator.properties)
    j["emulator"]["properties"].push_back({{"name", property_word(p.property)},
                                           {"recorded", form(p.recorded)},
                                           {"emulated", form(p.emulated)},
                                           {"differences", p.differences}});
  return j.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

}  // namespace colift::tools
