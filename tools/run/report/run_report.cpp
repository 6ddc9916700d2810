#include "tools/run/report/run_report.hpp"

#include <fmt/format.h>

#include <cmath>
#include <span>

#include "hal/types/units.hpp"
#include "tools/analyse/grasp_rows.hpp"
#include "tools/run/report/run_film.hpp"
#include "tools/run/report/run_pictures.hpp"
#include "tools/run/run_text.hpp"
#include "tools/visualization/file_output.hpp"
#include "tools/visualization/report/report_parts.hpp"

namespace colift::tools {
namespace {

using control::Task;
using picture::ReportTone;

ReportTone tone_of(control::RunRecord::Result outcome) {
  return outcome == control::RunRecord::Result::Lifted ? ReportTone::Good : ReportTone::Bad;
}

ReportTone tone_of(Task state) {
  switch (state) {
    case Task::Done:
      return ReportTone::Good;
    case Task::Refused:
    case Task::Aborted:
    case Task::Stopped:
      return ReportTone::Bad;
    case Task::BackOff:
    case Task::Contact:
    case Task::Halt:
    case Task::Pause:
    case Task::Yield:
      return ReportTone::Odd;
    default:
      return ReportTone::Plain;
  }
}

std::string capitalised(std::string text) {
  if (!text.empty() && text[0] >= 'a' && text[0] <= 'z') text[0] = static_cast<char>(text[0] - 'a' + 'A');
  return text;
}

std::string sentence(const std::string& text) {
  return text.empty() ? "" : capitalised(text) + (text.back() == '.' ? "" : ".");
}

std::vector<std::string> summary(const RunView& view) {
  const control::RunRecord& r = view.record;
  std::vector<std::string> out{sentence(r.reason)};
  if (r.hand_keeps_grip)
    out.emplace_back("The hand still holds the object: take its weight before the hand is opened.");
  // a refusal's reason is said already
  if (r.decision && r.reason.find(r.decision->decision.reason) == std::string::npos)
    out.push_back(sentence(r.decision->decision.reason));
  if (r.decision && !r.decision->share.text.empty()) {
    if (!r.decision->share.wanted) out.push_back(sentence(r.decision->share.text));
    out.push_back(sentence(r.decision->share.partner_text));
    if (r.decision->share.certificate) {
      out.push_back(sentence(r.decision->share.certificate->text));
      if (!r.decision->share.certificate->breaches.empty())
        out.push_back(sentence(r.decision->share.certificate->breach_text));
    }
  }
  if (r.camera_correction && r.camera_correction->applied())
    out.push_back(sentence(r.camera_correction->reason));
  if (r.monitor.on && r.monitor.stops > 0)
    out.push_back(fmt::format("The arm stopped {} times for somebody near it and waited {:.1f} s.",
                              r.monitor.stops, r.monitor.waited_s));
  if (r.device_failed) out.emplace_back("A device was lost; its faults are listed below.");
  return out;
}

std::vector<picture::ReportCard> cards(const RunView& view) {
  std::vector<picture::ReportCard> out;
  const control::RunRecord& r = view.record;
  const auto truth = true_lift(view);
  const auto note = [&](double value, auto text) {
    return truth ? fmt::format("truth {}", text(value)) : std::string();
  };
  if (r.lift) {
    const control::LiftSummary& l = *r.lift;
    out.push_back({metres_text(l.height_m), "lifted", note(truth ? truth->height_m : 0, metres_text)});
    out.push_back({percent_text(l.share_robot), "carried by the robot",
                   fmt::format("{}predicted {}{}",
                               l.load ? fmt::format("{:.0f} to {:.0f} %, ", 100 * l.load->share_95.low,
                                                    100 * l.load->share_95.high)
                                      : "",
                               percent_text(l.share_predicted),
                               truth ? fmt::format(", truth {}", percent_text(truth->share_robot)) : "")});
    out.push_back(
        {degrees_text(l.tilt_rad), "tilt at the top",
         fmt::format("{}limit {}", truth ? fmt::format("truth {}, ", degrees_text(truth->tilt_rad)) : "",
                     degrees_text(view.setting.max_tilt_rad))});
    out.push_back({metres_text(l.slip_m), "slip in the hand", note(truth ? truth->slip_m : 0, metres_text)});
    out.push_back({std::isfinite(l.mass_kg) ? fmt::format("{:.2f} kg", l.mass_kg) : "unknown",
                   "estimated mass",
                   fmt::format("{}{}",
                               l.load ? fmt::format("{:.1f} to {:.1f} kg, from {}", l.load->mass_95.low,
                                                    l.load->mass_95.high, control::word(l.load->source))
                                      : "",
                               view.truth ? fmt::format(", truth {:.2f} kg", view.truth->mass_kg) : "")});
  }
  if (const auto error = partner_error_m(view))
    out.push_back({metres_text(*error), "partner's grasp off", "observed against truth"});
  if (r.timing.grasp_to_decision_s)
    out.push_back({fmt::format("{:.0f} ms", 1e3 * *r.timing.grasp_to_decision_s), "from grasp to decision",
                   fmt::format("{:.1f} ms of computing", r.timing.decision_compute_ms)});
  return out;
}

std::vector<picture::ReportStep> time_line(const control::RunRecord& record) {
  std::vector<picture::ReportStep> steps;
  for (std::size_t i = 0; i < record.states.size(); ++i) {
    const control::StateChange& s = record.states[i];
    const double from = hal::seconds(s.at);
    double to = from;
    if (i + 1 < record.states.size())
      to = hal::seconds(record.states[i + 1].at);
    else if (!control::is_end(s.state))
      to = std::max(from, record.timing.sim_s);
    steps.push_back({from, to, std::string(control::word(s.state)), s.reason, tone_of(s.state)});
  }
  return steps;
}

picture::ReportTable judge_table(const RunView& view) {
  picture::ReportTable table{"Judge of the simulation", {"question", "verdict"}, {}};
  if (!view.truth || !view.truth->verdict) return table;
  const sim_hal::Verdict& v = *view.truth->verdict;
  const auto distance = [](const std::optional<double>& m) { return m ? metres_text(*m) : "nobody"; };
  table.rows.push_back({"nearest to the robot", distance(v.min_distance_m)});
  table.rows.push_back({"partner's nearest to the robot", distance(v.partner_distance_m)});
  for (const std::string& breach : v.breaches) table.rows.push_back({"breach", breach});
  if (v.breaches.empty())
    table.rows.push_back({"breaches", fmt::format("none; judged: {}", fmt::join(v.judged, ", "))});
  for (const auto& [name, why] : v.not_judged) table.rows.push_back({name + " not judged", why});
  return table;
}

picture::ReportTable contact_table(const RunView& view) {
  picture::ReportTable table{
      "Contacts with people", {"time", "who", "region", "by", "force", "limit", "clamped"}, {}};
  if (!view.truth || !view.truth->verdict) return table;
  for (const sim_hal::JudgedContact& c : view.truth->verdict->contacts)
    table.rows.push_back({fmt::format("{:.3f} s", c.t_s),
                          c.person < 0 ? "partner" : fmt::format("person {}", c.person), c.region,
                          c.his_own ? c.by + ", which did not come towards him" : c.by,
                          fmt::format("{:.0f} N", c.force_n), fmt::format("{:.0f} N", c.limit_n),
                          fmt::format("{:.2f} s", c.clamped_s)});
  return table;
}

picture::ReportTable truth_table(const RunView& view) {
  picture::ReportTable table{"Truth against estimate", {"quantity", "estimate", "truth", "difference"}, {}};
  if (!view.truth) return table;
  const control::RunRecord& r = view.record;
  const auto row = [&](const char* name, double estimate, double truth, const char* pattern) {
    const auto text = [&](double v) {
      return std::isfinite(v) ? fmt::format(fmt::runtime(pattern), v + 0.0) : std::string("–");
    };
    const double off = estimate - truth;
    table.rows.push_back(
        {name, text(estimate), text(truth), fmt::format("{}{}", off > 0 ? "+" : "", text(off))});
  };
  if (r.lift) {
    row("mass", r.lift->mass_kg, view.truth->mass_kg, "{:.2f} kg");
    if (const auto top = true_lift(view)) {
      row("robot's share at the top", 100 * r.lift->share_robot, 100 * top->share_robot, "{:.1f} %");
      row("predicted share", 100 * r.lift->share_predicted, 100 * top->share_robot, "{:.1f} %");
      row("height", 100 * r.lift->height_m, 100 * top->height_m, "{:.2f} cm");
      row("tilt", hal::rad_to_deg(r.lift->tilt_rad), hal::rad_to_deg(top->tilt_rad), "{:.2f}°");
      row("slip", 1e3 * r.lift->slip_m, 1e3 * top->slip_m, "{:.1f} mm");
    }
  }
  const auto place = [&](const char* name, const hal::Vec3& estimate, const hal::Vec3& truth) {
    table.rows.push_back({name, place_text(estimate), place_text(truth),
                          fmt::format("{:.1f} mm", 1e3 * (estimate - truth).norm())});
  };
  if (r.decision && r.decision->partner && view.truth->partner)
    place("partner's grasp", r.decision->partner->position, *view.truth->partner);
  if (r.analysis && r.analysis->scene.target)
    place("centre of gravity", r.analysis->scene.target->cog, view.truth->cog);
  return table;
}

std::vector<picture::ReportTime> times(const control::RunRecord& r) {
  std::vector<picture::ReportTime> out;
  if (r.analysis) {
    const control::StageTimes& ms = r.analysis->ms;
    out = {{"ground", ms.ground},
           {"target", ms.target},
           {"surfaces", ms.surfaces},
           {"candidates", ms.candidates}};
  }
  if (r.decision) {
    out.push_back({"partner observed", r.decision->partner_ms});
    out.push_back({"decision", r.decision->decision_ms});
  }
  if (r.plan) {
    out.push_back({"path found", r.plan->plan_ms});
    out.push_back({"path shortened", r.plan->shortcut_ms});
    out.push_back({"exact check", r.plan->exact_ms});
  }
  return out;
}

std::vector<std::pair<std::string, std::string>> facts(const RunView& view) {
  const control::RunRecord& r = view.record;
  const RunSetting& s = view.setting;
  std::vector<std::pair<std::string, std::string>> out;
  if (!s.scenario.empty()) out.emplace_back("scenario", s.scenario);
  out.emplace_back("robot", s.robot);
  out.emplace_back("method", s.method);
  if (s.simulated) out.emplace_back("seed", std::to_string(s.seed));
  if (s.share) out.emplace_back("share wanted of the robot", percent_text(*s.share));
  out.emplace_back("lift", fmt::format("{} high, held {:.1f} s", metres_text(s.lift_height_m), s.hold_s));
  out.emplace_back("limits",
                   fmt::format("tilt {}, slip {}", degrees_text(s.max_tilt_rad), metres_text(s.max_slip_m)));
  if (s.dry_run) out.emplace_back("dry run", "decided and planned only, nothing was moved");
  if (r.timing.grasp_to_decision_s)
    out.emplace_back("grasp to decision",
                     fmt::format("{:.3f} s, of it {:.2f} ms of computing", *r.timing.grasp_to_decision_s,
                                 r.timing.decision_compute_ms));
  if (r.plan)
    out.emplace_back(
        "plan", fmt::format("{:.1f} ms; trajectory {:.1f} s, of it the straight approach {:.1f} s",
                            r.timing.plan_ms, r.plan->transit.duration_s(), r.plan->approach.duration_s()));
  if (s.simulated) {
    out.emplace_back("simulated time", fmt::format("{:.1f} s", r.timing.sim_s));
    out.emplace_back("time it took", r.timing.wall_s > 0
                                         ? fmt::format("{:.1f} s, {:.1f} times real time", r.timing.wall_s,
                                                       r.timing.sim_s / r.timing.wall_s)
                                         : std::string("unknown"));
  } else {
    out.emplace_back("time it took", fmt::format("{:.1f} s", r.timing.wall_s));
  }
  return out;
}

// What the camera saw when it was decided, else the scene before anybody came.
std::string decision_picture(const RunView& view) {
  const control::RunRecord& r = view.record;
  if (!r.analysis) return "";
  const control::SceneAnalysis& analysis = *r.analysis;
  perception::OrganisedCloud with_partner;
  picture::ScenePicture p;
  p.cloud = &analysis.cloud;
  p.rgb = &analysis.frame.rgb;
  p.scene = &analysis.scene;
  p.candidates = &analysis.candidates;
  p.hand_opening_m = view.setting.hand_opening_m;
  p.palm_gap_m = view.setting.palm_gap_m;
  p.title = view.setting.scenario.empty() ? view.setting.robot : view.setting.scenario;
  p.reason = analysis.reason;
  if (r.decision) {
    p.candidates = &r.decision->candidates;
    p.partner = r.decision->partner;
    p.partner_pixels = r.decision->partner_pixels;
    p.reason = r.decision->decision.reason;
    if (r.decision->decision.chosen) {
      p.share = r.decision->decision.share;
      p.optimum = r.decision->decision.optimum;
    }
    p.notes.push_back(r.decision->partner_reason);
    if (r.frame_partner && r.frame_partner->depth_m.size() == analysis.cloud.size() &&
        r.frame_partner->intrinsics.width == analysis.cloud.width()) {
      with_partner = perception::deproject(*r.frame_partner, analysis.cloud.X_WC);
      p.cloud = &with_partner;
      p.rgb = &r.frame_partner->rgb;
    }
  }
  if (analysis.scene.target) p.notes.push_back(analysis.scene.target->reason);
  p.figures.emplace_back("method", view.setting.method);
  if (p.cloud->size() == 0) return "";
  const char* caption =
      p.partner
          ? "What the camera saw when it was decided: the object, every candidate, where the partner holds "
            "it, and the grasp that was chosen."
          : "What the camera saw before anybody came: the object and every candidate.";
  return picture::report_heading("Scene and decision") +
         picture::report_figure({picture::scene_picture_png(p), caption});
}

std::string lift_pictures(const RunView& view) {
  constexpr int kWidth = 960, kHeight = 640;
  const DrawnScenes scenes = drawn_scenes(view);
  const std::string how =
      scenes.seen_only ? ", drawn from what was seen and planned" : ", as the simulation knows it";
  std::vector<picture::ReportPicture> space;
  if (scenes.before)
    space.push_back({space_picture(view, *scenes.before, kWidth, kHeight).png(),
                     (scenes.lifted ? "Before the lift" : "The scene") + how + "."});
  if (scenes.lifted)
    space.push_back({space_picture(view, *scenes.lifted, kWidth, kHeight).png(), "At the top" + how + "."});
  std::string out = picture::report_figures(space);
  if (const auto film = run_film(view))
    out += picture::report_film(
        {film->film, fmt::format("The run from {:.1f} to {:.1f} s, as the simulation knows it.", film->from_s,
                                 film->to_s)},
        film->still);
  if (const auto side = side_picture(view, scenes))
    out += picture::report_figure({side->png(),
                                   "The lift from the side: the dashed line is where the object's top "
                                   "was before."});
  return out.empty() ? "" : picture::report_heading(scenes.lifted ? "The lift" : "The scene") + out;
}

std::vector<std::string> intent_lines(const control::RunRecord& record) {
  std::vector<std::string> out;
  for (const control::Intent& i : record.intents)
    out.push_back(fmt::format("{:.2f} s: {}", hal::seconds(i.at), i.says));
  return out;
}

std::vector<std::string> fault_lines(const control::RunRecord& record) {
  std::vector<std::string> out;
  for (const control::DeviceNote& f : record.faults)
    out.push_back(fmt::format("{:.2f} s, {}: {}", hal::seconds(f.at), f.device, f.what));
  return out;
}

}  // namespace

std::string run_report_html(const RunView& view) {
  const control::RunRecord& r = view.record;
  std::string body;
  if (!r.monitor.on)
    body += picture::report_warning(
        "Speed and separation monitoring was off: nobody near the arm was noticed. The arm moved at T1 "
        "speed.");
  body += picture::report_paragraphs(summary(view));
  body += picture::report_cards(cards(view));
  body += lift_pictures(view);
  body += picture::report_time_line(time_line(r));
  body += decision_picture(view);
  if (r.decision)
    body += picture::report_candidates(candidate_rows(r.decision->candidates, r.decision->decision.scores));
  else if (r.analysis)
    body += picture::report_candidates(candidate_rows(r.analysis->candidates, {}));
  if (const auto grip = grip_sentences(r); !grip.empty()) {
    body += picture::report_heading("Grip") + picture::report_paragraphs(grip);
    if (const auto cells = tactile_picture(r))
      body += picture::report_figure(
          {cells->png(), "Pressure on each cell of the tactile arrays when the grip was judged."});
  }
  if (const auto plot = curves_plot(view))
    body += picture::report_heading("Curves") +
            picture::report_figure({picture::draw_line_plot(*plot).png(),
                                    "Solid: measured by the robot. Dashed: truth, where it is known."});
  if (const auto plot = separation_plot(view))
    body += picture::report_heading("People near the arm") +
            picture::report_figure({picture::draw_line_plot(*plot).png(),
                                    "Distance to the arm or to the rest of its path, as it was seen."});
  body += picture::report_table(truth_table(view));
  body += picture::report_table(judge_table(view));
  body += picture::report_table(contact_table(view));
  if (const auto said = intent_lines(r); !said.empty()) body += picture::report_list("Announced", said);
  const auto faults = fault_lines(r);
  body += picture::report_list("Faults", faults.empty() ? std::vector<std::string>{"None."} : faults);
  body += picture::report_times(times(r));
  body += picture::report_pairs("Facts", facts(view));
  body += picture::report_pairs("Configuration that differs from the defaults", view.setting.config);
  body += picture::report_command(view.setting.command);
  const std::string& of = view.setting.scenario.empty() ? view.setting.robot : view.setting.scenario;
  return picture::report_page("Co-lift: " + of, word(r.outcome), tone_of(r.outcome), body);
}

hal::Result<> write_run_report(const std::filesystem::path& html, const RunView& view) {
  const std::string page = run_report_html(view);
  return picture::write_file(html,
                             std::span(reinterpret_cast<const std::uint8_t*>(page.data()), page.size()));
}

hal::Result<> write_lift_picture(const std::filesystem::path& png, const RunView& view) {
  const DrawnScenes scenes = drawn_scenes(view);
  const auto& scene = scenes.lifted ? scenes.lifted : scenes.before;
  if (!scene)
    return hal::failure(hal::ErrorCode::BadInput, png.string(), "nothing was seen that could be drawn");
  return space_picture(view, *scene, 1280, 800).write_png(png);
}

}  // namespace colift::tools
