#include "perception/target/outline.hpp"

#include <array>
#include <vector>

namespace colift::perception {
namespace {

// allowance per pixel of the skip: a surface seen at up to 70 degrees
constexpr float kSlantBase_m = 0.004f, kSlantGrowth = 0.001f;

enum class Beyond { Farther, Ground, Same, Nearer, Rim, Unknown, Own };

class Reader {
 public:
  Reader(const OrganisedCloud& cloud, const std::vector<std::int32_t>& label,
         const std::vector<std::uint8_t>& own, const Ground& ground, const ImageBorder& border,
         const DepthJump& jump, const OutlineConfig& c)
      : cloud_(cloud), label_(label), own_(own), ground_(ground), border_(border), jump_(jump), c_(c) {}

  // what lies beyond the object's pixel (u, v) in the direction (du, dv)
  [[nodiscard]] Beyond beyond(int u, int v, int du, int dv) const {
    const float depth = cloud_.depth_m[at(u, v)];
    for (int step = 1; step <= c_.reach_px; ++step) {
      const int x = u + step * du, y = v + step * dv;
      if (outside(x, y)) return Beyond::Rim;
      const std::size_t i = at(x, y);
      if (own(i)) return Beyond::Own;  // a notch or a hole, not the outline
      if (step < c_.skip_px || !cloud_.seen(i)) continue;
      if (ground_.plane.height(cloud_.point(i)) < c_.ground_height_m) return Beyond::Ground;
      if (jump_.same_surface(cloud_.depth_m[i], depth)) return Beyond::Same;
      return cloud_.depth_m[i] > depth ? Beyond::Farther : Beyond::Nearer;
    }
    return Beyond::Unknown;
  }

  [[nodiscard]] bool own(std::size_t pixel) const {
    return label_[pixel] != Components::kNone && own_[static_cast<std::size_t>(label_[pixel])] != 0;
  }

 private:
  [[nodiscard]] std::size_t at(int u, int v) const {
    return static_cast<std::size_t>(v) * static_cast<std::size_t>(cloud_.width()) +
           static_cast<std::size_t>(u);
  }
  [[nodiscard]] bool outside(int u, int v) const {
    if (u < 0 || v < 0 || u >= cloud_.width() || v >= cloud_.height()) return true;
    const auto i = static_cast<std::size_t>(u), k = static_cast<std::size_t>(v);
    return u < border_.left[k] || u > border_.right[k] || v < border_.top[i] || v > border_.bottom[i];
  }

  const OrganisedCloud& cloud_;
  const std::vector<std::int32_t>& label_;
  const std::vector<std::uint8_t>& own_;  // of each region
  const Ground& ground_;
  const ImageBorder& border_;
  const DepthJump& jump_;
  const OutlineConfig& c_;
};

}  // namespace

Outline read_outline(const OrganisedCloud& cloud, const Components& components,
                     const std::vector<std::int32_t>& label, const Fragment& object, const Ground& ground,
                     const ImageBorder& border, const DepthJump& jump, const OutlineConfig& config) {
  const std::vector<std::uint8_t> own = own_regions(object, components);

  // over a window of the skip's size the depth may change by that many jumps' growth: a slanted surface goes
  // on
  const auto steps = static_cast<float>(config.skip_px);
  const DepthJump wide{jump.base_m + steps * kSlantBase_m, jump.growth_per_m + steps * kSlantGrowth};
  const Reader reader(cloud, label, own, ground, border, wide, config);
  std::array<std::size_t, 7> count{};
  const auto add = [&](Beyond what) { ++count[static_cast<std::size_t>(what)]; };
  const auto w = static_cast<std::size_t>(cloud.width());
  for (const Components::Run& run : components.runs) {
    if (!own[static_cast<std::size_t>(run.label)]) continue;
    const int v = run.row;
    add(reader.beyond(run.first, v, -1, 0));
    add(reader.beyond(run.last, v, 1, 0));
    for (int u = run.first; u <= run.last; ++u) {
      const std::size_t i = static_cast<std::size_t>(v) * w + static_cast<std::size_t>(u);
      if (v == 0 || !reader.own(i - w)) add(reader.beyond(u, v, 0, -1));
      if (v + 1 == cloud.height() || !reader.own(i + w)) add(reader.beyond(u, v, 0, 1));
    }
  }
  const auto of = [&](Beyond what) { return static_cast<double>(count[static_cast<std::size_t>(what)]); };
  const double total = of(Beyond::Farther) + of(Beyond::Ground) + of(Beyond::Same) + of(Beyond::Nearer) +
                       of(Beyond::Rim) + of(Beyond::Unknown);
  if (total <= 0.0) return {};
  return {of(Beyond::Farther) / total, of(Beyond::Ground) / total, of(Beyond::Same) / total,
          of(Beyond::Nearer) / total,  of(Beyond::Rim) / total,    of(Beyond::Unknown) / total};
}

}  // namespace colift::perception
