#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "hal/can_bus.hpp"
#include "hal/drivers/barrett_can/replay/puck_session.hpp"

namespace colift::hal::barrett {

/// Where today's driver departs from the recording.
struct ReplayDifference {
  std::uint32_t line = 0;  ///< Of the log: what was recorded there.
  std::string words;
};

struct ReplayFindings {
  std::vector<ReplayDifference> differences;  ///< The first two hundred, in the order of lines.
  std::uint64_t more = 0;                     ///< Beyond these.
  std::uint64_t questions = 0, settings = 0;  ///< Of the driver.
  std::uint64_t repeats = 0;  ///< Settings said once more, or once less, than recorded: no difference.
};

/// The hand of a log as a bus: a question is answered with what the nearest one in time was answered then,
/// with the delay of then; silence is silence. The nearest one is looked for between the settings of its
/// property that the driver said last and says next. A wait moves the clock. Log and clock outlive it; one
/// thread.
class RecordedPucks final : public CanBus {
 public:
  /// `shift`: to be added to a time of the log for one of `clock`.
  RecordedPucks(const std::vector<CandumpFrame>& frames, Duration shift, ManualClock& clock);

  Result<> open() override;
  void close() noexcept override { open_ = false; }
  [[nodiscard]] Received receive(CanFrame& into, Duration timeout) noexcept override;
  [[nodiscard]] Sent send(const CanFrame& frame) noexcept override;
  [[nodiscard]] CanHealth health() const noexcept override { return health_; }

  /// Of the last frame, as the clock counts.
  [[nodiscard]] Timestamp end() const;
  void note_difference(std::uint32_t line, std::string words);
  /// After the last call: also what was recorded and not said again.
  [[nodiscard]] ReplayFindings finish();

 private:
  using Key = std::pair<Puck, Property>;
  struct Exchange {
    std::size_t request = 0, answer = 0;  ///< Of the recording; the answer may have no frames.
  };
  struct Asked {
    std::vector<Exchange> recorded;
    std::vector<Timestamp> now;  ///< When the driver asks.
  };
  struct Settings {
    std::vector<std::uint32_t> frames;  ///< Recorded, in order.
    std::size_t said = 0;               ///< So many of them the driver has said again.
  };
  struct Letter {
    Timestamp due{0};
    CanFrame frame;
  };

  [[nodiscard]] Timestamp at(std::size_t request) const;
  [[nodiscard]] const CandumpFrame& line(std::size_t request) const;
  [[nodiscard]] bool alike(const CanFrame& said, std::size_t request) const;
  [[nodiscard]] bool repeated(const std::vector<std::size_t>& list, std::size_t i) const;
  void keep_power_on(const CanFrame& said, std::size_t request);
  void hear_setting(const CanFrame& frame, const Request& says, Timestamp now);
  void hear_question(const Request& says, Timestamp now);
  [[nodiscard]] std::optional<Exchange> nearest(const Key& key, Timestamp now) const;
  void take(std::size_t request, Timestamp now);
  void answer(const PuckAnswer& with, Timestamp then, Timestamp now);
  void post(CanFrame frame, Timestamp due);

  const std::vector<CandumpFrame>& frames_;
  Duration shift_;
  ManualClock& clock_;
  PuckSession session_;
  std::map<std::uint16_t, std::vector<std::size_t>> settings_;  // by identifier
  std::map<std::uint16_t, std::size_t> next_setting_;
  std::map<Key, Asked> questions_;
  std::map<Key, Settings> of_property_;
  std::map<Puck, std::int32_t> power_on_later_s_;  // DS as said now, less DS as recorded
  std::deque<Letter> queue_;
  ReplayFindings findings_;
  CanHealth health_;
  bool open_ = false;
};

}  // namespace colift::hal::barrett
