#pragma once

#include <Eigen/Core>

// Small dense algebra that several rooms need. Eigen's decompositions of fixed sizes take seconds to compile,
// in every file that calls one: they are compiled once here (symmetric.cpp), and called.
namespace colift::hal {

/// Solves A x = b for a symmetric, positive semi-definite A of NxN, of which the lower half is read (Eigen's
/// pivoted LDLT). Sizes: 3 (double and float), 5, 6 (double). Not finite where A or b is not.
template <typename Scalar, int N>
[[nodiscard]] Eigen::Matrix<Scalar, N, 1> solve_symmetric(const Eigen::Matrix<Scalar, N, N>& A,
                                                          const Eigen::Matrix<Scalar, N, 1>& b);

/// Eigenvalues in ascending order, and their unit eigenvectors as columns, of a symmetric 6x6 matrix. Of a
/// fixed size, because the object's motion, and with it every recorded lift, depends on its last bits.
struct SymmetricEigen6 {
  Eigen::Matrix<double, 6, 1> values;
  Eigen::Matrix<double, 6, 6> vectors;
};
[[nodiscard]] SymmetricEigen6 symmetric_eigen(const Eigen::Matrix<double, 6, 6>& A);

/// Matrices and vectors of any size up to 16, without an allocation.
using SmallMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 16, 16>;
using SmallVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 16, 1>;

/// As solve_symmetric(), for any size up to 16 and one or more right sides (the columns of B).
[[nodiscard]] SmallMatrix solve_small_symmetric(const SmallMatrix& A, const SmallMatrix& B);

/// Eigenvalues in ascending order, and their unit eigenvectors as columns, of a symmetric matrix up to 16x16.
struct SmallSymmetricEigen {
  SmallVector values;
  SmallMatrix vectors;
};
[[nodiscard]] SmallSymmetricEigen small_symmetric_eigen(const SmallMatrix& A);

/// Determinant of a symmetric, positive semi-definite 6x6 matrix, of which the lower half is read.
[[nodiscard]] double symmetric_determinant(const Eigen::Matrix<double, 6, 6>& A);

}  // namespace colift::hal
