#include "hal/types/symmetric.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <type_traits>

namespace colift::hal {
namespace {

// one decomposition for all sizes in double: each that is instantiated takes ten seconds to compile
using SymmetricSolver = Eigen::LDLT<SmallMatrix>;

}  // namespace

template <typename Scalar, int N>
Eigen::Matrix<Scalar, N, 1> solve_symmetric(const Eigen::Matrix<Scalar, N, N>& A,
                                            const Eigen::Matrix<Scalar, N, 1>& b) {
  if constexpr (std::is_same_v<Scalar, double>)
    return SymmetricSolver(A).solve(b);
  else
    return A.ldlt().solve(b);
}

template Eigen::Vector3f solve_symmetric(const Eigen::Matrix3f&, const Eigen::Vector3f&);
template Eigen::Vector3d solve_symmetric(const Eigen::Matrix3d&, const Eigen::Vector3d&);
template Eigen::Matrix<double, 5, 1> solve_symmetric(const Eigen::Matrix<double, 5, 5>&,
                                                     const Eigen::Matrix<double, 5, 1>&);
template Eigen::Matrix<double, 6, 1> solve_symmetric(const Eigen::Matrix<double, 6, 6>&,
                                                     const Eigen::Matrix<double, 6, 1>&);

SymmetricEigen6 symmetric_eigen(const Eigen::Matrix<double, 6, 6>& A) {
  const Eigen::SelfAdjointEigenSolver<SmallMatrix> solver(A);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

SmallMatrix solve_small_symmetric(const SmallMatrix& A, const SmallMatrix& B) {
  return SymmetricSolver(A).solve(B);
}

SmallSymmetricEigen small_symmetric_eigen(const SmallMatrix& A) {
  const Eigen::SelfAdjointEigenSolver<SmallMatrix> solver(A);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

double symmetric_determinant(const Eigen::Matrix<double, 6, 6>& A) {
  return SymmetricSolver(A).vectorD().prod();
}

}  // namespace colift::hal
