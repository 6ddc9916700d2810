#pragma once

#include <algorithm>
#include <array>
#include <cstddef>

#include "planner/grasp_candidate.hpp"
#include "tools/visualization/canvas.hpp"

namespace colift::picture {

// Hues of Okabe and Ito (2008, "Color Universal Design"), told apart with any common colour blindness. A
// verdict also has a shape of its own, so that print in grey still says it.
inline constexpr Colour kInk = rgb(0x1D2530);
inline constexpr Colour kSoftInk = rgb(0x5A6573);
inline constexpr Colour kRule = rgb(0xD9DEE4);
inline constexpr Colour kPaper = rgb(0xFFFFFF);
inline constexpr Colour kPanel = rgb(0xF6F7F9);
inline constexpr Colour kWhite = rgb(0xFFFFFF);

inline constexpr Colour kMissing = rgb(0x20262E);  ///< No depth.
inline constexpr Colour kGround = rgb(0xA9C6CC);
inline constexpr Colour kTarget = rgb(0xF2CC60);
inline constexpr Colour kTargetRim = rgb(0x7A5500);
inline constexpr Colour kSurface = rgb(0x4B3200);
inline constexpr Colour kCog = rgb(0xE69F00);
inline constexpr Colour kPartner = rgb(0x0072B2);
inline constexpr Colour kRobot = rgb(0x009E73);
inline constexpr Colour kOptimum = rgb(0x111111);
inline constexpr Colour kAxisX = rgb(0xE0302A);
inline constexpr Colour kAxisY = rgb(0x1FA544);
inline constexpr Colour kAxisZ = rgb(0x2457E6);

enum class MarkShape { Disc, Cross, Ring, Square, Triangle, Diamond, Dotted };

/// How a verdict looks and what it is called, here and in the JSON documents.
struct VerdictStyle {
  planner::Verdict verdict;
  const char* name;     ///< As in the JSON: "too-wide".
  const char* meaning;  ///< For people: "wider than the hand opens".
  Colour colour;
  MarkShape shape;
};

inline constexpr std::array<VerdictStyle, 8> kVerdicts{{
    {planner::Verdict::Chosen, "chosen", "chosen", kRobot, MarkShape::Disc},
    {planner::Verdict::Ok, "ok", "possible", kRobot, MarkShape::Disc},
    {planner::Verdict::Collision, "collision", "hand would collide", rgb(0xD55E00), MarkShape::Cross},
    {planner::Verdict::TooWide, "too-wide", "too wide for the hand", rgb(0xCC79A7), MarkShape::Square},
    {planner::Verdict::Unstable, "unstable", "would slip", rgb(0x8C510A), MarkShape::Triangle},
    {planner::Verdict::OverLimit, "over-limit", "over a load limit", rgb(0x5E3C99), MarkShape::Diamond},
    {planner::Verdict::NearPartner, "near-partner", "too near the partner", rgb(0x3AA0DA), MarkShape::Dotted},
    {planner::Verdict::Unreachable, "unreachable", "out of reach", rgb(0x7F868D), MarkShape::Ring},
}};

[[nodiscard]] constexpr const VerdictStyle& style_of(planner::Verdict verdict) {
  for (const VerdictStyle& style : kVerdicts)
    if (style.verdict == verdict) return style;
  return kVerdicts[1];
}

/// The mark of a candidate.
void draw_mark(Canvas& canvas, const Px& at, double radius, MarkShape shape, const Colour& colour);

/// The ball of a centre of gravity or of the partner's grasp.
void draw_ball(Canvas& canvas, const Px& at, double radius, const Colour& colour);

/// The small cross of the closed-form optimum.
void draw_optimum(Canvas& canvas, const Px& at, double radius);

/// A depth as red, green and blue, 0 to 255: near is bright, what was not seen dark blue.
[[nodiscard]] inline std::array<double, 3> depth_rgb(double depth_m) {
  if (!(depth_m > 0.0)) return {0, 0, 60};
  const double grey = std::clamp(255.0 * (1.0 / depth_m - 0.15), 20.0, 255.0);
  return {grey, grey, grey};
}

}  // namespace colift::picture
