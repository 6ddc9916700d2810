#include "reference.hpp"

#include <cmath>

namespace reference {
namespace {

Eigen::Matrix<Real, 3, 3> cross_of(const Vec3& p) {
  Eigen::Matrix<Real, 3, 3> m;
  m << 0, -p.z(), p.y(), p.z(), 0, -p.x(), -p.y(), p.x(), 0;
  return m;
}

}  // namespace

Program make_program(const SharingWeights& weights, const SharingLimits& limits, const Vec3& p1,
                     const Vec3& p2, const Wrench& task) {
  Program r;
  const Real e2 = Real(weights.epsilon) * weights.epsilon;
  const Real w1 = Real(weights.omega1_per_m) * weights.omega1_per_m;
  const Real w2 = Real(weights.omega2_per_m) * weights.omega2_per_m;
  r.q.resize(12);
  r.q << Vector::Constant(3, 1), Vector::Constant(3, w1), Vector::Constant(3, e2),
      Vector::Constant(3, e2 * w2);
  r.e = Matrix::Zero(6, 12);
  r.e.block(0, 0, 3, 3).setIdentity();
  r.e.block(0, 6, 3, 3).setIdentity();
  r.e.block(3, 0, 3, 3) = cross_of(p1);
  r.e.block(3, 3, 3, 3).setIdentity();
  r.e.block(3, 6, 3, 3) = cross_of(p2);
  r.e.block(3, 9, 3, 3).setIdentity();
  r.w.resize(6);
  r.w << task.force.cast<Real>(), task.torque.cast<Real>();
  r.limits.resize(12);
  r.limits << Vector::Constant(3, limits.partner.force_n), Vector::Constant(3, limits.partner.torque_nm),
      Vector::Constant(3, limits.robot.force_n), Vector::Constant(3, limits.robot.torque_nm);
  return r;
}

Vector solve_kkt(const Program& p) {
  Matrix k = Matrix::Zero(18, 18);
  k.topLeftCorner(12, 12) = p.q.asDiagonal();
  k.topRightCorner(12, 6) = p.e.transpose();
  k.bottomLeftCorner(6, 12) = p.e;
  Vector right = Vector::Zero(18);
  right.tail(6) = p.w;
  return k.fullPivLu().solve(right).head(12);
}

double cost_by_quad_kkt(const Program& p) {
  __extension__ using Quad = __float128;
  constexpr int n = 18;
  static Quad a[n][n + 1];
  for (auto& row : a) std::fill(std::begin(row), std::end(row), Quad(0));
  for (int i = 0; i < 12; ++i) {
    a[i][i] = p.q[i];
    for (int j = 0; j < 6; ++j) a[i][12 + j] = a[12 + j][i] = p.e(j, i);
  }
  for (int j = 0; j < 6; ++j) a[12 + j][n] = p.w[j];
  const auto size = [](Quad v) { return v < 0 ? -v : v; };
  int order[n];
  for (int i = 0; i < n; ++i) order[i] = i;
  for (int k = 0; k < n; ++k) {
    int row = k, col = k;
    for (int i = k; i < n; ++i) {
      for (int j = k; j < n; ++j) {
        if (size(a[i][j]) > size(a[row][col])) row = i, col = j;
      }
    }
    std::swap(a[k], a[row]);
    for (auto& r : a) std::swap(r[k], r[col]);
    std::swap(order[k], order[col]);
    for (int i = k + 1; i < n; ++i) {
      const Quad f = a[i][k] / a[k][k];
      for (int j = k; j <= n; ++j) a[i][j] -= f * a[k][j];
    }
  }
  Quad sum = 0;
  for (int k = n - 1; k >= 0; --k) {
    for (int j = k + 1; j < n; ++j) a[k][n] -= a[k][j] * a[j][n];
    a[k][n] /= a[k][k];
    if (order[k] < 12) sum += Quad(p.q[order[k]]) * a[k][n] * a[k][n];
  }
  return static_cast<double>(sum);
}

Interior interior_point(const Vector& q, const Vector& c, const Matrix& e, const Vector& w, const Matrix& g,
                        const Vector& h) {
  const Eigen::Index n = q.size(), m = e.rows(), k = g.rows();
  Interior out;
  Vector x = Vector::Zero(n), y = Vector::Zero(m), z = Vector::Ones(k), s = (h - g * x).cwiseMax(Real(1));
  const Real scale = 1 + w.cwiseAbs().maxCoeff() + h.cwiseAbs().maxCoeff();
  for (int step = 0; step < 120; ++step) {
    const Vector r_dual = q.cwiseProduct(x) + c + e.transpose() * y + g.transpose() * z;
    const Vector r_eq = e * x - w;
    const Vector r_in = g * x + s - h;
    const Real gap = s.dot(z) / Real(k);
    const Real dual_scale = 1 + q.cwiseProduct(x).cwiseAbs().maxCoeff() + c.cwiseAbs().maxCoeff();
    const Real value = std::abs(x.dot(q.cwiseProduct(x))) + std::abs(c.dot(x));
    if (r_dual.cwiseAbs().maxCoeff() < 1e-12L * dual_scale && r_eq.cwiseAbs().maxCoeff() < 1e-13L * scale &&
        r_in.cwiseAbs().maxCoeff() < 1e-13L * scale && gap * Real(k) < 1e-11L * (value + 1e-12L)) {
      out.converged = true;
      break;
    }
    const Vector d = z.cwiseQuotient(s);
    Matrix kkt = Matrix::Zero(n + m, n + m);
    kkt.topLeftCorner(n, n) = g.transpose() * d.asDiagonal() * g;
    kkt.topLeftCorner(n, n).diagonal() += q;
    kkt.topRightCorner(n, m) = e.transpose();
    kkt.bottomLeftCorner(m, n) = e;
    const Eigen::PartialPivLU<Matrix> lu(kkt);
    Vector dx, dy, dz, ds;
    const auto solve = [&](const Vector& r_comp) {  // s dz + z ds = -r_comp
      Vector right(n + m);
      right.head(n) = -r_dual - g.transpose() * (d.cwiseProduct(r_in) - r_comp.cwiseQuotient(s));
      right.tail(m) = -r_eq;
      const Vector sol = lu.solve(right);
      dx = sol.head(n);
      dy = sol.tail(m);
      ds = -r_in - g * dx;
      dz = (-r_comp - z.cwiseProduct(ds)).cwiseQuotient(s);
    };
    const auto longest = [&](const Vector& v, const Vector& dv) {
      Real a = 1;
      for (Eigen::Index i = 0; i < v.size(); ++i) {
        if (dv[i] < 0) a = std::min(a, -v[i] / dv[i]);
      }
      return a;
    };
    solve(s.cwiseProduct(z));
    const Real ap = longest(s, ds), ad = longest(z, dz);
    const Real predicted = (s + ap * ds).dot(z + ad * dz) / Real(k);
    const Real centre = std::pow(predicted / gap, Real(3));
    solve(s.cwiseProduct(z) + ds.cwiseProduct(dz) - Vector::Constant(k, centre * gap));
    const Real bp = std::min<Real>(1, Real(0.995) * longest(s, ds)),
               bd = std::min<Real>(1, Real(0.995) * longest(z, dz));
    const Real both =
        q.isZero() ? Real(0) : std::min(bp, bd);  // one step length keeps a quadratic's duals honest
    const Real step_p = both > 0 ? both : bp, step_d = both > 0 ? both : bd;
    x += step_p * dx;
    s += step_p * ds;
    y += step_d * dy;
    z += step_d * dz;
    if (!x.allFinite()) break;
  }
  out.x = x;
  return out;
}

Interior solve_limited(const Program& p) {
  std::vector<int> bounded;
  for (int i = 0; i < 12; ++i) {
    if (std::isfinite(static_cast<double>(p.limits[i]))) bounded.push_back(i);
  }
  if (bounded.empty()) return {solve_kkt(p), true};
  const auto k = static_cast<Eigen::Index>(bounded.size());
  Matrix g = Matrix::Zero(2 * k, 12);
  Vector h(2 * k);
  for (Eigen::Index i = 0; i < k; ++i) {
    g(i, bounded[static_cast<std::size_t>(i)]) = 1;
    g(k + i, bounded[static_cast<std::size_t>(i)]) = -1;
    h[i] = h[k + i] = p.limits[bounded[static_cast<std::size_t>(i)]];
  }
  return interior_point(p.q, Vector::Zero(12), p.e, p.w, g, h);
}

std::optional<Real> needed_factor(const Program& p) {
  // thirteenth unknown t: |x_i| <= t limits_i, least t
  std::vector<int> bounded;
  for (int i = 0; i < 12; ++i) {
    if (std::isfinite(static_cast<double>(p.limits[i]))) bounded.push_back(i);
  }
  if (bounded.empty()) return std::nullopt;
  const auto k = static_cast<Eigen::Index>(bounded.size());
  Matrix g = Matrix::Zero(2 * k, 13), e = Matrix::Zero(6, 13);
  e.leftCols(12) = p.e;
  for (Eigen::Index i = 0; i < k; ++i) {
    const int at = bounded[static_cast<std::size_t>(i)];
    g(i, at) = 1;
    g(k + i, at) = -1;
    g(i, 12) = g(k + i, 12) = -p.limits[at];
  }
  Vector c = Vector::Zero(13);
  c[12] = 1;
  const Interior r = interior_point(Vector::Zero(13), c, e, p.w, g, Vector::Zero(2 * k));
  if (!r.converged) return std::nullopt;
  return r.x[12];
}

Real cost(const Program& p, const Vector& x) {
  return x.dot(p.q.cwiseProduct(x));
}

}  // namespace reference
