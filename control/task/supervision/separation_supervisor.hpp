#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "control/monitor/separation_monitor.hpp"
#include "control/monitor/swept_volume.hpp"
#include "control/task/task_context.hpp"

namespace colift::control {

/// People around the arm: finds them in each frame, measures their distance to the arm and to the rest of its
/// path, and asks the arm for the speed that the SeparationMonitor allows. While the arm waits or is slowed,
/// the time limits of the state wait with it. Without MonitorConfig::resume an operator confirms that an arm
/// that was stopped may continue.
class SeparationSupervisor {
 public:
  explicit SeparationSupervisor(TaskContext& context);

  void start();
  /// Once in each cycle, when the devices have been read. `image_age_s`: of the newest frame, in the mean.
  void update(double image_age_s);

  /// The arm stands on its path, or would, because of it.
  [[nodiscard]] bool holds() const { return scale_ == 0.0; }
  /// Why the arm is slowed or stands; empty: it is not.
  [[nodiscard]] const std::string& reason() const { return reason_; }
  /// An operator confirms that the arm may continue. No effect unless may_confirm().
  void confirm();
  /// The arm stands on its path after a stop, nobody is near any more, and a confirmation makes it continue.
  [[nodiscard]] bool may_confirm() const;
  /// Set when it has waited too long: it stood for longer than MonitorConfig::max_wait_s at a stretch, for
  /// somebody or for a confirmation, or the state has lost three times that in all to whoever comes near
  /// again and again.
  [[nodiscard]] std::optional<TaskEvent> waited_too_long() const;
  /// Everybody in view is farther from the arm than that, and the view is not blind.
  [[nodiscard]] bool nobody_within(double distance_m) const;
  /// Set when somebody or something has been in the path for so long that another path is to be planned.
  [[nodiscard]] std::optional<TaskEvent> path_obstructed() const;
  /// For page, record and report.
  void report(SeparationStatus& out) const;

 private:
  /// Distances of a thing at rest in the last frames.
  struct ThingDistances {
    int id = 0;
    std::array<double, 5> last_m{};
    std::size_t frames = 0;
    hal::Timestamp seen_at{0};
  };
  /// The median of them with a new one: single pixels fly at a thing's edges, and it does not move.
  double settled_distance(int id, double distance_m);
  void look(const hal::DepthFrame& frame);
  void place_arm(const RobotPosture& posture);
  void sort_points(const BodySighting& seen);
  void add_neighbour(Nearby who, std::span<const perception::BodyPoint> points,
                     const perception::BodyTrack* track);
  [[nodiscard]] std::optional<hal::Vec3> partner_contact() const;
  [[nodiscard]] double planned_speed_m_s() const;
  void request(double scale, std::string why);
  /// Of an arm that stands after a stop which is to be confirmed.
  [[nodiscard]] std::string why_it_stands() const;
  void note_confirmable();
  /// TaskContext::obstacles_W by a frame whose bodies are known.
  void note_obstacles(const hal::DepthFrame& frame);
  /// Counts and notes that the arm waits, or continues.
  void note_wait();
  /// A person nearer than that slows the arm (m).
  [[nodiscard]] double slow_distance_m() const;
  void add_sample();

  TaskContext& c_;
  SeparationMonitor monitor_;
  SweptVolume arm_;
  perception::SphereSet links_, path_;
  std::vector<Neighbour> near_;
  std::vector<perception::BodyPoint> hand_, partner_, others_;
  std::vector<SeparationStatus::Body> bodies_;
  std::vector<Eigen::Vector3f> seen_W_;    ///< Of the last frame, without the partner.
  std::vector<Eigen::Vector3f> things_W_;  ///< Those of things at rest.
  std::optional<Nearby> obstructed_by_;    ///< The last path; until neither it nor anything else is seen.
  hal::Timestamp updated_at_{0};
  hal::Timestamp sampled_at_{0};
  double scale_ = 1.0, waited_s_ = 0.0, compute_ms_ = 0.0;
  bool asked_aside_ = false, waits_ = false, asked_to_confirm_ = false, blind_ = false;
  std::string reason_;
  std::vector<ThingDistances> things_;
};

}  // namespace colift::control
