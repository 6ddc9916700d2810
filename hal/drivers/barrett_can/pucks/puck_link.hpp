#pragma once

#include <array>
#include <bitset>
#include <cstdint>
#include <optional>

#include "hal/can_bus.hpp"
#include "hal/drivers/barrett_can/pucks/puck_codec.hpp"
#include "hal/drivers/barrett_can/pucks/round_trip.hpp"
#include "hal/types/time.hpp"

namespace colift::hal::barrett {

/// A value as a puck last reported it.
struct Reported {
  std::int32_t value = 0;
  Timestamp at{0};        ///< Of the answer.
  Timestamp asked_at{0};  ///< Of the question, so that an answer from before a command is known as one.
  bool known = false;
};

/// A setting that was read back, with the time of that.
struct TakenSetting {
  std::int32_t value = 0;
  Timestamp at{0};
};

/// What somebody else on the bus said to the hand.
struct ForeignRequests {
  std::uint64_t questions = 0, settings = 0;
  Timestamp asked_at{0};   ///< The last question.
  Request last_setting{};  ///< When there is any.
};

/// A pad as it was last reported whole.
struct PadScan {
  std::array<std::uint16_t, kTactileCells> cells{};
  Timestamp at{0};
  bool known = false;
};

/// Questions and settings to four pucks over one bus: one question per puck and property at a time, each with
/// a deadline and two repeats; settings in order, one puck's at least 0.2 ms apart, read back where wished.
/// Nothing waits and nothing allocates but open(). One thread.
class PuckLink {
 public:
  PuckLink(CanBus& bus, const Clock& clock, Duration reply, Duration tactile_reply);

  /// Waits long for answers for so long, and measures how long they take: at the start.
  void measure_round_trip(Duration for_how_long) noexcept;
  /// Asks one puck for what nobody else asks for, so that the age of its answer is certain.
  void ping() noexcept;
  [[nodiscard]] const RoundTrip& round_trip() const noexcept { return round_trip_; }
  /// How long three tries of one question may take now.
  [[nodiscard]] Duration three_tries() const noexcept;

  /// Takes in what has come (waiting no longer than `timeout` for the first frame), repeats or gives up what
  /// was not answered, and sends what is due.
  void pump(Duration timeout) noexcept;

  void ask(Puck puck, Property property) noexcept;
  /// One frame to the hand's group if its members listen to it; silent pucks are not expected to answer.
  void ask_all(Property property) noexcept;
  /// A whole scan in the format that the puck was set to. `send` false: the frames come by themselves,
  /// because TACT is being set.
  void ask_tactile(Puck puck, int format, bool send = true) noexcept;
  void ask_lost(Puck puck) noexcept;  ///< Once more everything that it did not answer.

  /// Queues a setting; `verify`: read back, and said again when it did not take.
  void set(Puck puck, Property property, std::int32_t value, bool verify) noexcept;
  void drop_settings(Puck puck) noexcept;
  void drop_all() noexcept;  ///< Settings and questions: after the bus was lost.
  [[nodiscard]] bool busy(Puck puck) const noexcept { return queues_[index(puck)].size > 0; }
  [[nodiscard]] bool busy() const noexcept;
  /// A setting that the puck did not take after three tries. Cleared by the asking.
  [[nodiscard]] std::optional<Property> take_refusal(Puck puck) noexcept;

  [[nodiscard]] const Reported& reported(Puck puck, Property property) const noexcept;
  [[nodiscard]] const PadScan& pad(Puck puck) const noexcept { return pads_[index(puck)].whole; }
  [[nodiscard]] bool pending(Puck puck, Property property) const noexcept;
  /// Asked three times without an answer, and not answered since.
  [[nodiscard]] bool unanswered(Puck puck, Property property) const noexcept;
  [[nodiscard]] bool silent(Puck puck) const noexcept;
  /// A question is out to it for the second time or more.
  [[nodiscard]] bool repeats(Puck puck) const noexcept;
  void forget(Puck puck) noexcept;           ///< What it reported, and that it did not answer.
  void forget_settings(Puck puck) noexcept;  ///< What it took: a reset has brought the factory's values back.

  void use_group(bool yes) noexcept { grouped_ = yes; }
  /// Sends in a row that the bus did not take.
  [[nodiscard]] int full_in_a_row() const noexcept { return full_in_a_row_; }
  void clear_full() noexcept { full_in_a_row_ = 0; }
  /// The last setting of MODE has left, and when.
  [[nodiscard]] Timestamp mode_set_at(Puck puck) const noexcept { return mode_set_at_[index(puck)]; }
  /// The last setting that the puck took; E is nullopt after CMD, which may change it.
  [[nodiscard]] const std::optional<TakenSetting>& taken(Puck puck, Property property) const noexcept {
    return question(puck, property).taken;
  }
  [[nodiscard]] const ForeignRequests& foreign() const noexcept { return foreign_; }
  [[nodiscard]] std::uint64_t accepted() const noexcept { return accepted_; }
  [[nodiscard]] std::uint64_t rejected() const noexcept { return rejected_; }

 private:
  struct Question {
    Reported reported;
    Timestamp asked_at{0}, first_asked_at{0};
    Duration served{0}, first_served{0};  ///< Of this link's own time when it was asked.
    Timestamp stale_until{0};             ///< Until then an answer to an earlier question may come.
    std::optional<TakenSetting> taken;
    std::uint8_t tries = 0;  ///< Repeats so far.
    bool sent = false;
    bool unanswered = false;
  };
  struct Setting {
    Property property{};
    std::int32_t value = 0;
    bool verify = false;
  };
  struct Queue {
    std::array<Setting, 32> settings{};
    std::size_t first = 0, size = 0;
    int tries = 0;
    bool reading_back = false;
    Timestamp last_sent{0};
    std::optional<Property> refused;
  };
  struct Pad {
    PadScan whole;
    std::array<std::uint16_t, kTactileCells> cells{};
    std::uint8_t rows = 0;
    Timestamp asked_at{0};
    bool pending = false, to_send = false;
    bool full = false;
  };

  Question& question(Puck puck, Property property) noexcept;
  [[nodiscard]] const Question& question(Puck puck, Property property) const noexcept;
  void take(const CanFrame& frame) noexcept;
  void answer(Puck puck, Property property, std::int32_t value, Timestamp at) noexcept;
  [[nodiscard]] Duration own_time(Timestamp since, Duration served, Timestamp at) const noexcept;
  void note_foreign(const Request& request, Timestamp at) noexcept;
  bool take_row(const TactileRow& row, Timestamp at) noexcept;
  bool take_top(const TactileTop& top, Timestamp at) noexcept;
  void begin(Question& q, Timestamp now) noexcept;
  void sent(Question& q, Timestamp now) noexcept;
  void close(Question& q, Timestamp now) noexcept;
  void check_deadlines(Timestamp now) noexcept;
  void send_due(Timestamp now) noexcept;
  void run_queue(Puck puck, Timestamp now) noexcept;
  bool send(const CanFrame& frame) noexcept;

  CanBus& bus_;
  const Clock& clock_;
  Duration tactile_reply_;
  RoundTrip round_trip_;
  Duration served_{0};  ///< Time that stands still while nobody pumps: then nobody is late either.
  Timestamp pumped_at_{0};
  ForeignRequests foreign_;
  struct {
    bool pending = false;
    Puck puck = Puck::Spread;
    Timestamp at{0};
    Duration served{0};
  } ping_;
  std::array<std::array<Question, 128>, kPucks> questions_{};
  std::array<std::bitset<128>, kPucks> open_{};  ///< Which questions are pending.
  std::array<std::bitset<128>, kPucks> lost_{};  ///< Which were not answered.
  std::array<Queue, kPucks> queues_{};
  std::array<Pad, kPucks> pads_{};
  std::array<Timestamp, kPucks> mode_set_at_{};
  bool grouped_ = false, stalled_ = false;
  int full_in_a_row_ = 0;
  std::uint64_t accepted_ = 0, rejected_ = 0;
};

}  // namespace colift::hal::barrett
