// The camera's pose of a calibration: all that a run needs of the model.

#include "perception/calibration/emitter_model.hpp"

namespace colift::perception {

Pose EmitterModel::X_BC() const {
  Pose X = Pose::Identity();
  X.linear() = R_CB.transpose();
  X.translation() = -(R_CB.transpose() * t_CB);
  return X;
}

void EmitterModel::set_X_BC(const Pose& X_BC) {
  R_CB = X_BC.linear().transpose();
  t_CB = -(R_CB * X_BC.translation());
}

}  // namespace colift::perception
