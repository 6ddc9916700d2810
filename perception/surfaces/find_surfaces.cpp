#include "perception/surfaces/find_surfaces.hpp"

#include <algorithm>

#include "perception/surfaces/edge_faces.hpp"
#include "perception/surfaces/find_cylinders.hpp"
#include "perception/surfaces/object_image.hpp"
#include "perception/surfaces/plane_growing.hpp"
#include "perception/surfaces/rectangle_cover.hpp"

namespace colift::perception {
namespace {

std::vector<FaceRectangle> cover_faces(const OrganisedCloud& cloud, const ObjectImage& image,
                                       const std::vector<Face>& faces, const SurfaceConfig& config, bool wide_only) {
  std::vector<FaceRectangle> rectangles;
  const auto pixels = pixels_by_face(image, faces.size());
  for (std::size_t k = 0; k < faces.size(); ++k) {
    if (faces[k].moments.n < config.min_pixels) continue;
    if (wide_only && extent_of(faces[k], image.geometry).narrow_m <
                         std::max(1.2 * config.max_edge_m, widest_strip(image, faces[k].inverse_depth(), config)))
      continue;
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
  find_edge_faces(image, faces, cover_faces(cloud, image, faces, config, true), ground, config);
  for (const Cylinder& c : find_cylinders(image, faces, first_edge, ground, config)) surfaces.emplace_back(c);
  for (const FaceRectangle& r : cover_faces(cloud, image, faces, config, false)) surfaces.emplace_back(r.rectangle);
  std::stable_sort(surfaces.begin(), surfaces.end(), [](const Surface& a, const Surface& b) { return area(a) > area(b); });
  return surfaces;
}

}  // namespace colift::perception
