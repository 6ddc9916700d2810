// The small algebra that is compiled once: against its definition, on random matrices and on singular ones.

#include "hal/types/symmetric.hpp"

#include <Eigen/LU>
#include <catch2/catch.hpp>
#include <limits>
#include <random>

using namespace colift;

namespace {

template <typename Scalar, int N>
void solves(std::mt19937_64& random, Scalar tolerance) {
  std::normal_distribution<Scalar> normal;
  for (int trial = 0; trial < 200; ++trial) {
    const Eigen::Matrix<Scalar, N, N> half =
        Eigen::Matrix<Scalar, N, N>::NullaryExpr([&] { return normal(random); });
    const Eigen::Matrix<Scalar, N, N> A =
        half * half.transpose() + Scalar(0.5) * Eigen::Matrix<Scalar, N, N>::Identity();
    const Eigen::Matrix<Scalar, N, 1> x =
        Eigen::Matrix<Scalar, N, 1>::NullaryExpr([&] { return normal(random); });
    const Eigen::Matrix<Scalar, N, 1> b = A * x;
    Eigen::Matrix<Scalar, N, N> lower = A;
    lower.template triangularView<Eigen::StrictlyUpper>().setConstant(
        std::numeric_limits<Scalar>::quiet_NaN());
    CHECK((hal::solve_symmetric(lower, b) - x).norm() < tolerance * (1 + x.norm()));
  }
}

}  // namespace

TEST_CASE("a symmetric system is solved from its lower half, at every size that is compiled", "[types]") {
  std::mt19937_64 random(3);
  solves<float, 3>(random, 2e-3F);
  solves<double, 3>(random, 1e-11);
  solves<double, 5>(random, 1e-11);
  solves<double, 6>(random, 1e-11);
}

TEST_CASE("a singular system gives a finite solution where there is one", "[types]") {
  const Eigen::Vector3d a(1.0, 2.0, -1.0);
  const Eigen::Matrix3d A = a * a.transpose();
  const Eigen::Vector3d x = hal::solve_symmetric<double, 3>(A, 6.0 * a);
  CHECK((A * x - 6.0 * a).norm() < 1e-9);
  CHECK_FALSE(hal::solve_symmetric<double, 3>(A, Eigen::Vector3d::Constant(NAN)).allFinite());
}

TEST_CASE("eigenvectors and eigenvalues put a 6x6 matrix together again", "[types]") {
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  using Matrix6 = Eigen::Matrix<double, 6, 6>;
  for (int trial = 0; trial < 100; ++trial) {
    const Matrix6 half = Matrix6::NullaryExpr([&] { return normal(random); });
    const Matrix6 A = half + half.transpose();
    const hal::SymmetricEigen6 eigen = hal::symmetric_eigen(A);
    CHECK((eigen.vectors * eigen.values.asDiagonal() * eigen.vectors.transpose() - A).norm() <
          1e-10 * (1 + A.norm()));
    for (int i = 0; i + 1 < 6; ++i) CHECK(eigen.values[i] <= eigen.values[i + 1]);
    const Matrix6 P = half * half.transpose();
    CHECK(hal::symmetric_determinant(P) == Approx(P.determinant()).epsilon(1e-8).margin(1e-9));
  }
}
