#include "tools/visualization/scene/side_panel.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "tools/visualization/labels.hpp"
#include "tools/visualization/palette.hpp"
#include "tools/visualization/scene/frame_raster.hpp"
#include "tools/visualization/scene/scene_marks.hpp"

namespace colift::picture {
namespace {

const TextStyle kTitle{.size = 25, .colour = kInk, .bold = true};
const TextStyle kBody{.size = 18, .colour = kInk};
const TextStyle kSmall{.size = 16, .colour = kInk};
const TextStyle kName{.size = 16, .colour = kSoftInk};
const TextStyle kHeading{.size = 15, .colour = kSoftInk, .bold = true};

// Reasons are parts of sentences; on their own they begin like one.
std::string capitalised(std::string words) {
  if (!words.empty() && words[0] >= 'a' && words[0] <= 'z')
    words[0] = static_cast<char>(words[0] - 'a' + 'A');
  return words;
}

// Lines of text from y downwards; returns the y beneath them.
double paragraph(Canvas& canvas, const Box& area, double y, const std::string& words, const TextStyle& style,
                 bool draw) {
  const double pitch = 1.35 * style.size;
  for (const std::string& line : canvas.wrap(words, area.width, style)) {
    if (draw) canvas.text({area.x, y + style.size}, line, style);
    y += pitch;
  }
  return y;
}

double share_bars(Canvas& canvas, const Box& area, double y, double robot, bool draw) {
  if (!draw) return y + 74;
  struct Bar {
    const char* name;
    double part;
    Colour colour;
  };
  for (const Bar& bar : {Bar{"partner", 1.0 - robot, kPartner}, Bar{"robot", robot, kRobot}}) {
    constexpr double kNameWidth = 78, kNumberWidth = 62, kHeight = 22;
    const double length = area.width - kNameWidth - kNumberWidth;
    canvas.text({area.x, y + 17}, bar.name, kSmall);
    canvas.fill(Box{area.x + kNameWidth, y, length, kHeight}, kRule, 4);
    const double part = std::clamp(bar.part, 0.0, 1.0);
    if (part > 0.001)
      canvas.fill(Box{area.x + kNameWidth, y, std::max(3.0, part * length), kHeight}, bar.colour, 4);
    TextStyle number = kBody;
    number.bold = true;
    number.align = Align::Right;
    canvas.text({area.right(), y + 18}, fmt::format("{:.0f} %", 100 * bar.part), number);
    y += 34;
  }
  return y + 6;
}

std::string plural(std::size_t count, const char* one, const char* many) {
  return fmt::format("{} {}", count_text(count), count == 1 ? one : many);
}

std::string two_sigma(const Eigen::Matrix3d& covariance) {
  const double largest = covariance.diagonal().maxCoeff();
  return largest > 0 ? fmt::format(" ± {} (2σ)", length_text(2 * std::sqrt(largest))) : "";
}

using Rows = std::vector<std::pair<std::string, std::string>>;

Rows key_figures(const ScenePicture& what) {
  Rows rows;
  const bool ground = what.scene && what.scene->ground;
  if (ground && what.cloud)
    rows.emplace_back(
        "camera",
        length_text(what.scene->ground->plane.height(what.cloud->X_WC.translation())) + " above the ground");
  const perception::Target* target = target_of(what);
  if (target) {
    const Vec3& size = target->obb.size;
    rows.emplace_back("target", fmt::format("{} × {} × {} cm", centimetres(size.x()), centimetres(size.y()),
                                            centimetres(size.z())));
    rows.emplace_back("seen", plural(target->points.empty() ? target->pixels.size() : target->points.size(),
                                     "point", "points"));
  }
  if (what.scene && !what.scene->surfaces.empty()) {
    std::size_t faces = 0;
    for (const perception::Surface& s : what.scene->surfaces)
      faces += std::holds_alternative<perception::Rectangle>(s);
    const std::size_t bars = what.scene->surfaces.size() - faces;
    std::string words = faces ? plural(faces, "rectangle", "rectangles") : "";
    if (bars) words += (faces ? ", " : "") + plural(bars, "cylinder", "cylinders");
    rows.emplace_back("surfaces", words);
  }
  if (target)
    rows.emplace_back("centre of gravity",
                      (ground ? length_text(what.scene->ground->plane.height(target->cog)) + " high" : "") +
                          two_sigma(target->cog_covariance));
  if (what.partner)
    rows.emplace_back("partner",
                      (what.partner->points ? plural(what.partner->points, "point", "points") : "given") +
                          two_sigma(what.partner->covariance));
  if (const planner::GraspCandidate* chosen = chosen_of(what))
    rows.emplace_back("grasp width", length_text(chosen->width));
  rows.insert(rows.end(), what.figures.begin(), what.figures.end());
  return rows;
}

double figure_rows(Canvas& canvas, const Box& area, double y, const Rows& rows, bool draw) {
  constexpr double kNameWidth = 160;
  for (const auto& [name, value] : rows) {
    const Box left{area.x, y, kNameWidth - 10, 0}, right{area.x + kNameWidth, y, area.width - kNameWidth, 0};
    y = std::max(paragraph(canvas, left, y, name, kName, draw),
                 paragraph(canvas, right, y, value, kSmall, draw)) +
        3;
  }
  return y;
}

// ---- legend
// ------------------------------------------------------------------------------------------------------

struct Item {
  std::string words;
  std::function<void(Canvas&, const Px&)> draw;
};

Item swatch(std::string words, const Colour& inside, const Colour& rim) {
  return {std::move(words), [=](Canvas& c, const Px& at) {
            c.fill(Box{at.x() - 11, at.y() - 8, 22, 16}, inside, 2);
            c.outline(Box{at.x() - 11, at.y() - 8, 22, 16}, {.colour = rim, .width = 1.5}, 2);
          }};
}

void gripper_icon(Canvas& c, const Px& at) {
  const Stroke limb{.colour = kInk, .width = 2.6};
  c.polyline({at + Px(-8, 9), at + Px(-8, -1), at + Px(8, -1), at + Px(8, 9)}, false, limb);
  c.line(at + Px(0, -1), at + Px(0, -9), limb);
  draw_mark(c, at + Px(0, 5), 3.6, MarkShape::Disc, kRobot);
}

std::vector<Item> verdict_items(const ScenePicture& what) {
  std::vector<Item> items;
  if (!what.candidates) return items;
  for (const VerdictStyle& style : kVerdicts) {
    const auto count = static_cast<std::size_t>(
        std::count_if(what.candidates->begin(), what.candidates->end(),
                      [&](const planner::GraspCandidate& c) { return c.verdict == style.verdict; }));
    if (!count) continue;
    if (style.verdict == planner::Verdict::Chosen)
      items.push_back({fmt::format("{} chosen", count), gripper_icon});
    else
      items.push_back(
          {fmt::format("{} {}", count_text(count), style.meaning),
           [&style](Canvas& c, const Px& at) { draw_mark(c, at, 6, style.shape, style.colour); }});
  }
  if (items.empty())
    items.push_back({"no grasp candidates",
                     [](Canvas& c, const Px& at) { draw_mark(c, at, 6, MarkShape::Ring, kSoftInk); }});
  return items;
}

std::vector<Item> scene_items(const ScenePicture& what) {
  std::vector<Item> items;
  const perception::Target* target = target_of(what);
  if (what.cloud && chosen_of(what)) {
    items.push_back({"hand: x, y closing, z approach", [](Canvas& c, const Px& at) {
                       c.line(at + Px(-11, -6), at + Px(11, -6), {.colour = kAxisX, .width = 3.4});
                       c.line(at + Px(-11, 0), at + Px(11, 0), {.colour = kAxisY, .width = 3.4});
                       c.line(at + Px(-11, 6), at + Px(11, 6), {.colour = kAxisZ, .width = 3.4});
                     }});
  }
  if (what.partner)
    items.push_back({"partner's grasp", [](Canvas& c, const Px& at) { draw_ball(c, at, 7, kPartner); }});
  if (what.cloud && !what.partner_pixels.empty())
    items.push_back(swatch("changed since the reference", rgb(0x7DB8E8), rgb(0x0B4F86)));
  if (target)
    items.push_back({"centre of gravity, 2σ", [](Canvas& c, const Px& at) {
                       Eigen::Matrix2d half;
                       half << 12, 0, 0, 9;
                       c.ellipse(at, half, kCog.with_alpha(0.3), {.colour = kCog, .width = 1.6});
                       draw_ball(c, at, 5, kCog);
                     }});
  if (what.optimum)
    items.push_back({"best for the load, anywhere", [](Canvas& c, const Px& at) { draw_optimum(c, at, 7); }});
  if (target) items.push_back(swatch("target", kTarget, kTargetRim));
  if (what.scene && !what.scene->surfaces.empty())
    items.push_back({"surface", [](Canvas& c, const Px& at) {
                       c.outline(Box{at.x() - 11, at.y() - 7, 22, 14}, {.colour = kSurface, .width = 1.2});
                       for (const double s : {-1.0, 1.0})
                         c.polyline({at + s * Px(11, 2), at + s * Px(11, 7), at + s * Px(6, 7)}, false,
                                    {.colour = kSurface, .width = 2.8});
                     }});
  if (target && (target->shape.size - target->obb.size).norm() > 0.005)
    items.push_back({"completed shape", [](Canvas& c, const Px& at) {
                       c.outline(Box{at.x() - 11, at.y() - 7, 22, 14},
                                 {.colour = kTargetRim, .width = 1.4, .dashes = {5, 4}});
                     }});
  if (what.scene && what.scene->ground) {
    const double height = what.cloud ? what.scene->ground->plane.height(what.cloud->X_WC.translation()) : 1.0;
    items.push_back(
        {fmt::format("ground, grid {:.0f} cm", 100 * grid_step_m(height)), [](Canvas& c, const Px& at) {
           c.fill(Box{at.x() - 11, at.y() - 8, 22, 16}, kGround, 2);
           c.line(at + Px(-11, 1), at + Px(11, 1), {.colour = kWhite, .width = 1.4});
           c.line(at + Px(2, -8), at + Px(2, 8), {.colour = kWhite, .width = 1.4});
         }});
  }
  if (what.cloud) items.push_back(swatch("no depth", kMissing, kMissing));
  return items;
}

// Items in columns of equal width, as many as fit; returns the y beneath.
double item_grid(Canvas& canvas, const Box& area, double y, const std::vector<Item>& items, bool draw) {
  if (items.empty()) return y;
  constexpr double kIcon = 34, kGap = 26, kPitch = 30;
  double widest = 0;
  for (const Item& item : items) widest = std::max(widest, canvas.text_width(item.words, kSmall));
  const double column = std::min(area.width, kIcon + widest + kGap);
  const auto columns = std::max<std::size_t>(1, static_cast<std::size_t>((area.width + kGap) / column));
  for (std::size_t i = 0; i < items.size(); ++i) {
    const Px at(area.x + column * static_cast<double>(i % columns),
                y + kPitch * static_cast<double>(i / columns));
    if (!draw) continue;
    items[i].draw(canvas, at + Px(14, kPitch / 2));
    canvas.text(at + Px(kIcon, kPitch / 2 + 5.5), items[i].words, kSmall);
  }
  return y + kPitch * static_cast<double>((items.size() + columns - 1) / columns);
}

}  // namespace

double draw_panel(Canvas& canvas, const Box& area, const ScenePicture& what, bool draw) {
  double y = area.y;
  if (!what.title.empty()) y = paragraph(canvas, area, y, what.title, kTitle, draw) + 8;
  if (!what.reason.empty()) y = paragraph(canvas, area, y, capitalised(what.reason), kBody, draw) + 12;
  if (what.share) {
    y = paragraph(canvas, area, y, "LOAD SHARE", kHeading, draw) + 4;
    y = share_bars(canvas, area, y, *what.share, draw) + 4;
  }
  if (const Rows rows = key_figures(what); !rows.empty()) {
    y = paragraph(canvas, area, y, "KEY FIGURES", kHeading, draw) + 4;
    y = figure_rows(canvas, area, y, rows, draw) + 8;
  }
  return y;
}

double draw_legend(Canvas& canvas, const Box& area, const ScenePicture& what, bool draw) {
  double y = area.y;
  std::vector<Item> items = verdict_items(what);
  for (Item& item : scene_items(what)) items.push_back(std::move(item));
  y = item_grid(canvas, area, y, items, draw);
  if (what.notes.empty()) return y;
  y += 10;
  for (const std::string& note : what.notes) {
    if (draw) canvas.disc({area.x + 14, y + 11}, 2.6, kSoftInk);
    y = paragraph(canvas, Box{area.x + 34, y, area.width - 34, 0}, y, capitalised(note), kSmall, draw) + 2;
  }
  return y;
}

}  // namespace colift::picture
