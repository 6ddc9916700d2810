#include "planner/motion/shortcut.hpp"

#include <utility>

#include "planner/motion/joint_random.hpp"

namespace colift::planner {
namespace {

using hal::JointVector;

/// A point on a path: on the edge from way point `edge` to the next one.
struct OnPath {
  std::size_t edge;
  JointVector q;
};

OnPath at_length(const JointPath& path, double length) {
  for (std::size_t i = 0; i + 1 < path.size(); ++i) {
    const double edge = (path[i + 1] - path[i]).norm();
    if (length <= edge || i + 2 == path.size()) {
      const double part = edge > 0.0 ? std::min(1.0, length / edge) : 0.0;
      return {i, path[i] + part * (path[i + 1] - path[i])};
    }
    length -= edge;
  }
  return {0, path.front()};
}

/// From each way point straight to the farthest one that can be reached, looking from the far end.
JointPath skip_waypoints(const JointPath& path, const FreeSpace& space) {
  JointPath out{path.front()};
  for (std::size_t at = 0; at + 1 < path.size();) {
    std::size_t next = path.size() - 1;
    while (next > at + 1 && !space.edge(path[at], path[next])) --next;
    out.push_back(path[next]);
    at = next;
  }
  return out;
}

void random_shortcuts(JointPath& path, const FreeSpace& space, JointRandom& random,
                      const ShortcutConfig& config) {
  double length = length_of(path);
  for (int round = 0, failures = 0; round < config.rounds && failures < config.give_up_after; ++round) {
    if (path.size() < 3) return;
    double from = length * random.unit(), to = length * random.unit();
    if (from > to) std::swap(from, to);
    const OnPath a = at_length(path, from), b = at_length(path, to);
    const double gain = (to - from) - (b.q - a.q).norm();
    if (a.edge == b.edge || gain < config.min_gain * length || !space.edge(a.q, b.q)) {
      ++failures;
      continue;
    }
    failures = 0;
    path.erase(path.begin() + static_cast<std::ptrdiff_t>(a.edge) + 1,
               path.begin() + static_cast<std::ptrdiff_t>(b.edge) + 1);
    path.insert(path.begin() + static_cast<std::ptrdiff_t>(a.edge) + 1, {a.q, b.q});
    length -= gain;
  }
}

/// Cuts every corner by a line between points on its two edges, as near to their far ends as is free.
void cut_corners(JointPath& path, const FreeSpace& space, const ShortcutConfig& config) {
  const double worth = config.min_gain * length_of(path);
  for (std::size_t i = 1; i + 1 < path.size(); ++i) {
    for (const double part : {1.0, 0.6, 0.3}) {
      const JointVector a = path[i] + part * (path[i - 1] - path[i]);
      const JointVector b = path[i] + part * (path[i + 1] - path[i]);
      const double gain = (path[i] - a).norm() + (b - path[i]).norm() - (b - a).norm();
      if (gain < worth) break;
      if (!space.edge(a, b)) continue;
      const auto corner = path.begin() + static_cast<std::ptrdiff_t>(i);
      if (part == 1.0) {
        path.erase(corner);
        --i;
      } else {
        *corner = a;
        path.insert(corner + 1, b);
        ++i;
      }
      break;
    }
  }
}

/// Moves every corner towards the line between its neighbours: all joints at once, then those joints alone
/// that can go (a narrow place holds some joints, the others carry what is left of the random search).
void pull_corners(JointPath& path, const FreeSpace& space, const ShortcutConfig& config) {
  const double worth = config.min_gain * length_of(path);
  for (std::size_t i = 1; i + 1 < path.size(); ++i) {
    const JointVector &before = path[i - 1], &after = path[i + 1];
    const auto both = [&](const JointVector& q) { return (q - before).norm() + (after - q).norm(); };
    const auto move_to = [&](const JointVector& q) {
      if (both(path[i]) - both(q) < worth || !space.edge(before, q) || !space.edge(q, after)) return false;
      path[i] = q;
      return true;
    };
    const double to_first = (path[i] - before).norm(), to_second = (after - path[i]).norm();
    if (to_first + to_second <= 0.0) continue;
    const JointVector foot = before + to_first / (to_first + to_second) * (after - before);
    if (move_to(0.5 * (path[i] + foot))) continue;
    for (int joint = 0; joint < hal::kArmJoints; ++joint) {
      JointVector q = path[i];
      q[joint] = foot[joint];
      if (move_to(q)) continue;
      q[joint] = 0.5 * (path[i][joint] + foot[joint]);
      move_to(q);
    }
  }
}

/// Way points that lie on top of each other say nothing.
void drop_doubles(JointPath& path) {
  for (std::size_t i = 1; i + 1 < path.size();) {
    if (joint_distance(path[i - 1], path[i]) < 1e-6 || joint_distance(path[i], path[i + 1]) < 1e-6) {
      path.erase(path.begin() + static_cast<std::ptrdiff_t>(i));
    } else {
      ++i;
    }
  }
}

}  // namespace

JointPath shortcut(JointPath path, const FreeSpace& space, std::uint64_t seed, const ShortcutConfig& config) {
  if (path.size() < 3) return path;
  JointRandom random(seed);
  path = skip_waypoints(path, space);
  random_shortcuts(path, space, random, config);
  double length = length_of(path);
  for (int pass = 0; pass < config.passes && path.size() > 2; ++pass) {
    pull_corners(path, space, config);
    cut_corners(path, space, config);
    drop_doubles(path);
    const double now = length_of(path);
    if (now > (1.0 - config.min_gain) * length) break;
    length = now;
  }
  return path;
}

}  // namespace colift::planner
