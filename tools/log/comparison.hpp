#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "tools/log/recorded_run.hpp"

namespace colift::tools {

// Two recorded runs held against each other. In every pair the first is of run A, the second of run B.

template <class T>
using Both = std::array<T, 2>;

/// A key of the configuration with two values; nothing: it is not in that recording.
struct ConfigDifference {
  std::string key;
  Both<std::optional<std::string>> value;
};

/// A state that either run was in.
struct StateComparison {
  std::string state;
  Both<std::optional<double>> entered_s;  ///< For the first time.
  Both<double> total_s{};                 ///< Spent in it, all visits.
};

/// One figure of both runs; nothing: not known, or it did not come to that.
struct FigureComparison {
  std::string name, title, unit;
  Both<std::optional<double>> value;
};

/// A candidate of the last decision that became another verdict.
struct VerdictDifference {
  int id = 0;
  Both<std::string> verdict, reason;
};

/// The last decision of both.
struct DecisionComparison {
  Both<const RecordedCandidate*> chosen{};  ///< Nothing: no candidate was chosen.
  std::optional<double> grasps_apart_m;     ///< Between the chosen ones.
  std::optional<double> partners_apart_m;   ///< Between the partners' grasps as seen.
  bool same_candidates = false;  ///< The same ids at the same places, to 1 mm, but for those around a choice.
  std::vector<VerdictDifference> verdicts{};  ///< Only of the same candidates.
};

/// How far a curve of B is from that of A, at the times of A since both began to lift (or since their start).
struct CurveComparison {
  Quantity quantity = Quantity::Load;
  double max_difference = 0.0, at_s = 0.0;
  double rms_difference = 0.0;
};

struct Comparison {
  Both<const RecordedRun*> run{};  ///< Have to outlive it.
  std::string aligned;             ///< "lift", or "start": where time 0 of the curves is.
  Both<double> zero_s{};           ///< When that was.
  std::vector<ConfigDifference> config;
  std::vector<StateComparison> states;
  std::optional<DecisionComparison> decision;  ///< Of runs that both decided.
  std::vector<FigureComparison> figures;
  std::vector<CurveComparison> curves;

  /// Nothing that is compared differs: outcome, settings, states and their times, decision, curves.
  [[nodiscard]] bool same() const;
};

[[nodiscard]] Comparison compare(const RecordedRun& a, const RecordedRun& b);

// Figures for people: "-" for what is not known, nothing where no difference can be taken.
[[nodiscard]] std::string setting_text(const std::optional<std::string>& value);
[[nodiscard]] int digits_of(const FigureComparison& figure);
[[nodiscard]] std::string value_text(const std::optional<double>& value, int digits);
[[nodiscard]] std::string difference_text(const Both<std::optional<double>>& value, int digits);

/// A page with the tables and every curve of both runs in one diagram.
/// Errors: BadInput (it cannot be written).
[[nodiscard]] hal::Result<> write_comparison_page(const std::filesystem::path& html, const Comparison& c,
                                                  const std::string& command);

}  // namespace colift::tools
