#include "perception/surfaces/strip_faces.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "perception/surfaces/object_parts.hpp"

namespace colift::perception {
namespace {

constexpr std::size_t kLeastPixels = 20;  // of a piece; a face has SurfaceConfig::min_pixels
constexpr double kMost = 0.8;             // of its pixels lie on its plane
constexpr double kOpenRim = 0.25;         // of its rim at most is where the object goes on
constexpr double kLength_m = 0.08;
constexpr int kGap_px = 4;         // between pieces that a hole in the depth has parted
constexpr double kAcross = 0.95;   // sine between a strip and the normal of a face that it is square to
constexpr double kNearly = 0.866;  // cosine: a strip that faces the camera may lean by this much

// Bars and handles are mostly square to what they are fixed to. With another lean the fingers would press on
// their edges.
Vec3 lean_of_object(const ObjectImage& image, const std::vector<Face>& faces, const Vec3& along,
                    const Vec3& facing) {
  Vec3 lean = facing;
  double most = 0.0;
  for (const Face& face : faces) {
    if (face.strip || face.bowed || !(face.moments.n > most)) continue;
    const Vec3 normal = image.geometry.to_W(face.plane).normal;
    const Vec3 across = normal - along * along.dot(normal);
    if (across.norm() < kAcross) continue;
    most = face.moments.n;
    lean = facing;
    const Vec3 square = across.normalized();
    for (const Vec3& side : {square, Vec3(along.cross(square))})
      if (const double cosine = side.dot(facing); std::abs(cosine) > kNearly)
        lean = cosine < 0.0 ? Vec3(-side) : side;
  }
  return lean;
}

// The plane along a strip's long side: how a few pixels across lean is not known. It is square to the
// object's largest face, or else faces the camera.
bool strip_plane(const ObjectImage& image, const std::vector<Face>& faces, const Part& part, Face& face,
                 double& length_m) {
  Vec3 mean = Vec3::Zero();
  Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
  for (const std::uint32_t k : part) {
    const Vec3 p = image.geometry.point_W(image.column(k), image.row(k), static_cast<double>(image.q[k]));
    const Vec3 d = p - image.geometry.eye();  // small numbers do for sums
    mean += d;
    squares += d * d.transpose();
  }
  const auto n = static_cast<double>(part.size());
  mean /= n;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> spread(squares / n - mean * mean.transpose());
  const Vec3 along = spread.eigenvectors().col(2);
  length_m = std::sqrt(12.0 * std::max(0.0, spread.eigenvalues()[2]));
  const Vec3 normal = -(mean - along * along.dot(mean));
  if (!(normal.norm() > 0.1 * mean.norm())) return false;  // seen from its end
  const Vec3 lean = lean_of_object(image, faces, along, normal.normalized());
  face.plane = image.geometry.from_W({lean, -lean.dot(mean + image.geometry.eye())});
  return true;
}

Part on_plane(const ObjectImage& image, const Part& part, const Face& face, double sigmas) {
  Part mine;
  std::copy_if(part.begin(), part.end(), std::back_inserter(mine), [&](std::uint32_t k) {
    const double q = static_cast<double>(image.q[k]);
    return std::abs(q - face.plane.at(image.column(k), image.row(k))) < image.tolerance(q, sigmas);
  });
  return mine;
}

// The face of most of a part's pixels, and these; empty where they are none.
Part strip_of(const ObjectImage& image, const std::vector<Face>& faces, const Part& part,
              const SurfaceConfig& config, Face& face) {
  Part mine = part;
  double length_m = 0.0;
  for (int round = 0; round < 2; ++round) {
    if (!strip_plane(image, faces, mine, face, length_m)) return {};
    mine = on_plane(image, part, face, config.tolerance_sigma);
    if (static_cast<double>(mine.size()) < kMost * static_cast<double>(part.size())) return {};
  }
  return length_m < kLength_m ? Part{} : mine;
}

Eigen::AlignedBox2i box_of(const ObjectImage& image, const Part& part) {
  Eigen::AlignedBox2i box;
  for (const std::uint32_t k : part) box.extend(Eigen::Vector2i(image.column(k), image.row(k)));
  return box;
}

bool near_by(const ObjectImage& image, const Part& a, const Part& b) {
  if (box_of(image, a).squaredExteriorDistance(box_of(image, b)) > 2 * kGap_px * kGap_px) return false;
  return std::any_of(a.begin(), a.end(), [&](std::uint32_t i) {
    return std::any_of(b.begin(), b.end(), [&](std::uint32_t k) {
      return std::abs(image.column(i) - image.column(k)) <= kGap_px &&
             std::abs(image.row(i) - image.row(k)) <= kGap_px;
    });
  });
}

// joins pieces of one strip
void join(const ObjectImage& image, const std::vector<Face>& faces, std::vector<Part>& parts,
          const SurfaceConfig& config) {
  for (std::size_t i = 0; i < parts.size(); ++i)
    for (std::size_t k = i + 1; k < parts.size();) {
      Part both;
      Face face;
      if (near_by(image, parts[i], parts[k])) {
        both = parts[i];
        both.insert(both.end(), parts[k].begin(), parts[k].end());
      }
      if (both.empty() || strip_of(image, faces, both, config, face).empty()) {
        ++k;
        continue;
      }
      parts[i] = std::move(both);
      parts.erase(parts.begin() + static_cast<std::ptrdiff_t>(k));
      k = i + 1;
    }
}

}  // namespace

void find_strip_faces(ObjectImage& image, std::vector<Face>& faces, const SurfaceConfig& config) {
  Part free;
  std::copy_if(image.pixels.begin(), image.pixels.end(), std::back_inserter(free),
               [&](std::uint32_t k) { return image.label[k] == ObjectImage::kFree; });
  if (free.size() < static_cast<std::size_t>(config.min_pixels)) return;
  ObjectParts all(image, config.cylinders);
  all.open(free);
  std::vector<Part> parts = all.connected(free, kLeastPixels);
  std::erase_if(parts, [&](const Part& part) { return all.open_rim(part) > kOpenRim; });
  join(image, faces, parts, config);
  for (const Part& part : parts) {
    Face face;
    face.strip = true;
    const Part mine = strip_of(image, faces, part, config, face);
    if (mine.size() < static_cast<std::size_t>(config.min_pixels)) continue;
    for (const std::uint32_t k : mine) {
      image.label[k] = static_cast<std::int16_t>(faces.size());
      face.moments.add(image.column(k), image.row(k), static_cast<double>(image.q[k]));
    }
    faces.push_back(face);
  }
}

}  // namespace colift::perception
