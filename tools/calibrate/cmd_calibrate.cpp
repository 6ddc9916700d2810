#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <string>

#include "perception/calibration/calibration_file.hpp"
#include "tools/calibrate/calibrate.hpp"
#include "tools/cli/config_of.hpp"
#include "tools/cli/interrupt.hpp"
#include "tools/cli/numbers.hpp"
#include "tools/cli/session.hpp"
#include "tools/cli/today.hpp"
#include "tools/rig/wired_devices.hpp"
#include "tools/visualization/file_output.hpp"

namespace colift::tools {
namespace {

using hal::ErrorCode;

constexpr std::uint64_t kNextSeed = 7001;  // other candidates than the poses were chosen from

/// Samples, and what is known beyond them.
struct Taken {
  perception::SampleSet set;
  std::optional<hal::Pose> true_X_BC;
  std::string source;
};

hal::Result<Taken> take(const CommonOptions& common, const CalibrateOptions& o, const Setup& setup,
                        const std::string& date) {
  Taken taken;
  if (o.samples) {
    auto set = perception::load_samples(*o.samples, hal::built_in_robot(), setup.config.spot);
    if (!set) return tl::unexpected(set.error());
    taken.set = std::move(*set);
    taken.source = o.samples->filename().empty() ? o.samples->parent_path().filename().string()
                                                 : o.samples->filename().string();
    return taken;
  }
  LiveSetting live;
  live.poses = o.poses;
  live.seed = o.seed;
  live.date = date;
  live.save = o.save;
  if (!common.quiet) live.say = [](const std::string& line) { std::fputs((line + "\n").c_str(), stderr); };
  std::optional<hal::Vec3> camera_at;
  if (!o.camera_at.empty()) {
    const auto at = parse_point(o.camera_at, "--camera-at");
    if (!at) return tl::unexpected(at.error());
    camera_at = *at;
  }
  // a cleared floor unless a scenario says otherwise
  const auto scenario = o.scenario ? o.scenario : std::optional<std::filesystem::path>(kClearedFloor);
  auto rig = open_rig({o.robot, scenario, o.seed, std::nullopt, true}, setup.config, &wired_devices());
  if (!rig) return tl::unexpected(rig.error());
  hal::InfraredCamera* infrared = rig->infrared.get();
  if (infrared == nullptr) infrared = dynamic_cast<hal::InfraredCamera*>(rig->robot.camera.get());
  if (infrared == nullptr)
    return hal::failure(ErrorCode::BadConfig, o.robot ? o.robot->string() : "calibrate",
                        "this camera gives no infrared images; expected a simulated one or a Kinect");
  if (rig->truth) taken.true_X_BC = rig->true_X_WC;
  if (!camera_at && !taken.true_X_BC)
    return hal::failure(ErrorCode::BadInput, "--camera-at",
                        "an approximate camera position is needed (to 0.5 m): X,Y,Z in "
                        "the base");
  // in simulation as roughly as a person would say it
  live.camera_at_B = camera_at
                         ? *camera_at
                         : hal::Vec3((taken.true_X_BC->translation() * 4.0).array().round().matrix() / 4.0);
  taken.source = rig->name;
  auto set = take_samples(*rig, *infrared, setup.hand, setup.config, live);
  if (!set) return tl::unexpected(set.error());
  taken.set = std::move(*set);
  return taken;
}

std::optional<perception::ProposedPose> next_pose(const perception::SampleSet& set,
                                                  const perception::Calibration* solved,
                                                  const control::Config& config, std::uint64_t seed) {
  if (solved == nullptr || solved->inliers < 5) return std::nullopt;
  std::vector<hal::Pose> done;
  for (std::size_t i = 0; i < set.samples.size(); ++i)
    if (solved->samples[i].inlier) done.push_back(set.samples[i].X_BH);
  perception::PoseConfig poses = config.calibration_poses;
  poses.candidates = poses.next_candidates;
  const auto candidates = perception::candidate_poses(hal::built_in_robot(), solved->model,
                                                      config.calibration, poses, seed + kNextSeed);
  auto chosen = perception::choose_poses(candidates, done, solved->model, config.calibration, 1);
  if (chosen.empty()) return std::nullopt;
  return chosen.front();
}

double true_error(const hal::Pose& found, const hal::Pose& truth,
                  const perception::CalibrationConfig& config) {
  double sum = 0.0;
  const auto grid = perception::workspace_grid(config);
  const hal::Pose shift = found * truth.inverse();
  for (const hal::Vec3& p : grid) sum += (shift * p - p).squaredNorm();
  return std::sqrt(sum / static_cast<double>(grid.size()));
}

}  // namespace

int cmd_calibrate(const CommonOptions& common, const CalibrateOptions& o) {
  if ((o.samples ? 1 : 0) + (o.sim ? 1 : 0) + (o.robot ? 1 : 0) != 1)
    return report_error("calibrate", {ErrorCode::BadInput, "arguments",
                                      "expected one of --samples FOLDER, --sim and --robot FILE"});
  if (o.poses < 5 || o.poses > 200)
    return report_error(
        "calibrate", {ErrorCode::BadInput, "--poses", fmt::format("found {}; expected 5 to 200", o.poses)});
  const auto setup = load_setup(config_of(common, control::Command::Calibrate));
  if (!setup) return report_error("calibrate", setup.error());
  show_warnings("calibrate", common, *setup);

  const InterruptGuard signals;
  const std::string date = o.date.empty() ? today() : o.date;
  const auto taken = take(common, o, *setup, date);
  if (InterruptGuard::asked()) return kInterrupted;
  if (!taken) return report_error("calibrate", taken.error());

  const auto& config = setup->config.calibration;
  const auto solved = perception::calibrate(taken->set.samples, taken->set.camera, config, o.seed);
  CalibrationView view;
  view.set = &taken->set;
  view.solved = solved ? &*solved : solved.error().solved ? &*solved.error().solved : nullptr;
  view.date = !taken->set.date.empty() ? taken->set.date : date;
  view.method = fmt::format("blinking emitter on the palm, {} poses of {}, seed {}",
                            taken->set.samples.size(), taken->source, o.seed);
  if (solved) {
    view.reason = fmt::format("points are placed {:.1f} mm off on the average, by {} of {} poses",
                              1e3 * solved->error_m, solved->inliers, solved->samples.size());
  } else {
    view.refused_kind = solved.error().kind;
    view.reason = solved.error().reason;
  }
  view.next = next_pose(taken->set, view.solved, setup->config, o.seed);
  if (taken->true_X_BC && view.solved)
    view.true_error_m = true_error(view.solved->model.X_BC(), *taken->true_X_BC, config);

  if (solved && o.out) {
    const std::string yaml = perception::text_of(perception::file_of(*solved, view.date, view.method));
    if (auto done =
            picture::write_file(*o.out, {reinterpret_cast<const std::uint8_t*>(yaml.data()), yaml.size()});
        !done)
      return report_error("calibrate", done.error());
  }
  if (o.png)
    if (auto done = write_calibration_picture(*o.png, view); !done)
      return report_error("calibrate", done.error());
  if (common.json)
    std::puts(calibration_document(view).c_str());
  else
    std::fputs((common.quiet ? view.reason + "\n" : calibration_text(view)).c_str(), stdout);
  if (solved && o.out && !common.quiet) std::fprintf(stderr, "written: %s\n", o.out->c_str());
  return solved ? kDone : kNoGoal;
}

}  // namespace colift::tools
