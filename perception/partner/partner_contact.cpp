#include "perception/partner/partner_contact.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

namespace colift::perception {
namespace {

// The configuration in single precision, as all points are.
struct Figures {
  explicit Figures(const ContactConfig& c)
      : hand_breadth_m(static_cast<float>(c.hand_breadth_m)),
        finger_radius_m(static_cast<float>(c.finger_radius_m)),
        half_palm_m(static_cast<float>(c.half_palm_m)),
        palm_thickness_m(static_cast<float>(c.palm_thickness_m)),
        half_board_m(static_cast<float>(c.half_board_m)),
        max_board_m(static_cast<float>(c.max_board_m)),
        neighbourhood_m(static_cast<float>(c.neighbourhood_m)),
        end_margin_m(static_cast<float>(c.end_margin_m)),
        clear_advantage_m(static_cast<float>(c.clear_advantage_m)),
        around_bar_sigma_rad(c.around_bar_sigma_rad),
        frontal_angle_rad(static_cast<float>(c.frontal_angle_rad)),
        max_finger_height_m(static_cast<float>(c.max_finger_height_m)),
        face_tolerance_m(static_cast<float>(c.face_tolerance_m)),
        max_finger_offset_m(static_cast<float>(c.max_finger_offset_m)),
        max_edge_sine(static_cast<float>(c.max_edge_sine)),
        min_finger_fraction(static_cast<float>(c.min_finger_fraction)),
        inside_tolerance_m(static_cast<float>(c.inside_tolerance_m)),
        misplaced_cost_m(static_cast<float>(c.misplaced_cost_m)),
        max_end_distance_m(static_cast<float>(c.max_end_distance_m)),
        end_width_m(static_cast<float>(c.end_width_m)) {}

  float hand_breadth_m, finger_radius_m, half_palm_m, palm_thickness_m, half_board_m, max_board_m,
      neighbourhood_m, end_margin_m, clear_advantage_m;
  double around_bar_sigma_rad;
  float frontal_angle_rad, max_finger_height_m, face_tolerance_m, max_finger_offset_m, max_edge_sine,
      min_finger_fraction, inside_tolerance_m, misplaced_cost_m, max_end_distance_m, end_width_m;
};

struct Along {
  float middle = 0.0F, extent = 0.0F;
  float end_on = 0.0F;  ///< 0: seen from the side; 1: one end of the hand hides the other.
};

// Where along a line the hand is: the window of a hand's breadth that holds most of it. Thumb and wrist stick
// out of it. When less than a breadth is seen, the window can be pushed to and fro: its middle place, or,
// when the line runs away from the camera, the farther one, as the near end of the hand hides the far one.
Along place_along(std::span<const HandPoint> hand, const EdgeLine& line, const Eigen::Vector3f& eye,
                  float near_m, float far_m, const Figures& fig) {
  constexpr int kBins = 240;  // 48 cm: the neighbourhood on both sides, and a hand that sticks out of it
  constexpr float kBin_m = 0.002F;
  std::array<float, kBins> bins{};
  const Eigen::Vector3f d = line.direction;
  const Eigen::Vector3f at = hand.front().on_object;
  const float origin = d.dot(at - line.point) - 0.5F * kBins * kBin_m;
  float total = 0.0F;
  for (const HandPoint& h : hand) {
    const Eigen::Vector3f p = h.point + fig.finger_radius_m * (h.point - eye).normalized() - line.point;
    const float t = d.dot(p);
    const float off = (p - t * d).norm();
    const float high = (h.point - h.on_object).norm();
    const float weight = h.area_m2 * std::clamp((far_m - off) / (far_m - near_m), 0.0F, 1.0F) *
                         std::clamp((0.045F - high) / 0.015F, 0.1F, 1.0F);
    const int bin = static_cast<int>((t - origin) / kBin_m);
    if (bin < 0 || bin >= kBins) continue;
    bins[static_cast<std::size_t>(bin)] += weight;
    total += weight;
  }
  Along along;
  if (total <= 0.0F) {
    along.middle = d.dot(at - line.point);
    return along;
  }
  // the side that faces the camera has more pixels, but not more hand: what a bin counts is bounded
  const float cap = 1.5F * total / (fig.hand_breadth_m / kBin_m);
  std::array<float, kBins + 1> sum{};
  for (std::size_t i = 0; i < kBins; ++i) sum[i + 1] = sum[i] + std::min(bins[i], cap);
  const int window = static_cast<int>(fig.hand_breadth_m / kBin_m + 0.25F);
  float best = 0.0F;
  for (int i = 0; i + window <= kBins; ++i)
    best = std::max(best, sum[static_cast<std::size_t>(i + window)] - sum[static_cast<std::size_t>(i)]);
  int first = -1, last = -1;
  for (int i = 0; i + window <= kBins; ++i) {
    const float in = sum[static_cast<std::size_t>(i + window)] - sum[static_cast<std::size_t>(i)];
    if (in < 0.97F * best) continue;
    if (first < 0) first = i;
    last = i;
  }
  const float slack = static_cast<float>(last - first) * kBin_m;
  along.extent = std::max(0.0F, fig.hand_breadth_m - slack);
  const Eigen::Vector3f sight = (at - eye).normalized();
  const float away = d.dot(sight);
  along.end_on = std::clamp((std::abs(away) - 0.3F) / 0.5F, 0.0F, 1.0F);
  along.middle =
      origin + (0.5F * static_cast<float>(first + last) + 0.5F * static_cast<float>(window)) * kBin_m;
  along.middle += 0.5F * slack * along.end_on * (away > 0.0F ? 1.0F : -1.0F);
  return along;
}

// How tightly a hand encloses a line: mean distance of its points, bounded, in m.
float tightness(std::span<const HandPoint> hand, const EdgeLine& line) {
  constexpr float kFar_m = 0.10F;  // bounds what a single stray point adds
  float sum = 0.0F, area = 0.0F;
  for (const HandPoint& h : hand) {
    const Eigen::Vector3f p = h.point - line.point;
    const float off = std::sqrt(std::max(0.0F, p.squaredNorm() - std::pow(line.direction.dot(p), 2.0F)));
    sum += h.area_m2 * std::min(off, kFar_m);
    area += h.area_m2;
  }
  return sum / area;
}

// Whether skin lies right above a face, not beside its end.
bool lies_on(const HandPoint& h, const LocalFace& face, const Figures& fig) {
  const Eigen::Vector3f off = h.point - h.on_object;
  const float high = face.normal.dot(off);
  return high > 0.0F && high < fig.max_finger_height_m &&
         std::abs(face.normal.dot(h.on_object - face.point)) < fig.face_tolerance_m &&
         (off - high * face.normal).norm() < fig.max_finger_offset_m;
}

// Whether a line is an edge of a face.
bool borders(const EdgeLine& line, const LocalFace& face, const Figures& fig) {
  return std::abs(face.normal.dot(line.direction)) < fig.max_edge_sine &&
         std::abs(face.normal.dot(line.point - face.point)) < fig.max_board_m;
}

// The face that most of the fingers lie on, if there is one.
const LocalFace* finger_face(std::span<const HandPoint> hand, const std::vector<LocalFace>& faces,
                             const Figures& fig) {
  const LocalFace* best = nullptr;
  float area = 0.0F, most = 0.0F;
  for (const HandPoint& h : hand) area += h.area_m2;
  for (const LocalFace& f : faces) {
    float on = 0.0F;
    for (const HandPoint& h : hand) on += lies_on(h, f, fig) ? h.area_m2 : 0.0F;
    if (on <= std::max(most, fig.min_finger_fraction * area)) continue;
    most = on;
    best = &f;
  }
  return best;
}

// Part of a hand that speaks against a line: what lies on a face that the line does not end; and, of a line
// that ends the face with the fingers, what is neither on a face nor beyond it.
float misplaced(std::span<const HandPoint> hand, const EdgeLine& line, const std::vector<LocalFace>& faces,
                const LocalFace* fingers, const Figures& fig) {
  Eigen::Vector3f out = Eigen::Vector3f::Zero();
  if (fingers != nullptr && borders(line, *fingers, fig)) {
    out = fingers->normal.cross(line.direction).normalized();
    if (out.dot(fingers->point - line.point) > 0.0F) out = -out;
  }
  float wrong = 0.0F, area = 0.0F;
  for (const HandPoint& h : hand) {
    area += h.area_m2;
    const auto on =
        std::find_if(faces.begin(), faces.end(), [&](const LocalFace& f) { return lies_on(h, f, fig); });
    if (on != faces.end())
      wrong += borders(line, *on, fig) ? 0.0F : h.area_m2;
    else if (out.dot(h.point - line.point) < -fig.inside_tolerance_m)
      wrong += 0.5F * h.area_m2;  // it may be a finger that is bent or the wrist, so it counts half
  }
  return wrong / area;
}

// Ends of a face beside the hand that are seen too flat to show in the outline: across each edge of the face,
// where the face's points end.
std::vector<EdgeLine> flat_ends(const LocalShape& shape, const LocalFace& face, const GraspedObject& object,
                                const Eigen::Vector3f& place, const Figures& fig) {
  std::vector<EdgeLine> ends;
  for (const EdgeLine& line : shape.edges()) {
    if (!borders(line, face, fig)) continue;
    const Eigen::Vector3f across = face.normal.cross(line.direction).normalized();
    const float at = line.direction.dot(place - line.point);
    float begin = at, end = at;
    for (const Eigen::Vector3f& p : object.surface) {
      if (std::abs(face.normal.dot(p - face.point)) > fig.face_tolerance_m ||
          (p - place).norm() > fig.neighbourhood_m)
        continue;
      const float t = line.direction.dot(p - line.point);
      begin = std::min(begin, t);
      end = std::max(end, t);
    }
    for (const float t : {begin, end}) {
      // what ends farther away may continue outside of the neighbourhood
      if (std::abs(t - at) > fig.max_end_distance_m) continue;
      EdgeLine found{line.point + t * line.direction, across, 0.0F, 0.0F, false};
      for (const Eigen::Vector3f& p : object.surface) {
        if (std::abs(face.normal.dot(p - face.point)) > fig.face_tolerance_m) continue;
        if (std::abs(line.direction.dot(p - found.point)) > fig.end_width_m) continue;
        const float s = across.dot(p - found.point);
        if (std::abs(s) > fig.neighbourhood_m) continue;
        found.begin = std::min(found.begin, s);
        found.end = std::max(found.end, s);
      }
      const auto known = [&](const EdgeLine& other) {
        return borders(other, face, fig) && std::abs(other.direction.dot(across)) > 0.9F &&
               std::abs(line.direction.dot(other.point - found.point)) < fig.end_width_m;
      };
      if (std::none_of(shape.edges().begin(), shape.edges().end(), known) &&
          std::none_of(ends.begin(), ends.end(), known))
        ends.push_back(found);
    }
  }
  return ends;
}

Eigen::Matrix3d spread(const Eigen::Vector3f& direction, double along_m, double across_m) {
  const Vec3 d = direction.cast<double>();
  return across_m * across_m * Eigen::Matrix3d::Identity() +
         (along_m * along_m - across_m * across_m) * d * d.transpose();
}

ContactEstimate on_bar(std::span<const HandPoint> hand, const RoundBar& bar, const Eigen::Vector3f& eye,
                       const ContactNoise& noise, const Figures& fig) {
  const EdgeLine axis{bar.point, bar.direction, -1.0F, 1.0F};
  const Along along = place_along(hand, axis, eye, bar.radius + 0.03F, bar.radius + 0.05F, fig);
  // The palm is what stands off farthest; fingers and thumb lie on both sides of it. Angles about the bar are
  // counted from the camera's side.
  const Eigen::Vector3f middle = bar.point + along.middle * bar.direction;
  Eigen::Vector3f front = eye - middle;
  front = (front - bar.direction.dot(front) * bar.direction).normalized();
  const Eigen::Vector3f side = bar.direction.cross(front);
  constexpr int kBins = 72;
  std::array<float, kBins> bins{};
  float total = 0.0F;
  constexpr float kPi = std::numbers::pi_v<float>;
  for (const HandPoint& h : hand) {
    const Eigen::Vector3f p = h.point - bar.point;
    const float t = bar.direction.dot(p);
    if (std::abs(t - along.middle) > 0.5F * fig.hand_breadth_m) continue;
    const float x = front.dot(p), y = side.dot(p), high = std::hypot(x, y) - bar.radius;
    if (high < 0.0F || high > 0.042F) continue;
    const float weight = h.area_m2 * std::clamp((high - 0.016F) / 0.010F, 0.005F, 1.0F);
    const int bin =
        std::clamp(static_cast<int>((std::atan2(y, x) + kPi) / (2.0F * kPi) * kBins), 0, kBins - 1);
    bins[static_cast<std::size_t>(bin)] += weight;
    total += weight;
  }
  float angle = 0.0F, hidden = 0.0F;
  if (total > 0.0F) {
    float sum = 0.0F, mean = 0.0F, low = 0.0F, high = 0.0F;
    bool begun = false;
    for (std::size_t i = 0; i < kBins; ++i) {
      const float at = (static_cast<float>(i) + 0.5F) * 2.0F * kPi / kBins - kPi;
      sum += bins[i];
      mean += bins[i] * at / total;
      // the middle half: fingers reach around farther than the palm
      if (!begun && sum >= 0.25F * total) low = at, begun = true;
      if (sum <= 0.75F * total) high = at;
    }
    // a palm on the far side shows only its near end
    const float palm = 2.0F * std::atan(fig.half_palm_m / (bar.radius + fig.palm_thickness_m));
    const float aside =
        std::clamp((std::abs(mean) - fig.frontal_angle_rad) / fig.frontal_angle_rad, 0.0F, 1.0F);
    hidden = aside * std::max(0.0F, palm - std::max(0.0F, high - low));
    angle = mean + (mean > 0.0F ? 0.5F : -0.5F) * hidden;
  }
  const Eigen::Vector3f palm = std::cos(angle) * front + std::sin(angle) * side;
  ContactEstimate e;
  e.part = HeldPart::Bar;
  e.position = (middle + bar.radius * palm.normalized()).cast<double>();
  // how far around the bar the palm lies is less certain than where along it
  const double around = (fig.around_bar_sigma_rad + 0.5 * static_cast<double>(hidden)) * bar.radius;
  e.covariance = spread(bar.direction, std::hypot(noise.along_m, noise.depth_m),
                        std::hypot(noise.cross_m, noise.depth_m, around));
  return e;
}

// Whether nothing but legs is behind a face: the object's visible length at a few cm behind it is short
// against the face's size.
bool is_board(const LocalFace& face, std::span<const Eigen::Vector3f> surface) {
  int on = 0, behind = 0;
  for (const Eigen::Vector3f& p : surface) {
    const float deep = face.normal.dot(face.point - p);
    on += std::abs(deep) < 0.012F ? 1 : 0;
    behind += deep > 0.045F && deep < 0.090F ? 1 : 0;
  }
  // three rows of points lie in that band
  return static_cast<float>(behind) / 3.0F < 0.8F * std::sqrt(static_cast<float>(on));
}

}  // namespace

ContactEstimate estimate_contact(std::span<const HandPoint> hand, const GraspedObject& object,
                                 const ContactNoise& noise, const ContactConfig& config) {
  const Figures fig(config);
  Eigen::Vector3f on_object = Eigen::Vector3f::Zero();
  float area = 0.0F;
  for (const HandPoint& h : hand) {
    on_object += h.area_m2 * h.on_object;
    area += h.area_m2;
  }
  on_object /= area;

  LocalShape shape(object.surface, object.outline, object.eye, on_object, fig.neighbourhood_m, config.shape);
  if (const auto& bar = shape.round_bar()) return on_bar(hand, *bar, object.eye, noise, fig);

  ContactEstimate e;
  const EdgeLine* best = nullptr;
  Along along;
  float tightest = 0.12F, second = 0.12F, displaced = 0.0F;
  const LocalFace* face = finger_face(hand, shape.faces(), fig);
  std::vector<EdgeLine> lines = shape.edges();
  if (face != nullptr)
    for (const EdgeLine& end : flat_ends(shape, *face, object, on_object, fig)) lines.push_back(end);
  for (const EdgeLine& line : lines) {
    const float wrong = misplaced(hand, line, shape.faces(), face, fig);
    Along here = place_along(hand, line, object.eye, 0.03F, 0.07F, fig);
    const float wanted = here.middle;
    // half a hand does not fit beside the end of an edge
    if (line.end - line.begin > 2.0F * fig.end_margin_m)
      here.middle = std::clamp(here.middle, line.begin + fig.end_margin_m, line.end - fig.end_margin_m);
    else
      here.middle = 0.5F * (line.begin + line.end);
    const float tight =
        tightness(hand, line) + 0.7F * std::abs(wanted - here.middle) + fig.misplaced_cost_m * wrong;
    if (tight >= tightest) {
      second = std::min(second, tight);
      continue;
    }
    second = tightest;
    tightest = tight;
    displaced = std::abs(wanted - here.middle);
    best = &line;
    along = here;
  }
  if (best == nullptr) {
    e.position = on_object.cast<double>();
    e.covariance = spread(Eigen::Vector3f::UnitX(), 0.03, 0.03);
    return e;
  }
  e.part = best->corner ? HeldPart::Corner : HeldPart::Rim;
  Eigen::Vector3f place = best->point + along.middle * best->direction;
  if (!best->corner) {
    const LocalFace* ending = nullptr;
    for (const LocalFace& f : shape.faces())
      if (std::abs(f.normal.dot(place - f.point)) < fig.max_board_m && (!ending || f.points > ending->points))
        ending = &f;
    if (ending != nullptr) {
      const float below = ending->normal.dot(ending->point - place);
      if (below > 0.006F) {
        // the camera sees the board's side, and the outline is its lower edge
        place += 0.5F * below * ending->normal;
        e.part = HeldPart::Plate;
      } else if (is_board(*ending, object.surface)) {
        place -= (fig.half_board_m - std::max(0.0F, below)) * ending->normal;
        e.part = HeldPart::Plate;
      }
    }
  }
  e.position = place.cast<double>();
  // a hand that fits nearly as well elsewhere, or that reaches past the end of its edge, may be misread
  const double doubt = std::max(0.0F, fig.clear_advantage_m - (second - tightest)) + 0.5F * displaced;
  const double hidden = 0.15 * (fig.hand_breadth_m - along.extent);
  e.covariance = spread(best->direction, std::hypot(noise.along_m, noise.depth_m, std::hypot(doubt, hidden)),
                        std::hypot(noise.cross_m, noise.depth_m, doubt));
  return e;
}

}  // namespace colift::perception
