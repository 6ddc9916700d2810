#include "hal/drivers/recorded/pinhole_fit.hpp"

#include <algorithm>
#include <cmath>

#include "hal/types/symmetric.hpp"

namespace colift::hal {
namespace {

constexpr std::size_t kSamples = 20000;
constexpr std::size_t kFewest = 8;
constexpr double kWidestTangent = 4.0;  // 76 degrees off axis; beyond, a pinhole is no model of any camera

double median(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

struct Line {
  double slope = 0.0, offset = 0.0;
};

// pixel = slope * tangent + offset, for data of which a part may be anything.
std::optional<Line> fit_line(const std::vector<double>& tangent, const std::vector<double>& pixel) {
  const std::size_t n = tangent.size();
  const auto [low, high] = std::minmax_element(tangent.begin(), tangent.end());
  const double spread = *high - *low;
  if (!(spread > 1e-6)) return std::nullopt;

  // start: the median over pairs far apart, which a quarter of outliers does not move
  std::vector<double> scratch;
  scratch.reserve(n);
  for (const double least : {0.2, 0.02, 0.0}) {
    scratch.clear();
    for (std::size_t i = 0; i < n; ++i) {
      const std::size_t j = (i * 7919 + n / 3 + 1) % n;
      const double run = tangent[j] - tangent[i];
      if (std::abs(run) > least * spread) scratch.push_back((pixel[j] - pixel[i]) / run);
    }
    if (scratch.size() >= n / 10 + 1) break;
  }
  if (scratch.empty()) return std::nullopt;
  Line line;
  line.slope = median(scratch);
  scratch.resize(n);
  for (std::size_t i = 0; i < n; ++i) scratch[i] = pixel[i] - line.slope * tangent[i];
  line.offset = median(scratch);

  // then least squares over what agrees with it
  for (int round = 0; round < 4; ++round) {
    for (std::size_t i = 0; i < n; ++i)
      scratch[i] = std::abs(pixel[i] - line.slope * tangent[i] - line.offset);
    const double limit = std::max(1e-3, 4.5 * median(scratch));
    double count = 0.0, st = 0.0, sp = 0.0, stt = 0.0, stp = 0.0;
    for (std::size_t i = 0; i < n; ++i) {
      if (!(std::abs(pixel[i] - line.slope * tangent[i] - line.offset) <= limit)) continue;
      count += 1.0;
      st += tangent[i];
      sp += pixel[i];
      stt += tangent[i] * tangent[i];
      stp += tangent[i] * pixel[i];
    }
    const double variance = stt - st * st / count;
    if (count < 2.0 || !(variance > 1e-12 * count)) return std::nullopt;
    line.slope = (stp - st * sp / count) / variance;
    line.offset = (sp - line.slope * st) / count;
  }
  return line;
}

Vec3 point(const PointFile& file, std::size_t i) {
  return {file.x[i], file.y[i], file.z[i]};
}

std::size_t row_of(std::size_t i, std::size_t width) {
  return i / width;
}

// Every n-th point that was seen, at most `most` of them.
std::vector<std::size_t> sample(const PointFile& file, std::size_t most) {
  std::vector<std::size_t> seen;
  for (std::size_t i = 0; i < file.size(); ++i) {
    if (file.seen(i)) seen.push_back(i);
  }
  const std::size_t step = seen.size() / most + 1;
  std::vector<std::size_t> out;
  for (std::size_t i = 0; i < seen.size(); i += step) out.push_back(seen[i]);
  return out;
}

}  // namespace

std::optional<PinholeFit> fit_pinhole(const PointFile& file, const Pose& X_FC) {
  const Pose X_CF = X_FC.inverse();
  const auto width = static_cast<std::size_t>(file.width);
  std::vector<double> a, b, u, v;
  for (const std::size_t i : sample(file, kSamples)) {
    const Vec3 p = X_CF * point(file, i);
    if (!(p.z() > 1e-6) || std::abs(p.x()) > kWidestTangent * p.z() ||
        std::abs(p.y()) > kWidestTangent * p.z())
      continue;
    a.push_back(p.x() / p.z());
    b.push_back(p.y() / p.z());
    u.push_back(static_cast<double>(i % width));
    v.push_back(static_cast<double>(row_of(i, width)));
  }
  if (a.size() < kFewest) return std::nullopt;
  const auto column = fit_line(a, u);
  const auto row = fit_line(b, v);
  if (!column || !row) return std::nullopt;
  // 2 to 160 degrees of view, pixels nearly square
  const double fx = column->slope, fy = row->slope;
  if (!(fx > 0.08 * file.width && fx < 30.0 * file.width && fy > 0.5 * fx && fy < 2.0 * fx))
    return std::nullopt;

  PinholeFit fit;
  fit.intrinsics = {file.width, file.height, fx, fy, column->offset, row->offset};
  fit.X_FC = X_FC;
  std::size_t seen = 0, agreeing = 0;
  for (std::size_t i = 0; i < file.size(); ++i) {
    if (!file.seen(i)) continue;
    ++seen;
    const Vec3 p = X_CF * point(file, i);
    const double du = fx * p.x() / p.z() + fit.intrinsics.cx - static_cast<double>(i % width);
    const double dv = fy * p.y() / p.z() + fit.intrinsics.cy - static_cast<double>(row_of(i, width));
    if (p.z() > 0.0 && std::abs(du) < 1.0 && std::abs(dv) < 1.0) ++agreeing;
  }
  fit.agreeing = static_cast<double>(agreeing) / static_cast<double>(seen);
  return fit;
}

std::optional<PinholeFit> fit_projection(const PointFile& file) {
  const std::vector<std::size_t> samples = sample(file, 4000);
  if (samples.size() < 30) return std::nullopt;
  const auto width = static_cast<std::size_t>(file.width);

  // points and pixels around zero and of size one, else the squares below lose all their digits
  Vec3 centre = Vec3::Zero();
  for (const std::size_t i : samples) centre += point(file, i);
  centre /= static_cast<double>(samples.size());
  double size = 0.0;
  for (const std::size_t i : samples) size += (point(file, i) - centre).norm();
  size /= static_cast<double>(samples.size());
  if (!(size > 1e-9)) return std::nullopt;
  const double half_width = 0.5 * file.width, half_height = 0.5 * file.height;
  const double pixels = half_width;

  Eigen::Matrix<double, 12, 12> normal = Eigen::Matrix<double, 12, 12>::Zero();
  for (const std::size_t i : samples) {
    const double u = (static_cast<double>(i % width) - half_width) / pixels;
    const double v = (static_cast<double>(row_of(i, width)) - half_height) / pixels;
    Eigen::Vector4d p;
    p << (point(file, i) - centre) / size, 1.0;
    Eigen::Matrix<double, 12, 1> row_u = Eigen::Matrix<double, 12, 1>::Zero(), row_v = row_u;
    row_u.segment<4>(0) = p;
    row_u.segment<4>(8) = -u * p;
    row_v.segment<4>(4) = p;
    row_v.segment<4>(8) = -v * p;
    normal.noalias() += row_u * row_u.transpose() + row_v * row_v.transpose();
  }
  const SmallSymmetricEigen eigen = small_symmetric_eigen(normal);
  const SmallVector& value = eigen.values;
  // a second direction as good as the best one: points in a plane, many cameras fit
  if (!(value[1] > 1e-9 * value[11]) || !(value[1] > 100.0 * std::abs(value[0]))) return std::nullopt;

  Eigen::Matrix<double, 3, 4> P;
  for (int r = 0; r < 3; ++r) P.row(r) = eigen.vectors.col(0).segment<4>(Eigen::Index{4} * r).transpose();
  Eigen::Matrix3d M = P.leftCols<3>();
  const double scale = M.row(2).norm();
  if (!(scale > 1e-12)) return std::nullopt;
  P /= scale;
  // depth must be positive where the points are
  if (P(2, 3) < 0.0) P = -P;
  M = P.leftCols<3>();

  const Vec3 z = M.row(2).transpose();
  const Vec3 across = M.row(0).transpose() - z * z.dot(M.row(0));
  const Vec3 down = M.row(1).transpose() - z * z.dot(M.row(1));
  if (!(across.norm() > 1e-6 && down.norm() > 1e-6)) return std::nullopt;
  const Vec3 x = across.normalized();
  const Vec3 y = z.cross(x);
  // a mirrored cloud has y upwards; skewed axes mean that no camera took this
  if (y.dot(down.normalized()) < 0.999) return std::nullopt;

  Pose X_FC = Pose::Identity();
  X_FC.linear().col(0) = x;
  X_FC.linear().col(1) = y;
  X_FC.linear().col(2) = z;
  X_FC.translation() = centre - size * M.inverse() * P.col(3);
  if (!X_FC.translation().allFinite()) return std::nullopt;
  return fit_pinhole(file, X_FC);
}

}  // namespace colift::hal
