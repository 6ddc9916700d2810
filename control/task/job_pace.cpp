// How fast the arm may go with what is known at this moment: slowly where the hand warns, the camera is lost
// or its pictures are old.

#include <fmt/format.h>

#include <algorithm>

#include "control/task/job.hpp"

namespace colift::control {
namespace {

constexpr double kOldPicture_s = 0.15, kFreshPicture_s = 0.10;  // in the mean; between them nothing changes
constexpr double kMean_s = 0.4;

}  // namespace

/// Age of the newest picture, in the mean over the last moments: what comes late counts, and what comes
/// seldom.
void Job::judge_pictures() {
  const double age_s = std::max(0.0, hal::seconds(now_ - frame_at_));
  const double passed_s = std::max(0.0, hal::seconds(now_ - aged_at_));
  aged_at_ = now_;
  if (camera_lost_) {  // more than old; what comes after it is judged anew
    picture_age_s_ = 0.0;
    pictures_old_ = false;
    return;
  }
  picture_age_s_ += (age_s - picture_age_s_) * std::min(1.0, passed_s / kMean_s);
  if (picture_age_s_ > kOldPicture_s) pictures_old_ = true;
  if (picture_age_s_ < kFreshPicture_s) pictures_old_ = false;
}

void Job::set_pace() {
  judge_pictures();
  std::string why;
  if (!hand_warning_.empty())
    why = "the hand: " + hand_warning_;
  else if (!is_moving(state_))
    why = "";                                                 // nothing moves that could be slower
  else if (camera_lost_ && !next(state_, Event::CameraLost))  // where a rule stops the arm, it stops
    why = "the camera gives no picture: nobody can be seen to come near";
  else if (state_ == Task::TestLift && tests_.said() == Raise::Slowly)
    why = "the object turns";
  else if (pictures_old_)
    why = fmt::format("the camera's pictures are {:.0f} ms old in the mean", 1e3 * picture_age_s_);
  if (why.empty() == slow_because_.empty()) return;
  slow_because_ = std::move(why);
  loop_.go_slow(!slow_because_.empty());
}

}  // namespace colift::control
