#include "tools/analyse/words.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "planner/verdict_word.hpp"

namespace colift::tools {
namespace {

constexpr std::size_t kRefusedShown = 10;

std::string point(const hal::Vec3& p) {
  return fmt::format("({:.3f}, {:.3f}, {:.3f})", p.x(), p.y(), p.z());
}

}  // namespace

const char* word(planner::Verdict verdict) {
  return planner::verdict_word(verdict);  // recordings and documents say the same
}

const char* word(perception::RejectedObject::Kind kind) {
  using Kind = perception::RejectedObject::Kind;
  switch (kind) {
    case Kind::Small:
      return "small";
    case Kind::Flat:
      return "flat";
    case Kind::Far:
      return "far";
    case Kind::Person:
      return "person";
    case Kind::Cut:
      return "cut";
    case Kind::Wall:
      return "wall";
    case Kind::Lesser:
      return "lesser";
    case Kind::Floating:
      return "floating";
    case Kind::Large:
      return "large";
    case Kind::Attached:
      return "attached";
    case Kind::Unsure:
      return "unsure";
  }
  return "?";
}

std::string surface_line(const perception::Surface& s) {
  if (const auto* r = std::get_if<perception::Rectangle>(&s)) {
    return fmt::format("rectangle {:5.1f} x {:5.1f} cm  at {}  facing {}  {:3.0f} % filled",
                       100 * r->size.x(), 100 * r->size.y(), point(r->center), point(r->normal),
                       100 * r->fill);
  }
  const auto& c = std::get<perception::Cylinder>(s);
  return fmt::format("cylinder  radius {:.1f} cm, length {:.1f} cm  at {}  along {}", 100 * c.radius,
                     100 * c.length, point(c.center), point(c.axis));
}

std::string look_text(const Seen& seen) {
  const control::SceneAnalysis& l = seen.analysis;
  std::string text =
      fmt::format("{} of {} points seen; {}\n", seen.file.valid_points, seen.file.points, seen.file.note);
  if (l.scene.ground) {
    const auto& g = *l.scene.ground;
    text += fmt::format("ground    normal {}, offset {:.3f} m, {:.1f} mm rms\n", point(g.plane.normal),
                        g.plane.offset, 1e3 * g.rms_m);
  }
  if (l.scene.target) {
    const auto& t = *l.scene.target;
    text +=
        fmt::format("target    {:.1f} x {:.1f} x {:.1f} cm visible at {}, {} points\n", 100 * t.obb.size.x(),
                    100 * t.obb.size.y(), 100 * t.obb.size.z(), point(t.obb.center), t.points.size());
    text += fmt::format("          {}\n", t.reason);
    const hal::Vec3 s = t.cog_covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
    text += fmt::format("centre of gravity {} +- ({:.0f}, {:.0f}, {:.0f}) mm\n", point(t.cog), 1e3 * s.x(),
                        1e3 * s.y(), 1e3 * s.z());
    text += fmt::format("surfaces  {}\n", l.scene.surfaces.size());
    constexpr std::size_t kLines = 12;
    for (std::size_t i = 0; i < std::min(kLines, l.scene.surfaces.size()); ++i)
      text += fmt::format("  {:2}  {}\n", i, surface_line(l.scene.surfaces[i]));
    if (l.scene.surfaces.size() > kLines)
      text += fmt::format("  and {} smaller ones\n", l.scene.surfaces.size() - kLines);
  }
  text += l.reason + "\n";
  constexpr std::size_t kShown = 5;
  for (std::size_t i = 0; i < std::min(kShown, l.rejected.size()); ++i)
    text += fmt::format("  not the object at {}: {}\n", point(l.rejected[i].center), l.rejected[i].reason);
  text += fmt::format("took {:.1f} ms: ground {:.1f}, target {:.1f}, surfaces {:.1f}, candidates {:.1f}\n",
                      l.ms.total, l.ms.ground, l.ms.target, l.ms.surfaces, l.ms.candidates);
  return text;
}

std::string decide_text(const control::Outcome& o, const std::optional<control::Suggestion>& suggestion) {
  std::string text;
  if (o.partner)
    text +=
        fmt::format("partner   holds the object at {}: {}\n", point(o.partner->position), o.partner_reason);
  else
    text += fmt::format("partner   {}\n", o.partner_reason);
  if (!o.decision.scores.empty()) {
    text += fmt::format("{:>4}  {:5} {:>12}  {:>6} {:>11}  {}\n", "id", "kind", "verdict", "share", "cost",
                        "position and reason");
    std::size_t refused = 0;
    for (std::size_t i = 0; i < o.candidates.size(); ++i) {
      const auto& c = o.candidates[i];
      const auto& s = o.decision.scores[i];
      const bool free = c.verdict == planner::Verdict::Ok || c.verdict == planner::Verdict::Chosen;
      if (!free && ++refused > kRefusedShown) continue;
      text += fmt::format("{:>4}  {:5} {:>12}  {:>5.0f}% {:>11.3f}  {}{}{}\n", c.id, planner::name_of(c.kind),
                          word(c.verdict), s ? 100 * s->share : std::nan(""), s ? s->cost : std::nan(""),
                          point(c.position), c.reason.empty() ? "" : "  ",
                          c.verdict == planner::Verdict::Chosen ? "<- chosen" : c.reason);
    }
    if (refused > kRefusedShown)
      text += fmt::format("      and {} more refused; --json and --report have them all\n",
                          refused - kRefusedShown);
  }
  text += o.decision.reason + "\n";
  if (!o.share.text.empty()) {
    if (!o.share.wanted) text += "share     " + o.share.text + "\n";
    text += "load      " + o.share.partner_text + "\n";
    if (o.share.certificate) {
      text += "bounds    " + o.share.certificate->text + "\n";
      if (!o.share.certificate->breaches.empty())
        text += "limits    " + o.share.certificate->breach_text + "\n";
    }
  }
  if (suggestion) text += suggestion->reason + "\n";
  return text;
}

}  // namespace colift::tools
