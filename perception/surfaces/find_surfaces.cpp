#include "perception/surfaces/find_surfaces.hpp"

#include <algorithm>
#include <iterator>
#include <limits>

#include "perception/surfaces/edge_faces.hpp"
#include "perception/surfaces/find_cylinders.hpp"
#include "perception/surfaces/object_image.hpp"
#include "perception/surfaces/plane_growing.hpp"
#include "perception/surfaces/rectangle_cover.hpp"
#include "perception/surfaces/strip_faces.hpp"

namespace colift::perception {
namespace {

bool is_wide(const Face& face, const ObjectImage& image, const SurfaceConfig& config) {
  const double strip_m = widest_strip(image, face.inverse_depth(), config);
  return extent_of(face, image.geometry).narrow_m >= std::max(1.2 * config.max_edge_m, strip_m);
}

/// Covers the faces that are wide enough to have narrow ones beside them, or all. What is known from an
/// earlier round holds on for faces that kept their pixels.
std::vector<FaceRectangle> cover_faces(const OrganisedCloud& cloud, const ObjectImage& image,
                                       const std::vector<Face>& faces, const SurfaceConfig& config,
                                       bool wide_only, const std::vector<FaceRectangle>& known,
                                       const std::vector<double>& known_pixels) {
  std::vector<FaceRectangle> rectangles;
  const auto is_known = [&](std::size_t k) {
    return k < known_pixels.size() && known_pixels[k] == faces[k].moments.n;
  };
  std::vector<char> wanted(faces.size());
  for (std::size_t k = 0; k < faces.size(); ++k)
    wanted[k] = faces[k].moments.n >= config.min_pixels && !is_known(k) &&
                (!wide_only || is_wide(faces[k], image, config));
  const auto pixels = pixels_by_face(image, faces, wanted);
  for (std::size_t k = 0; k < faces.size(); ++k) {
    if (is_known(k)) {
      std::copy_if(known.begin(), known.end(), std::back_inserter(rectangles),
                   [&](const FaceRectangle& r) { return r.face == static_cast<int>(k); });
      continue;
    }
    if (!wanted[k]) continue;
    cover_face(cloud, image, faces[k], static_cast<int>(k), pixels[k], config, rectangles);
  }
  return rectangles;
}

double area(const Surface& s) {
  if (const auto* r = std::get_if<Rectangle>(&s)) return r->size.prod();
  const auto& c = std::get<Cylinder>(s);
  return 2.0 * c.radius * c.length;  // as the camera sees it
}

}  // namespace

std::vector<Surface> find_surfaces(const OrganisedCloud& cloud, const Target& target, const Ground& ground,
                                   const NoiseModel& noise, const SurfaceConfig& config) {
  ObjectImage image(cloud, target.pixels, noise, config.tolerance_m);
  std::vector<Surface> surfaces;
  std::vector<Face> faces;
  grow_faces(image, faces, config);
  const std::size_t first_edge = faces.size();
  const std::vector<FaceRectangle> wide = cover_faces(cloud, image, faces, config, true, {}, {});
  std::vector<double> covered;  // pixels of each wide face; NaN for the others, which equals nothing
  for (const Face& f : faces)
    covered.push_back(is_wide(f, image, config) ? f.moments.n : std::numeric_limits<double>::quiet_NaN());
  find_edge_faces(image, faces, wide, ground, config);
  for (const Cylinder& c : find_cylinders(image, faces, first_edge, ground, config)) surfaces.emplace_back(c);
  find_strip_faces(image, faces, config);
  for (const FaceRectangle& r : cover_faces(cloud, image, faces, config, false, wide, covered))
    surfaces.emplace_back(r.rectangle);
  std::stable_sort(surfaces.begin(), surfaces.end(),
                   [](const Surface& a, const Surface& b) { return area(a) > area(b); });
  return surfaces;
}

}  // namespace colift::perception
