#include "perception/partner/local_shape.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

#include "hal/types/symmetric.hpp"

namespace colift::perception {
namespace {

using Eigen::Matrix3f;
using Eigen::Vector3f;

// The surface has one point for each patch (PartnerConfig::cell_m, 15 mm): neighbours lie within three
// patches.
constexpr float kNeighbours_m = 0.045F;
constexpr int kFewestBroad =
    14;  // what has fewer points at 3 to 8 cm from its edge is but the side of a board
// Guards against faces and edges of a few stray points, and bounds of the work per frame.
constexpr int kFewestOnFace = 15, kFewestOnLine = 8, kMostFaces = 3, kMostRims = 5, kSeeds = 16;

struct Moments {
  Vector3f sum = Vector3f::Zero();
  Matrix3f squares = Matrix3f::Zero();
  int n = 0;
  void add(const Vector3f& p) {
    sum += p;
    squares += p * p.transpose();
    ++n;
  }
  [[nodiscard]] Vector3f mean() const { return sum / static_cast<float>(n); }
  // eigenvectors in ascending order of the spread; false when there are too few points
  bool axes(Matrix3f& vectors, Vector3f& variances) const {
    if (n < 3) return false;
    const Vector3f m = mean();
    Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
    solver.computeDirect((squares / static_cast<float>(n) - m * m.transpose()).cast<double>());
    vectors = solver.eigenvectors().cast<float>();
    variances = solver.eigenvalues().cast<float>().cwiseMax(0.0F);
    return true;
  }
};

}  // namespace

LocalShape::LocalShape(std::span<const Vector3f> surface, std::span<const Vector3f> outline,
                       const Vector3f& eye, const Vector3f& place, float radius_m,
                       const LocalShapeConfig& config)
    : config_(config), eye_(eye - place), radius_(radius_m), place_(place) {
  const float squared = radius_m * radius_m;
  std::vector<Vector3f> wider;
  for (const Vector3f& p : surface) {
    const float off = (p - place).squaredNorm();
    if (off < squared) surface_.push_back(p - place);
    if (off < 2.25F * squared) wider.push_back(p - place);
  }
  for (const Vector3f& p : outline)
    if ((p - place).squaredNorm() < squared) outline_.push_back(p - place);
  find_bar(wider);
  if (bar_) return;
  find_faces();
  find_corners();
  find_rims();
}

void LocalShape::find_faces() {
  const auto on_face = static_cast<float>(config_.face_tolerance_m);
  face_of_.assign(surface_.size(), -1);
  for (int face = 0; face < kMostFaces; ++face) {
    std::vector<std::size_t> left;
    for (std::size_t i = 0; i < surface_.size(); ++i)
      if (face_of_[i] < 0) left.push_back(i);
    if (left.size() < kFewestOnFace) return;
    Vector3f normal, point;
    int most = 0;
    for (int s = 0; s < kSeeds; ++s) {
      const Vector3f seed = surface_[left[left.size() * static_cast<std::size_t>(s) / kSeeds]];
      Moments m;
      for (const std::size_t i : left)
        if ((surface_[i] - seed).squaredNorm() < kNeighbours_m * kNeighbours_m) m.add(surface_[i]);
      Matrix3f v;
      Vector3f e;
      if (m.n < 6 || !m.axes(v, e)) continue;
      const Vector3f n = v.col(0), at = m.mean();
      int count = 0;
      for (const std::size_t i : left) count += std::abs(n.dot(surface_[i] - at)) < on_face ? 1 : 0;
      if (count <= most) continue;
      most = count;
      normal = n;
      point = at;
    }
    if (most < kFewestOnFace) return;
    for (int round = 0; round < 2; ++round) {
      Moments m;
      for (const std::size_t i : left)
        if (std::abs(normal.dot(surface_[i] - point)) < on_face) m.add(surface_[i]);
      Matrix3f v;
      Vector3f e;
      if (!m.axes(v, e)) break;
      normal = v.col(0);
      point = m.mean();
    }
    if (normal.dot(eye_ - point) < 0.0F) normal = -normal;
    LocalFace found{point + place_, normal, 0};
    for (const std::size_t i : left) {
      if (std::abs(normal.dot(surface_[i] - point)) > 1.5F * on_face) continue;
      face_of_[i] = static_cast<std::int8_t>(face);
      found.points += std::abs(normal.dot(surface_[i] - point)) < on_face ? 1 : 0;
    }
    faces_.push_back(found);
  }
}

void LocalShape::find_corners() {
  for (std::size_t a = 0; a < faces_.size(); ++a) {
    for (std::size_t b = a + 1; b < faces_.size(); ++b) {
      const Vector3f &n = faces_[a].normal, &m = faces_[b].normal;
      const Vector3f across = n.cross(m);
      const float sine = across.norm();
      if (sine < 0.5F) continue;
      const float da = n.dot(faces_[a].point - place_), db = m.dot(faces_[b].point - place_);
      const Vector3f d = across / sine;
      const Vector3f point = (da * m.cross(across) + db * across.cross(n)) / (sine * sine);
      // each face must reach the edge, and lie behind the other one, else they meet in an inner corner
      EdgeLine line{point + place_, d, std::numeric_limits<float>::max(),
                    std::numeric_limits<float>::lowest(), true};
      int near[2] = {0, 0}, before = 0, behind = 0;
      int broad[2] = {0, 0};
      for (std::size_t i = 0; i < surface_.size(); ++i) {
        if (face_of_[i] != static_cast<int>(a) && face_of_[i] != static_cast<int>(b)) continue;
        const bool of_a = face_of_[i] == static_cast<int>(a);
        const float height = of_a ? m.dot(surface_[i]) - db : n.dot(surface_[i]) - da;
        height > 0.015F ? ++before : ++behind;
        const Vector3f p = surface_[i] - point;
        const float t = d.dot(p);
        const float off = (p - t * d).norm();
        if (off > 0.03F && off < 0.08F && std::abs(d.dot(surface_[i])) < 0.08F) ++broad[of_a ? 0 : 1];
        if (off > 0.035F) continue;
        ++near[of_a ? 0 : 1];
        line.begin = std::min(line.begin, t);
        line.end = std::max(line.end, t);
      }
      if (std::min(broad[0], broad[1]) < kFewestBroad) continue;
      if (near[0] < 4 || near[1] < 4 || before * 4 > behind) continue;
      edges_.push_back(line);
    }
  }
}

void LocalShape::find_rims() {
  const auto on_line = static_cast<float>(config_.line_tolerance_m);
  std::vector<Vector3f> left = outline_;
  for (int k = 0; k < kMostRims && left.size() >= kFewestOnLine; ++k) {
    Vector3f point, direction;
    int most = 0;
    for (int s = 0; s < kSeeds; ++s) {
      const Vector3f seed = left[left.size() * static_cast<std::size_t>(s) / kSeeds];
      Moments m;
      for (const Vector3f& p : left)
        if ((p - seed).squaredNorm() < kNeighbours_m * kNeighbours_m) m.add(p);
      Matrix3f v;
      Vector3f e;
      if (m.n < 4 || !m.axes(v, e)) continue;
      const Vector3f d = v.col(2), at = m.mean();
      int count = 0;
      for (const Vector3f& p : left)
        count += ((p - at) - d.dot(p - at) * d).squaredNorm() < on_line * on_line ? 1 : 0;
      if (count <= most) continue;
      most = count;
      point = at;
      direction = d;
    }
    if (most < kFewestOnLine) return;
    for (int round = 0; round < 2; ++round) {
      Moments m;
      for (const Vector3f& p : left)
        if (((p - point) - direction.dot(p - point) * direction).squaredNorm() < on_line * on_line) m.add(p);
      Matrix3f v;
      Vector3f e;
      if (!m.axes(v, e)) break;
      direction = v.col(2);
      point = m.mean();
    }
    EdgeLine line{point + place_, direction, std::numeric_limits<float>::max(),
                  std::numeric_limits<float>::lowest(), false};
    std::vector<Vector3f> rest;
    for (const Vector3f& p : left) {
      const float t = direction.dot(p - point);
      if (((p - point) - t * direction).squaredNorm() > 2.25F * on_line * on_line) {
        rest.push_back(p);
        continue;
      }
      line.begin = std::min(line.begin, t);
      line.end = std::max(line.end, t);
    }
    left.swap(rest);
    if (line.end - line.begin > static_cast<float>(config_.min_rim_length_m)) edges_.push_back(line);
  }
}

// A round bar is long, and a circle fits its section clearly better than one or two straight lines could.
void LocalShape::find_bar(const std::vector<Eigen::Vector3f>& surface) {
  const auto on_line = static_cast<float>(config_.line_tolerance_m);
  Moments m;
  for (const Vector3f& p : surface) m.add(p);
  Matrix3f v;
  Vector3f e;
  if (m.n < kFewestOnFace || !m.axes(v, e)) return;
  if (e[2] < 4.0F * e[1]) return;
  const Vector3f d = v.col(2), middle = m.mean();
  const Vector3f a = v.col(1), b = v.col(0);
  // circle: Kasa's linear fit, then Gauss-Newton on the distances
  Matrix3f normal = Matrix3f::Zero();
  Vector3f right = Vector3f::Zero();
  for (const Vector3f& p : surface) {
    const Vector3f row(a.dot(p - middle), b.dot(p - middle), 1.0F);
    normal += row * row.transpose();
    right += row * (row.x() * row.x() + row.y() * row.y());
  }
  const Vector3f solved = hal::solve_symmetric(normal, right);
  float cx = 0.5F * solved.x(), cy = 0.5F * solved.y();
  float r = std::sqrt(std::max(1e-6F, solved.z() + cx * cx + cy * cy));
  float rms = 0.0F;
  for (int round = 0; round < 6; ++round) {
    normal.setZero();
    right.setZero();
    rms = 0.0F;
    for (const Vector3f& p : surface) {
      const float x = a.dot(p - middle) - cx, y = b.dot(p - middle) - cy,
                  away = std::max(1e-4F, std::hypot(x, y));
      const Vector3f row(x / away, y / away, 1.0F);
      const float error = away - r;
      // ragged edges leave points off the bar
      const float weight = 1.0F / (1.0F + error * error / (on_line * on_line));
      normal += weight * row * row.transpose();
      right += weight * error * row;
      rms += weight * error * error;
    }
    const Vector3f step = hal::solve_symmetric<float, 3>(normal + 1e-3F * Matrix3f::Identity(), right);
    cx += step.x();
    cy += step.y();
    r += step.z();
  }
  rms = std::sqrt(rms / static_cast<float>(m.n));
  if (!(r > static_cast<float>(config_.min_bar_radius_m) && r < static_cast<float>(config_.max_bar_radius_m)))
    return;
  if (rms > static_cast<float>(config_.max_bar_residual_m) || rms > 0.5F * std::sqrt(e[0])) return;
  RoundBar bar{middle + cx * a + cy * b + place_, d, r};
  // its axis lies behind its surface
  if ((bar.point - (middle + place_)).dot(middle - eye_) < 0.0F) return;
  bar_ = bar;
}

}  // namespace colift::perception
