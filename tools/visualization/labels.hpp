#pragma once

#include <string>
#include <vector>

#include "tools/visualization/canvas.hpp"

namespace colift::picture {

/// Puts words beside the things they name without ever covering each other or leaving the area. Whoever comes
/// first has the better place; what finds none is left out.
class Labels {
 public:
  Labels(Canvas& canvas, const Box& area) : canvas_(canvas), area_(area) {}

  /// Keeps a place free of words.
  void keep_clear(const Box& box) { taken_.push_back(box); }

  /// Writes words near an anchor, at least `clearance` pixels off. With `must`, the anchor's surroundings are
  /// searched far and a thin line leads from the words to the anchor. Returns whether there was a place.
  bool place(const Px& anchor, const std::string& words, const TextStyle& style, double clearance,
             bool must = false);

 private:
  [[nodiscard]] bool free(const Box& box) const;

  Canvas& canvas_;
  Box area_;
  std::vector<Box> taken_;
};

/// A length as people read it: "7.5 cm", "62 cm", "1.74 m".
[[nodiscard]] std::string length_text(double length_m);

/// The same without the unit, in cm.
[[nodiscard]] std::string centimetres(double length_m);

/// A count with thin gaps between thousands: "307 200".
[[nodiscard]] std::string count_text(std::size_t count);

}  // namespace colift::picture
