#pragma once

#include "hal/types/time.hpp"

namespace colift::hal::barrett {

/// How long the pucks take to answer on this link, and how long one has to wait for them: the configured
/// deadline, or longer where answers are measured to come later (a gateway behind a slow network). A question
/// that was repeated has an answer of unknown age; so, once answers come that nobody waited for any more, the
/// deadline is long for a second, and what comes is measured.
class RoundTrip {
 public:
  explicit RoundTrip(Duration deadline) : base_(deadline) {}

  void note_answer(Duration age);  ///< To a question that was asked once.
  /// After its deadline, at least this old.
  void note_late(Duration age, Timestamp now);
  /// Waits long from now on: at the start, and when answers came late.
  void be_patient(Duration for_how_long, Timestamp now) { patient_until_ = now + for_how_long; }
  void step(Timestamp now);

  [[nodiscard]] Duration deadline(Timestamp now) const;
  /// Several answers of the last two seconds came later than the configured deadline.
  [[nodiscard]] bool slow() const { return late_now_ + late_before_ >= kLateOnes; }
  [[nodiscard]] Duration worst() const { return worst_now_ > worst_before_ ? worst_now_ : worst_before_; }
  /// The same for a message, in ms, rounded up to a tenth: one that came late is never shown as in time.
  [[nodiscard]] double worst_ms() const;

  /// The latest answer that is taken for one: older ones nobody can tell from garbage.
  static constexpr Duration kLatest = std::chrono::milliseconds(150);
  static constexpr Duration kPatience = std::chrono::milliseconds(100);

 private:
  static constexpr int kLateOnes = 3;
  static constexpr Duration kWindow = std::chrono::seconds(1);

  Duration base_;
  Duration worst_now_{0}, worst_before_{0};
  int late_now_ = 0, late_before_ = 0;
  bool measured_ = false;
  Timestamp window_since_{0}, patient_until_{0};
};

}  // namespace colift::hal::barrett
