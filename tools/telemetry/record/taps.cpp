#include "tools/telemetry/record/taps.hpp"

#include <thread>

namespace colift::telemetry {
namespace {

hal::Result<> noted(TapBook& book, hal::Result<> answer) {
  if (book.listens) book.now.answers.push_back(answer);
  return answer;
}

class TappedArm final : public hal::Arm {
 public:
  TappedArm(std::unique_ptr<hal::Arm> arm, std::shared_ptr<TapBook> book, const hal::Clock& wall)
      : arm_(std::move(arm)), owned_(std::move(book)), book_(*owned_), wall_(wall) {}

  hal::Result<> configure() override { return noted(book_, arm_->configure()); }
  hal::Result<> activate() override {
    // with a thread of its own the arm is activated there
    auto answer = arm_->activate();
    return book_.in_step ? noted(book_, std::move(answer)) : answer;
  }
  void deactivate() noexcept override { arm_->deactivate(); }
  [[nodiscard]] hal::DeviceHealth health() const override {
    auto health = arm_->health();
    if (book_.listens) book_.now.arm_health.push_back(health);
    return health;
  }
  hal::Result<hal::ArmState> wait_cycle() override {
    auto state = arm_->wait_cycle();
    since_ = wall_.now();
    sample_ = {};
    sample_.missed = !state;
    if (state) sample_.measured_at = state->measured_at;
    if (!state) (void)book_.arm.push(sample_);
    if (book_.in_step) book_.now.arm.push_back(state);
    return state;
  }
  hal::Result<> command(const hal::ImpedanceCommand& command) override {
    auto answer = arm_->command(command);
    sample_.answer = wall_.now() - since_;
    sample_.answered = answer.has_value();
    (void)book_.arm.push(sample_);
    return book_.in_step ? noted(book_, std::move(answer)) : answer;
  }
  [[nodiscard]] hal::ArmAbilities abilities() const override { return arm_->abilities(); }
  void stop() noexcept override { arm_->stop(); }

 private:
  std::unique_ptr<hal::Arm> arm_;
  std::shared_ptr<TapBook> owned_;
  TapBook& book_;
  const hal::Clock& wall_;
  hal::Timestamp since_{0};
  ArmSample sample_;
};

class TappedHand final : public hal::Hand {
 public:
  TappedHand(std::unique_ptr<hal::Hand> hand, std::shared_ptr<TapBook> book)
      : hand_(std::move(hand)), owned_(std::move(book)), book_(*owned_) {}
  hal::Result<> configure() override { return noted(book_, hand_->configure()); }
  hal::Result<> activate() override { return noted(book_, hand_->activate()); }
  void deactivate() noexcept override { hand_->deactivate(); }
  [[nodiscard]] hal::DeviceHealth health() const override { return hand_->health(); }
  hal::Result<hal::HandState> state() override {
    auto state = hand_->state();
    if (book_.listens) book_.now.hand.push_back(state);
    return state;
  }
  hal::Result<> preshape(double spread_rad) override { return noted(book_, hand_->preshape(spread_rad)); }
  hal::Result<> close(double torque_nm) override { return noted(book_, hand_->close(torque_nm)); }
  hal::Result<> release() override { return noted(book_, hand_->release()); }
  [[nodiscard]] std::vector<std::string> realtime() const override { return hand_->realtime(); }
  void stop() noexcept override { hand_->stop(); }

 private:
  std::unique_ptr<hal::Hand> hand_;
  std::shared_ptr<TapBook> owned_;
  TapBook& book_;
};

class TappedCamera final : public hal::DepthCamera {
 public:
  TappedCamera(std::unique_ptr<hal::DepthCamera> camera, std::shared_ptr<TapBook> book, std::size_t number)
      : camera_(std::move(camera)), number_(number), owned_(std::move(book)), book_(*owned_) {}
  hal::Result<> configure() override { return noted(book_, camera_->configure()); }
  hal::Result<> activate() override { return noted(book_, camera_->activate()); }
  void deactivate() noexcept override { camera_->deactivate(); }
  [[nodiscard]] hal::DeviceHealth health() const override { return camera_->health(); }
  hal::Result<hal::DepthFrame> next_frame(std::chrono::milliseconds timeout) override {
    auto frame = camera_->next_frame(timeout);
    if (!book_.listens) return frame;
    CameraReading reading;
    if (frame) {
      reading.frame = book_.frames++;
      if (book_.on_frame) book_.on_frame(number_, *reading.frame, *frame);
    } else {
      reading.error = frame.error();
    }
    book_.now.camera.push_back(std::move(reading));
    return frame;
  }

 private:
  std::unique_ptr<hal::DepthCamera> camera_;
  std::size_t number_;
  std::shared_ptr<TapBook> owned_;
  TapBook& book_;
};

class TappedClock final : public hal::Clock {
 public:
  TappedClock(std::unique_ptr<hal::Clock> clock, std::shared_ptr<TapBook> book)
      : clock_(std::move(clock)),
        owned_(std::move(book)),
        book_(*owned_),
        owner_(std::this_thread::get_id()) {}
  [[nodiscard]] hal::Timestamp now() const override {
    const hal::Timestamp now = clock_->now();
    // others may ask the robot's clock too, from other threads: the book is not theirs, not even to look into
    if (std::this_thread::get_id() == owner_ && book_.listens) book_.now.clock_ns.push_back(now.count());
    return now;
  }

 private:
  std::unique_ptr<hal::Clock> clock_;
  std::shared_ptr<TapBook> owned_;
  TapBook& book_;
  std::thread::id owner_;
};

}  // namespace

std::unique_ptr<hal::Arm> tap_arm(std::unique_ptr<hal::Arm> arm, const std::shared_ptr<TapBook>& book,
                                  const hal::Clock& wall) {
  return std::make_unique<TappedArm>(std::move(arm), book, wall);
}
std::unique_ptr<hal::Hand> tap_hand(std::unique_ptr<hal::Hand> hand, const std::shared_ptr<TapBook>& book) {
  return std::make_unique<TappedHand>(std::move(hand), book);
}
std::unique_ptr<hal::DepthCamera> tap_camera(std::unique_ptr<hal::DepthCamera> camera,
                                             const std::shared_ptr<TapBook>& book, std::size_t number) {
  return std::make_unique<TappedCamera>(std::move(camera), book, number);
}
std::unique_ptr<hal::Clock> tap_clock(std::unique_ptr<hal::Clock> clock,
                                      const std::shared_ptr<TapBook>& book) {
  return std::make_unique<TappedClock>(std::move(clock), book);
}

}  // namespace colift::telemetry
