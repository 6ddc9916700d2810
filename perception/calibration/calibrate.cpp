#include "perception/calibration/calibrate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>

#include "hal/types/symmetric.hpp"
#include "perception/calibration/start_value.hpp"

namespace colift::perception {
namespace {

constexpr std::size_t kDraw = 7;  // 9 unknowns, 14 equations
// bounds of the iterations; they end earlier where they converge
constexpr int kStartRounds = 12, kDrawSteps = 12, kFinalSteps = 60;
constexpr std::size_t kMinPoses = 5;  // 10 equations for 9 unknowns

using Refusal = tl::unexpected<CalibrationRefusal>;

Refusal refuse(std::string kind, std::string reason, std::optional<Calibration> solved = std::nullopt) {
  return tl::unexpected<CalibrationRefusal>(
      CalibrationRefusal{std::move(kind), std::move(reason), std::move(solved)});
}

/// Model and inliers, before anything is said about them.
struct Estimate {
  EmitterModel model;
  EmitterRows rows;
};

class Solver {
 public:
  Solver(std::span<const EmitterSample> samples, const hal::CameraIntrinsics& camera,
         const CalibrationConfig& config)
      : samples_(samples), config_(config), noise_{config.pixel_px, config.arm_m} {
    prior_.camera = camera;
    prior_.p_H = config.emitter_m;
  }

  std::optional<Estimate> run(std::uint64_t seed) const {
    auto found = search(seed);
    if (!found) return std::nullopt;
    Estimate out{*found, {}};
    // twice: with the worst outliers gone, the inliers are told better
    const double least = config_.inlier_sigmas;
    for (const double sigmas : {2.0 * least, least, least}) {
      out.rows.samples = inliers(out.model, sigmas);
      if (out.rows.samples.size() < kMinPoses) return out;
      out.rows.huber = true;
      refine(samples_, out.rows, noise_, prior_, kFinalSteps, out.model);
    }
    add_depth(out);
    out.rows.samples = inliers(out.model, config_.inlier_sigmas);
    if (out.rows.samples.size() < kMinPoses) return out;
    out.rows.huber = false;
    refine(samples_, out.rows, noise_, prior_, kFinalSteps, out.model);
    return out;
  }

  [[nodiscard]] Linearised at(const Estimate& e) const {
    return linearise(samples_, e.model, prior_, e.rows, noise_);
  }

  /// The same without one pose, from where the solution is.
  [[nodiscard]] EmitterModel without(const Estimate& e, int left_out) const {
    EmitterRows rows = e.rows;
    std::erase(rows.samples, left_out);
    EmitterModel model = e.model;
    refine(samples_, rows, noise_, prior_, 15, model);
    return model;
  }

 private:
  /// MSAC: the model of seven poses on which the residuals of all agree best.
  std::optional<EmitterModel> search(std::uint64_t seed) const {
    std::mt19937_64 random(seed);
    std::vector<int> order(samples_.size());
    std::iota(order.begin(), order.end(), 0);
    const std::size_t size = std::min(kDraw, order.size());
    std::optional<EmitterModel> best;
    double best_score = std::numeric_limits<double>::infinity();
    int needed = config_.draws;
    for (int draw = 0; draw < needed; ++draw) {
      // the first seven of a shuffle, by hand: std::shuffle is not the same everywhere
      for (std::size_t i = 0; i < size; ++i) std::swap(order[i], order[i + random() % (order.size() - i)]);
      EmitterRows rows;
      rows.samples.assign(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(size));
      rows.emitter_prior_m = config_.emitter_sigma_m;
      EmitterModel model = prior_;
      if (!start_value(samples_, rows.samples, config_.emitter_sigma_m, kStartRounds, model)) continue;
      if (!std::isfinite(refine(samples_, rows, noise_, prior_, kDrawSteps, model))) continue;
      const double score = msac(model);
      if (!(score < best_score)) continue;
      best_score = score;
      best = model;
      // so many draws that one of them is without outliers, but for one case in ten thousand
      const double part = static_cast<double>(inliers(model, config_.inlier_sigmas).size()) /
                          static_cast<double>(samples_.size());
      const double clean = std::pow(part, static_cast<double>(size));
      if (clean > 1e-6)
        needed = std::clamp(static_cast<int>(std::log(1e-4) / std::log1p(-std::min(clean, 0.999))),
                            std::min(config_.min_draws, config_.draws), config_.draws);
    }
    return best;
  }

  [[nodiscard]] double gate(const EmitterSample& s, const EmitterModel& model, double sigmas) const {
    const double z = model.in_camera(s.X_BH).z();
    return std::max(sigmas / config_.inlier_sigmas * config_.inlier_px,
                    sigmas * pixel_sigma(s, model, z, noise_));
  }

  [[nodiscard]] double msac(const EmitterModel& model) const {
    double sum = 0.0;
    for (const EmitterSample& s : samples_) {
      const double cap = gate(s, model, config_.inlier_sigmas);
      sum += std::min(pixel_residual(s, model).squaredNorm(), cap * cap);
    }
    return sum;
  }

  [[nodiscard]] std::vector<int> inliers(const EmitterModel& model, double sigmas) const {
    std::vector<int> out;
    for (std::size_t i = 0; i < samples_.size(); ++i)
      if (pixel_residual(samples_[i], model).norm() < gate(samples_[i], model, sigmas))
        out.push_back(static_cast<int>(i));
    return out;
  }

  /// Depths that fit join the rows; the others are somewhere else than the emitter.
  void add_depth(Estimate& e) const {
    if (!config_.use_depth) return;
    std::vector<bool> use(samples_.size(), false);
    const auto fits = [&](double min_m) {
      int count = 0;
      for (const int i : e.rows.samples) {
        const EmitterSample& s = samples_[static_cast<std::size_t>(i)];
        const double z = e.model.in_camera(s.X_BH).z();
        const bool near = s.depth_m && std::abs(e.model.depth_scale * z + e.model.depth_offset_m -
                                                *s.depth_m) < min_m + 4.0 * depth_sigma(z);
        use[static_cast<std::size_t>(i)] = near;
        count += near ? 1 : 0;
      }
      return count;
    };
    constexpr int kMinDepths = 6;  // for a scale and an offset of their own
    if (fits(config_.depth_gate_m) < kMinDepths) return;
    e.rows.released = config_.intrinsics ? Released::Intrinsics : Released::DepthTerms;
    e.rows.use_depth = use;
    refine(samples_, e.rows, noise_, prior_, kFinalSteps, e.model);
    if (fits(0.0) < kMinDepths) {
      e.rows.released = Released::Nothing;
      e.rows.use_depth.clear();
      return;
    }
    e.rows.use_depth = use;
    refine(samples_, e.rows, noise_, prior_, kFinalSteps, e.model);
  }

  std::span<const EmitterSample> samples_;
  const CalibrationConfig& config_;
  EmitterNoise noise_;
  EmitterModel prior_;
};

/// Why these samples cannot be solved at all; nothing if they can.
std::optional<CalibrationRefusal> objection(std::span<const EmitterSample> samples,
                                            const CalibrationConfig& config, PoseDiversity& diversity) {
  if (samples.size() < kMinPoses)
    return CalibrationRefusal{
        "few-poses",
        fmt::format("{} poses are too few; {} agreeing ones are needed", samples.size(), config.min_inliers),
        {}};
  double shortest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const EmitterSample& s = samples[i];
    if (!s.X_BH.matrix().allFinite() || !s.pixel.allFinite() || !s.covariance.allFinite() ||
        (s.depth_m && !std::isfinite(*s.depth_m)))
      return CalibrationRefusal{"not-a-number", fmt::format("pose {} holds a number that is none", i), {}};
    shortest = std::min(shortest, s.X_BH.translation().norm());
  }
  if (shortest > config.max_camera_distance_m)
    return CalibrationRefusal{
        "units",
        fmt::format("the palm is never nearer than {:.0f} m to the base: are the arm's positions in mm?",
                    shortest),
        {}};
  std::vector<int> all(samples.size());
  std::iota(all.begin(), all.end(), 0);
  diversity = diversity_of(samples, all, config.emitter_m);
  const Vec3& turn = diversity.rotation_deg;
  if (turn[0] < 0.05 && diversity.position_m[0] < 1e-4)
    return CalibrationRefusal{"one-pose", "all poses are the same one", {}};
  if (turn[0] < config.min_rotation_deg)
    return CalibrationRefusal{
        "one-orientation",
        fmt::format(
            "the palm has nearly one orientation at all poses (spread {:.1f} deg, needed {:.0f} about "
            "two axes): the emitter's position in the palm cannot be separated from the camera's",
            turn[0], config.min_rotation_deg),
        {}};
  if (turn[1] < config.min_rotation_deg)
    return CalibrationRefusal{
        "one-axis",
        fmt::format(
            "the palm turns about one axis only (spread {:.1f} deg about it and {:.1f} about the next, "
            "needed {:.0f}): turn it about a second one",
            turn[0], turn[1], config.min_rotation_deg),
        {}};
  if (diversity.position_m[2] < config.min_thickness_m)
    return CalibrationRefusal{
        "one-plane",
        fmt::format("all poses are nearly in one plane ({:.0f} mm off it, needed {:.0f})",
                    1e3 * diversity.position_m[2], 1e3 * config.min_thickness_m),
        {}};
  return std::nullopt;
}

/// What was most likely done to images that fit no camera; empty when nothing explains them.
std::string explain_misfit(std::span<const EmitterSample> samples, const hal::CameraIntrinsics& camera,
                           const CalibrationConfig& config, std::uint64_t seed) {
  struct Change {
    const char* what;
    Eigen::Vector2d (*apply)(const Eigen::Vector2d&, const hal::CameraIntrinsics&);
  };
  const Change changes[] = {
      {"mirrored: the spots fit once left and right are swapped",
       [](const Eigen::Vector2d& p, const hal::CameraIntrinsics& k) {
         return Eigen::Vector2d(2 * k.cx - p.x(), p.y());
       }},
      {"given with rows and columns swapped: the spots fit the other way round",
       [](const Eigen::Vector2d& p, const hal::CameraIntrinsics&) { return Eigen::Vector2d(p.y(), p.x()); }},
  };
  for (const Change& change : changes) {
    std::vector<EmitterSample> changed(samples.begin(), samples.end());
    for (EmitterSample& s : changed) s.pixel = change.apply(s.pixel, camera);
    const auto e = Solver(changed, camera, config).run(seed);
    if (e && static_cast<int>(e->rows.samples.size()) >= config.min_inliers &&
        static_cast<double>(e->rows.samples.size()) >= 0.8 * static_cast<double>(samples.size()))
      return fmt::format("; the images are {}", change.what);
  }
  return "";
}

/// As placing_error(), for a camera whose points come from the estimated intrinsics too: a longer focal
/// length puts the camera farther away and the points nearer to its axis.
PlacingError placing_error_with_intrinsics(const EmitterModel& model, const Eigen::MatrixXd& covariance,
                                           std::span<const Vec3> points_B) {
  PlacingError out;
  const auto& k = model.camera;
  for (const Vec3& p : points_B) {
    const Vec3 y = model.R_CB * p + model.t_CB;
    Eigen::Matrix<double, 3, kAllParameters> D = Eigen::Matrix<double, 3, kAllParameters>::Zero();
    D.leftCols<6>() = placing_jacobian(model, p);
    Eigen::Matrix3d dy;  // of the point in C against f, cx, cy, at its pixel and depth
    dy << -y.x() / k.fx, -y.z() / k.fx, 0, -y.y() / k.fx, 0, -y.z() / k.fy, 0, 0, 0;
    D.middleCols<3>(9) = model.R_CB.transpose() * dy;
    const double square = std::max(0.0, (D * covariance * D.transpose()).trace());
    out.rms_m += square;
    out.worst_m = std::max(out.worst_m, std::sqrt(square));
  }
  out.rms_m = std::sqrt(out.rms_m / static_cast<double>(std::max<std::size_t>(1, points_B.size())));
  return out;
}

Calibration describe(const Solver& solver, const Estimate& e, std::span<const EmitterSample> samples,
                     const CalibrationConfig& config) {
  Calibration c;
  c.model = e.model;
  c.samples.resize(samples.size());
  c.inliers = static_cast<int>(e.rows.samples.size());
  c.diversity = diversity_of(samples, e.rows.samples, e.model.p_H);
  const Linearised at = solver.at(e);
  const auto n = at.H.rows();
  const hal::SmallMatrix all = hal::solve_small_symmetric(at.H, hal::SmallMatrix::Identity(n, n));
  const int dof = std::max(1, at.rows - static_cast<int>(n));
  c.chi2_per_dof = at.cost / dof;
  c.covariance = all.topLeftCorner<kPoseParameters, kPoseParameters>() * std::max(1.0, c.chi2_per_dof);
  const hal::SmallVector values = hal::small_symmetric_eigen(c.covariance).values;
  const double least = values[0], most = values[kPoseParameters - 1];
  c.condition = least > 0.0 ? most / least : std::numeric_limits<double>::infinity();
  c.emitter_sigma_m = std::sqrt(std::max(0.0, c.covariance.bottomRightCorner<3, 3>().trace() / 3.0));

  const std::vector<Vec3> grid = workspace_grid(config);
  const PlacingError error =
      e.rows.released == Released::Intrinsics
          ? placing_error_with_intrinsics(e.model, all * std::max(1.0, c.chi2_per_dof), grid)
          : placing_error(e.model, c.covariance.topLeftCorner<6, 6>(), grid);
  c.error_m = error.rms_m;
  c.worst_error_m = error.worst_m;

  const Pose X_BC = e.model.X_BC();
  double squares = 0.0, held_out = 0.0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    SampleVerdict& v = c.samples[i];
    v.residual_px = pixel_residual(samples[i], e.model);
    v.inlier = std::binary_search(e.rows.samples.begin(), e.rows.samples.end(), static_cast<int>(i));
    if (samples[i].depth_m)
      v.depth_residual_m = e.model.depth_scale * e.model.in_camera(samples[i].X_BH).z() +
                           e.model.depth_offset_m - *samples[i].depth_m;
    if (!v.inlier) {
      v.held_out_px = v.residual_px.norm();
      continue;
    }
    const EmitterModel other = solver.without(e, static_cast<int>(i));
    v.held_out_px = pixel_residual(samples[i], other).norm();
    const Pose moved = other.X_BC() * X_BC.inverse();
    for (const Vec3& p : grid) v.shift_m += (moved * p - p).squaredNorm();
    v.shift_m = std::sqrt(v.shift_m / static_cast<double>(grid.size()));
    squares += v.residual_px.squaredNorm();
    held_out += v.held_out_px * v.held_out_px;
    if (v.shift_m > config.shift_m)
      c.remarks.push_back(fmt::format("pose {} alone moves the result by {:.1f} mm", i, 1e3 * v.shift_m));
  }
  c.rms_px = std::sqrt(squares / std::max(1, c.inliers));
  c.held_out_px = std::sqrt(held_out / std::max(1, c.inliers));
  return c;
}

}  // namespace

tl::expected<Calibration, CalibrationRefusal> calibrate(std::span<const EmitterSample> samples,
                                                        const hal::CameraIntrinsics& camera,
                                                        const CalibrationConfig& config, std::uint64_t seed) {
  PoseDiversity diversity;
  if (auto why = objection(samples, config, diversity)) return tl::unexpected(std::move(*why));

  const Solver solver(samples, camera, config);
  const auto estimate = solver.run(seed);
  const auto few = static_cast<std::size_t>(config.min_inliers);
  if (!estimate || estimate->rows.samples.size() < kMinPoses)
    return refuse("few-inliers", fmt::format("no {} of the {} poses fit any place of the camera{}", few,
                                             samples.size(), explain_misfit(samples, camera, config, seed)));
  Calibration c = describe(solver, *estimate, samples, config);

  const double share = static_cast<double>(c.inliers) / static_cast<double>(samples.size());
  if (c.model.t_CB.norm() > config.max_camera_distance_m ||
      c.model.p_H.norm() > config.max_emitter_distance_m)
    return refuse(
        "implausible",
        fmt::format("the camera would be {:.2f} m from the base and the emitter {:.2f} m from the palm "
                    "(at most {:.0f} and {:.1f}): wrong units, or spots of something else",
                    c.model.t_CB.norm(), c.model.p_H.norm(), config.max_camera_distance_m,
                    config.max_emitter_distance_m),
        std::move(c));
  if (c.inliers < config.min_inliers)
    return refuse("few-inliers",
                  fmt::format("only {} of {} poses agree; {} are needed{}", c.inliers, samples.size(), few,
                              explain_misfit(samples, camera, config, seed)),
                  std::move(c));
  if (share < config.min_inlier_fraction)
    return refuse("few-inliers",
                  fmt::format("only {} of {} poses agree, {:.0f} % ({:.0f} % are needed)", c.inliers,
                              samples.size(), 100 * share, 100 * config.min_inlier_fraction),
                  std::move(c));
  if (config.intrinsics && estimate->rows.released != Released::Intrinsics)
    return refuse("not-observable",
                  "intrinsics can be estimated only with depths near the emitter at most poses",
                  std::move(c));
  // the poses that agree may turn less than all did
  if (c.diversity.rotation_deg[1] < config.min_rotation_deg ||
      c.diversity.position_m[2] < config.min_thickness_m)
    return refuse(
        "alike",
        fmt::format("the {} agreeing poses are too alike (rotation about the second axis {:.1f} deg, "
                    "needed {:.0f}; {:.0f} mm off a plane, needed {:.0f})",
                    c.inliers, c.diversity.rotation_deg[1], config.min_rotation_deg,
                    1e3 * c.diversity.position_m[2], 1e3 * config.min_thickness_m),
        std::move(c));
  if (!(c.rms_px <= config.max_rms_px))
    return refuse("misfit",
                  fmt::format("the spots lie {:.2f} px off on the average; at most {:.2f}", c.rms_px,
                              config.max_rms_px),
                  std::move(c));
  if (!(c.emitter_sigma_m <= config.max_emitter_sigma_m) || !(c.condition <= config.max_condition))
    return refuse("uncertain",
                  fmt::format("the emitter's place in the palm is known to {:.1f} mm only (at most {:.1f}; "
                              "condition {:.0f}): turn the palm more, about two axes",
                              1e3 * c.emitter_sigma_m, 1e3 * config.max_emitter_sigma_m, c.condition),
                  std::move(c));
  if (!(c.error_m <= config.max_error_m))
    return refuse(
        "uncertain",
        fmt::format("points would be placed {:.1f} mm off on the average; at most {:.1f}: add poses, "
                    "farther apart and turned more",
                    1e3 * c.error_m, 1e3 * config.max_error_m),
        std::move(c));
  return c;
}

}  // namespace colift::perception
