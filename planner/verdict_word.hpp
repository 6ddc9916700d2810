#pragma once

#include "planner/grasp_candidate.hpp"

namespace colift::planner {

/// "chosen", "near-partner", ...: the words of all of CoLift's documents.
[[nodiscard]] constexpr const char* verdict_word(Verdict verdict) {
  switch (verdict) {
    case Verdict::Ok:
      return "ok";
    case Verdict::Chosen:
      return "chosen";
    case Verdict::Collision:
      return "collision";
    case Verdict::Unreachable:
      return "unreachable";
    case Verdict::TooWide:
      return "too-wide";
    case Verdict::Unstable:
      return "unstable";
    case Verdict::OverLimit:
      return "over-limit";
    case Verdict::NearPartner:
      return "near-partner";
  }
  return "?";
}

}  // namespace colift::planner
