#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "hal/types/result.hpp"
#include "planner/grasp_candidate.hpp"
#include "planner/load_sharing/load_sharing.hpp"

namespace colift::planner {

/// What the decision believes, and how sure it is. Frame W, m and m^2.
struct UncertainScene {
  Vec3 cog = Vec3::Zero(), partner = Vec3::Zero(), up = Vec3::UnitZ();
  Eigen::Matrix3d cog_covariance = Eigen::Matrix3d::Zero(), partner_covariance = Eigen::Matrix3d::Zero();
  double weight_n = 1.0;  ///< Of the object; counts where it is known what a grasp holds.
};

/// Cost of a lift over the what-ifs, per newton squared of weight.
struct RobustCost {
  double expected = 0.0, worst = 0.0;
};

/// Costs of eq. 4.5 for a pure lift over many what-ifs: centres of gravity and partner positions drawn from
/// normal distributions. The draws are made once (same seed, same draws; antithetic pairs, so that the mean
/// what-if is the belief itself); evaluating neither allocates nor locks. One object, one thread.
///
/// With f the lift and c, d as in LoadSharing, a what-if shifts c by partner_part * dp - dc and d by dp, so a
/// candidate costs one division: (|c x f|^2 + mu/s (d . c x f)^2) / (mu |d|^2 + s).
///
/// A grasp may say how much it holds. In a what-if that asks more of it, robot_part (1 + c . d / (mu |d|^2 +
/// s)) of the weight, it slips, and costs what the partner bears then: the whole weight, and its torque about
/// his hand. Without uncertainty that is a limit; with it, a price for coming near.
class RobustChoice {
 public:
  static constexpr int kWhatIfs = 10'000;

  /// Errors: BadInput (weights, or no what-ifs, or no room for a candidate).
  [[nodiscard]] static hal::Result<RobustChoice> create(const SharingWeights& weights,
                                                        std::size_t most_candidates, int what_ifs = kWhatIfs,
                                                        std::uint64_t seed = 1);

  /// One cost per grasp point (where the load hangs, W). `out` is as long as `points`; at most
  /// most_candidates().
  /// `holds_n`: the weight that each can lift before it slips (N); empty: none slips.
  void evaluate(const UncertainScene& scene, std::span<const Vec3> points, std::span<RobustCost> out,
                std::span<const double> holds_n = {});

  enum class Aim { Expected, Worst };
  /// The candidate with the smallest cost by `aim` among those that are Ok or Chosen; nullopt when there is
  /// none. Ties go to the one that is Chosen, then to the lower index. `holds_n`: one per candidate, or
  /// empty.
  [[nodiscard]] std::optional<std::size_t> choose(const UncertainScene& scene,
                                                  std::span<const GraspCandidate> candidates, Aim aim,
                                                  std::span<const double> holds_n = {});

  [[nodiscard]] std::size_t most_candidates() const { return bx_.size(); }

 private:
  RobustChoice(const LoadSharing& sharing, const SharingWeights& weights, std::size_t most_candidates,
               int what_ifs, std::uint64_t seed);

  LoadSharing sharing_;
  double force_weight_, alone_torque_weight_;   ///< Of a shared lift; of torque about a partner left alone.
  std::vector<double> normal_;                  ///< Six per what-if.
  std::vector<double> bx_, by_, ex_, ey_, ez_;  ///< Per candidate: c and d of the belief, up along z.
  std::vector<double> limit_;                   ///< Part of the weight that the grasp holds.
  std::vector<double> sum_, worst_;
  std::vector<Vec3> points_;
  std::vector<RobustCost> costs_;
};

}  // namespace colift::planner
