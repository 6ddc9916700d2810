#pragma once

namespace colift::control {

/// Whether the load on the hand has come to rest: two hands that have raised an object pass load to and fro
/// for a second or two. A fast and a slow mean of the load differ while it changes.
class SteadyLoad {
 public:
  /// From now on, with means that begin anew.
  void start() { *this = {}; }
  /// One reading (N), `dt_s` after the one before; left out where it is not finite. It is steady while the
  /// means differ by at most `max_change_n`, as they do by what the load changes in 0.4 s.
  void update(double load_n, double dt_s, double max_change_n);
  /// For how long it has been steady (s).
  [[nodiscard]] double steady_s() const { return steady_s_; }

 private:
  bool begun_ = false;
  double fast_n_ = 0.0, slow_n_ = 0.0;
  double steady_s_ = 0.0;
};

}  // namespace colift::control
