#include "perception/target/regions/silhouette.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

namespace colift::perception {
namespace {

constexpr double kSpacing_m = 0.010;  // of the points: a third of a bin
constexpr int kMaxStep = 6;

}  // namespace

Silhouette::Silhouette(const OrganisedCloud& cloud, const Components& components, const Fragment& object,
                       const Ground& ground)
    : eye_(cloud.X_WC.translation()), ground_(ground.plane) {
  const Vec3 up = ground.plane.normal;
  Vec3 ahead = object.box.center() - eye_;
  ahead -= up * up.dot(ahead);
  if (ahead.norm() < 1e-6) return;  // straight below the camera: there is no silhouette
  ahead_ = ahead.normalized();
  right_ = ahead_.cross(up);
  // every step-th pixel of every step-th row still meets each bin several times
  const double pixel_m = object.mean_depth_m / cloud.intrinsics.fx;
  const int step = std::clamp(static_cast<int>(kSpacing_m / std::max(1e-6, pixel_m)), 1, kMaxStep);
  points_.reserve(object.pixels / static_cast<std::size_t>(step * step) + 64);
  const std::vector<std::uint8_t> own = own_regions(object, components);
  for (const Components::Run& run : components.runs) {
    if (!own[static_cast<std::size_t>(run.label)] || run.row % step != 0) continue;
    const std::size_t row = static_cast<std::size_t>(run.row) * static_cast<std::size_t>(cloud.width());
    for (int u = run.first; u <= run.last; u += step) {
      const Vec3 p = cloud.point(row + static_cast<std::size_t>(u));
      const Vec3 d = p - eye_;
      points_.push_back({static_cast<float>(right_.dot(d)), static_cast<float>(ground.plane.height(p)),
                         static_cast<float>(ahead_.dot(d))});
      least_ = std::min(least_, right_.dot(d));
      most_ = std::max(most_, right_.dot(d));
    }
  }
  if (points_.empty()) return;
  const std::size_t bins = static_cast<std::size_t>((most_ - least_) / kBin_m) + 1;
  std::vector<std::array<float, 3>> highest(bins, {-1e3f, -1e3f, -1e3f});
  for (const Point& p : points_) {
    const double bin = (static_cast<double>(p.across) - least_) / kBin_m;
    auto& h = highest[std::min(bins - 1, static_cast<std::size_t>(std::max(0.0, bin)))];
    if (p.height <= h[2]) continue;
    h[2] = p.height;
    if (h[2] > h[1]) std::swap(h[1], h[2]);
    if (h[1] > h[0]) std::swap(h[0], h[1]);
  }
  top_.reserve(bins);
  for (const auto& h : highest) top_.push_back(h[2]);
}

double Silhouette::depth() const {
  if (points_.empty()) return 0.0;
  std::vector<float> along;
  along.reserve(points_.size());
  for (const Point& p : points_) along.push_back(p.along);
  const auto at = [&](double part) {
    const auto it = along.begin() + static_cast<std::ptrdiff_t>(part * static_cast<double>(along.size() - 1));
    std::nth_element(along.begin(), it, along.end());
    return static_cast<double>(*it);
  };
  return at(0.95) - at(0.05);
}

std::vector<Silhouette::Point> Silhouette::in(const Window& w) const {
  std::vector<Point> out;
  for (const Point& p : points_)
    if (p.across >= w.left && p.across <= w.right && p.height >= w.low && p.height <= w.high)
      out.push_back(p);
  return out;
}

Vec3 Silhouette::place(const Point& p) const {
  const Vec3 at = eye_ + static_cast<double>(p.across) * right_ + static_cast<double>(p.along) * ahead_;
  return ground_.foot(at) + static_cast<double>(p.height) * ground_.normal;
}

PointSpread spread(std::span<const Silhouette::Point> points) {
  if (points.empty()) return {};
  Vec3 mean = Vec3::Zero();
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
  for (const Silhouette::Point& p : points) {
    const Vec3 q(p.across, p.height, p.along);
    mean += q;
    second += q * q.transpose();
  }
  const auto n = static_cast<double>(points.size());
  mean /= n;
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes;
  axes.computeDirect(second / n - mean * mean.transpose());
  return {mean, axes.eigenvalues().cwiseMax(0.0).cwiseSqrt(), axes.eigenvectors()};
}

double fill(const std::vector<Silhouette::Point>& points, const Silhouette::Window& w) {
  constexpr double kBin_m = Silhouette::kBin_m;
  const auto columns = static_cast<std::size_t>(std::max(1.0, std::ceil((w.right - w.left) / kBin_m)));
  const auto rows = static_cast<std::size_t>(std::max(1.0, std::ceil((w.high - w.low) / kBin_m)));
  std::vector<bool> hit(columns * rows, false);
  for (const Silhouette::Point& p : points) {
    if (p.across < w.left || p.across > w.right || p.height < w.low || p.height > w.high) continue;
    const auto i = std::min(columns - 1, static_cast<std::size_t>((p.across - w.left) / kBin_m));
    const auto k = std::min(rows - 1, static_cast<std::size_t>((p.height - w.low) / kBin_m));
    hit[k * columns + i] = true;
  }
  return static_cast<double>(std::count(hit.begin(), hit.end(), true)) / static_cast<double>(hit.size());
}

}  // namespace colift::perception
