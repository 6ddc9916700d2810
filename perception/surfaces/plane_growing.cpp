#include "perception/surfaces/plane_growing.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace colift::perception {
namespace {

constexpr int kCell = ObjectImage::kCell;

struct Window {
  int cells;           // side of the seed window
  double seen;         // least part of the window that has free pixels
  std::size_t region;  // least number of cells that a grown region keeps
};
// from large faces to the narrowest that a grid of cells can show
constexpr std::array<Window, 3> kWindows{{{3, 0.75, 8}, {2, 0.6, 4}, {1, 0.75, 2}}};

class Grower {
 public:
  Grower(ObjectImage& image, std::vector<Face>& faces, const SurfaceConfig& config)
      : image_(image),
        faces_(faces),
        config_(config),
        columns_(image.width / kCell),
        rows_(image.height / kCell),
        cells_(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_)),
        owner_(cells_.size(), -1) {}

  void run() {
    for (const Window& window : kWindows) {
      sum_free_pixels();
      std::fill(owner_.begin(), owner_.end(), -1);
      const std::size_t before = faces_.size();
      for (const Seed& seed : seeds_of(window)) grow(seed, window);
      claim_pixels(before);
    }
    refit_faces(image_, faces_);
  }

 private:
  struct Seed {
    double misfit;
    int cell;
  };

  [[nodiscard]] std::size_t at(int c, int r) const {
    return static_cast<std::size_t>(r) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(c);
  }
  [[nodiscard]] double variance(double inverse_depth) const {
    const double s = image_.sigma(inverse_depth);
    return s * s;
  }

  // column sums first, so that the inner loop runs down lanes; then the columns are joined
  void sum_free_pixels() {
    for (int r = 0; r < rows_; ++r)
      for (int c = 0; c < columns_; ++c) {
        // pixels that were taken stay taken
        if (summed_ && cells_[at(c, r)].n == 0) continue;
        float n[kCell] = {}, v[kCell] = {}, vv[kCell] = {}, q[kCell] = {}, vq[kCell] = {}, qq[kCell] = {};
        const float q0 = reference(c, r);
        InverseMoments m;
        if (q0 > 0) {
          for (int j = 0; j < kCell; ++j) {
            const std::size_t first = image_.at(c * kCell, r * kCell + j);
            const float V = static_cast<float>(j);
            for (int i = 0; i < kCell; ++i) {
              const std::size_t k = first + static_cast<std::size_t>(i);
              const float w = image_.label[k] == ObjectImage::kFree ? 1.0f : 0.0f;
              const float d = w * (image_.q[k] - q0);
              n[i] += w, v[i] += w * V, vv[i] += w * V * V, q[i] += d, vq[i] += d * V, qq[i] += d * d;
            }
          }
          for (int i = 0; i < kCell; ++i) {
            m.n += n[i], m.u += i * n[i], m.v += v[i], m.q += q[i];
            m.uu += i * i * n[i], m.uv += i * v[i], m.vv += vv[i];
            m.uq += i * q[i], m.vq += vq[i], m.qq += qq[i];
          }
          shift(m, c * kCell, r * kCell, q0);
        }
        cells_[at(c, r)] = m;
      }
    summed_ = true;
  }

  // inverse depth of some free pixel of the cell, so that single precision sums small numbers
  [[nodiscard]] float reference(int c, int r) const {
    for (int j = 0; j < kCell; ++j)
      for (int i = 0; i < kCell; ++i) {
        const std::size_t k = image_.at(c * kCell + i, r * kCell + j);
        if (image_.label[k] == ObjectImage::kFree) return image_.q[k];
      }
    return 0.0f;
  }

  static void shift(InverseMoments& m, double U, double V, double Q) {
    m.qq += Q * (2 * m.q + m.n * Q);
    m.uq += Q * m.u + U * (m.q + m.n * Q);
    m.vq += Q * m.v + V * (m.q + m.n * Q);
    m.q += m.n * Q;
    m.uu += U * (2 * m.u + m.n * U);
    m.vv += V * (2 * m.v + m.n * V);
    m.uv += U * m.v + V * m.u + m.n * U * V;
    m.u += m.n * U;
    m.v += m.n * V;
  }

  [[nodiscard]] std::vector<Seed> seeds_of(const Window& window) const {
    std::vector<Seed> seeds;
    const double full = window.cells * window.cells * kCell * kCell;
    for (int r = 0; r + window.cells <= rows_; ++r)
      for (int c = 0; c + window.cells <= columns_; ++c) {
        const InverseMoments m = sum(c, r, window.cells);
        InversePlane plane;
        if (m.n < window.seen * full || !m.fit(plane)) continue;
        const double misfit = m.squares(plane) / (m.n * variance(m.q / m.n));
        if (misfit < config_.growing.max_seed_misfit) seeds.push_back({misfit, static_cast<int>(at(c, r))});
      }
    std::stable_sort(seeds.begin(), seeds.end(),
                     [](const Seed& a, const Seed& b) { return a.misfit < b.misfit; });
    return seeds;
  }

  [[nodiscard]] InverseMoments sum(int c, int r, int side) const {
    InverseMoments m;
    for (int j = 0; j < side; ++j)
      for (int i = 0; i < side; ++i) m += cells_[at(c + i, r + j)];
    return m;
  }

  void grow(const Seed& seed, const Window& window) {
    const int c0 = seed.cell % columns_, r0 = seed.cell / columns_;
    members_.clear();
    Face face;
    for (int j = 0; j < window.cells; ++j)
      for (int i = 0; i < window.cells; ++i) {
        const std::size_t k = at(c0 + i, r0 + j);
        if (owner_[k] >= 0) return;
      }
    const int index = static_cast<int>(faces_.size());
    for (int j = 0; j < window.cells; ++j)
      for (int i = 0; i < window.cells; ++i) take(at(c0 + i, r0 + j), index, face);
    if (!face.moments.fit(face.plane)) return give_back();

    double fitted = face.moments.n;
    for (int round = 0; round < 3; ++round) {
      const std::size_t before = members_.size();
      for (std::size_t next = 0; next < members_.size(); ++next) {
        const int c = static_cast<int>(members_[next]) % columns_,
                  r = static_cast<int>(members_[next]) / columns_;
        if (c > 0) join(at(c - 1, r), index, face);
        if (c + 1 < columns_) join(at(c + 1, r), index, face);
        if (r > 0) join(at(c, r - 1), index, face);
        if (r + 1 < rows_) join(at(c, r + 1), index, face);
        // early planes lean; they are straightened as they grow
        if (face.moments.n > 1.2 * fitted) {
          face.moments.fit(face.plane);
          fitted = face.moments.n;
        }
      }
      face.moments.fit(face.plane);
      fitted = face.moments.n;
      if (members_.size() == before) break;
    }
    if (members_.size() < window.region || face.moments.n < config_.min_pixels) return give_back();
    faces_.push_back(face);
  }

  void take(std::size_t cell, int index, Face& face) {
    owner_[cell] = index;
    members_.push_back(cell);
    face.moments += cells_[cell];
  }

  void give_back() {
    for (const std::size_t k : members_) owner_[k] = -1;
  }

  void join(std::size_t cell, int index, Face& face) {
    const InverseMoments& m = cells_[cell];
    if (owner_[cell] >= 0 || m.n < config_.growing.min_cell_pixels) return;
    const double s2 = variance(m.q / m.n);
    const double offset = m.mean_residual(face.plane);
    if (offset * offset > config_.growing.max_cell_offset * config_.growing.max_cell_offset * s2) return;
    if (m.squares(face.plane) > config_.growing.max_cell_misfit * m.n * s2) return;
    take(cell, index, face);
  }

  // every free pixel in or beside a region goes to the plane that it lies nearest to
  void claim_pixels(std::size_t first_face) {
    if (faces_.size() == first_face) return;
    merge_alike(first_face);
    uneven_.clear();
    for (const Face& f : faces_)
      uneven_.push_back(static_cast<float>(image_.tolerance_m / slant_of(f, image_.geometry)));
    for (int r = 0; r < rows_; ++r)
      for (int c = 0; c < columns_; ++c) {
        if (cells_[at(c, r)].n == 0) continue;
        int near[9];
        const int count = faces_around(c, r, near);
        if (count > 0) claim_cell(c, r, near, count);
      }
  }

  int faces_around(int c, int r, int (&near)[9]) const {
    int count = 0;
    for (int j = std::max(r - 1, 0); j <= std::min(r + 1, rows_ - 1); ++j)
      for (int i = std::max(c - 1, 0); i <= std::min(c + 1, columns_ - 1); ++i) {
        const int o = owner_[at(i, j)];
        if (o >= 0 && std::find(near, near + count, o) == near + count) near[count++] = o;
      }
    std::sort(near, near + count);
    return count;
  }

  void claim_cell(int c, int r, const int* near, int count) {
    const float k2 = static_cast<float>(config_.tolerance_sigma * image_.noise.sigma2_per_m);
    const float k0 = static_cast<float>(config_.tolerance_sigma * image_.noise.sigma0_m);
    float uneven[9], a[9], b[9], at0[9];
    for (int f = 0; f < count; ++f) {
      const InversePlane& p = faces_[static_cast<std::size_t>(near[f])].plane;
      uneven[f] = uneven_[static_cast<std::size_t>(near[f])];
      a[f] = static_cast<float>(p.a), b[f] = static_cast<float>(p.b);
      at0[f] = static_cast<float>(p.at(c * kCell, r * kCell));
    }
    for (int j = 0; j < kCell; ++j)
      for (int i = 0; i < kCell; ++i) {
        const std::size_t k = image_.at(c * kCell + i, r * kCell + j);
        if (image_.label[k] != ObjectImage::kFree) continue;
        const float q = image_.q[k];
        const float noise = k2 + k0 * q * q;
        float best = std::numeric_limits<float>::max();
        for (int f = 0; f < count; ++f) {
          const float d =
              std::abs(q - (at0[f] + a[f] * static_cast<float>(i) + b[f] * static_cast<float>(j)));
          if (d < noise + uneven[f] * q * q && d < best)
            best = d, image_.label[k] = static_cast<std::int16_t>(near[f]);
        }
      }
  }

  // a plane that was grown in two pieces
  void merge_alike(std::size_t first_face) {
    std::vector<int> renamed(faces_.size());
    for (std::size_t i = 0; i < renamed.size(); ++i) renamed[i] = static_cast<int>(i);
    for (std::size_t a = 0; a < faces_.size(); ++a)
      for (std::size_t b = std::max(a + 1, first_face); b < faces_.size(); ++b) {
        if (renamed[b] != static_cast<int>(b) || renamed[a] != static_cast<int>(a)) continue;
        InverseMoments both = faces_[a].moments;
        both += faces_[b].moments;
        InversePlane plane;
        if (!both.fit(plane)) continue;
        const double s2 = variance(both.q / both.n);
        const double apart =
            faces_[a].moments.squares(faces_[a].plane) + faces_[b].moments.squares(faces_[b].plane);
        const double worse = both.squares(plane) - apart;
        // the smaller piece must not be bent away from where it lies
        const double smaller = std::min(faces_[a].moments.n, faces_[b].moments.n);
        const bool same =
            both.squares(plane) <= config_.growing.max_merge_misfit * std::max(apart, both.n * s2) &&
            worse <= 0.4 * smaller * s2;
        if (!same && !bowed(faces_[a], faces_[b], both, plane)) continue;
        if (!touching(static_cast<int>(a), static_cast<int>(b))) continue;
        faces_[a].plane = plane;
        faces_[a].bowed = !same || faces_[a].bowed || faces_[b].bowed;
        faces_[a].moments = both;
        renamed[b] = static_cast<int>(a);
        for (int& o : owner_)
          if (o == static_cast<int>(b)) o = static_cast<int>(a);
      }
    // close the gaps in the numbering, so that labels stay small
    std::size_t kept = 0;
    std::vector<int> index(faces_.size(), -1);
    for (std::size_t i = 0; i < faces_.size(); ++i) {
      if (renamed[i] != static_cast<int>(i)) continue;
      index[i] = static_cast<int>(kept);
      faces_[kept++] = faces_[i];
    }
    faces_.resize(kept);
    for (int& o : owner_)
      if (o >= 0) o = index[static_cast<std::size_t>(o)];
  }

  // cardboard and cheap depth both bend faces by some millimetres; nobody would call that two faces
  [[nodiscard]] bool bowed(const Face& a, const Face& b, const InverseMoments& both,
                           const InversePlane& plane) const {
    const ImageGeometry& g = image_.geometry;
    if (g.to_W(a.plane).normal.dot(g.to_W(b.plane).normal) < config_.growing.min_bow_cosine) return false;
    const Face joined{plane, both, true};
    const double q = both.q / both.n, slant = slant_of(joined, g);
    const double rms_m = std::sqrt(both.squares(plane) / both.n) / (q * q) * slant;
    const double noise_m = image_.noise.sigma(1.0 / q) * slant;
    // where noise is as large as the bow, pieces do not part because of it; strips of cylinders and edges do
    if (image_.noise.sigma(1.0 / q) > 0.5 * image_.tolerance_m) return false;
    if (std::min(extent_of(a, g).narrow_m, extent_of(b, g).narrow_m) < config_.growing.min_bow_width_m)
      return false;
    return rms_m < std::hypot(noise_m, config_.growing.max_bow_residual * image_.tolerance_m);
  }

  [[nodiscard]] bool touching(int a, int b) const {
    for (int r = 0; r < rows_; ++r)
      for (int c = 0; c < columns_; ++c) {
        if (owner_[at(c, r)] != b) continue;
        for (int j = std::max(r - 2, 0); j <= std::min(r + 2, rows_ - 1); ++j)
          for (int i = std::max(c - 2, 0); i <= std::min(c + 2, columns_ - 1); ++i)
            if (owner_[at(i, j)] == a) return true;
      }
    return false;
  }

  ObjectImage& image_;
  std::vector<Face>& faces_;
  const SurfaceConfig& config_;
  int columns_, rows_;
  std::vector<InverseMoments> cells_;
  bool summed_ = false;
  std::vector<int> owner_;  // face of each cell, -1 for none; of the present window only
  std::vector<std::size_t> members_;
  std::vector<float> uneven_;  // tolerance of each face in depth (m)
};

}  // namespace

void grow_faces(ObjectImage& image, std::vector<Face>& faces, const SurfaceConfig& config) {
  if (!image.pixels.empty()) Grower(image, faces, config).run();
}

void refit_faces(const ObjectImage& image, std::vector<Face>& faces) {
  for (Face& f : faces) f.moments = {};
  // runs of one face along a row: what depends on the column only is summed, the rest follows for the whole
  // run
  for (int j = 0; j < image.height; ++j) {
    const std::int16_t* label = image.label.data() + image.at(0, j);
    const float* q = image.q.data() + image.at(0, j);
    for (int i = 0; i < image.width;) {
      const std::int16_t mine = label[i];
      if (mine < 0) {
        ++i;
        continue;
      }
      const int first = i;
      double sum = 0, sum_u = 0, squares = 0;
      for (; i < image.width && label[i] == mine; ++i) {
        const double d = static_cast<double>(q[i]);
        sum += d, sum_u += d * i, squares += d * d;
      }
      InverseMoments& m = faces[static_cast<std::size_t>(mine)].moments;
      const double n = i - first, middle = 0.5 * (first + i - 1), V = j;
      const double u = n * middle;
      m.n += n, m.u += u, m.v += n * V, m.q += sum;
      m.uu += n * (middle * middle + (n * n - 1) / 12), m.uv += u * V, m.vv += n * V * V;
      m.uq += sum_u, m.vq += sum * V, m.qq += squares;
    }
  }
  for (Face& f : faces)
    if (f.moments.n >= 12) f.moments.fit(f.plane);
}

double slant_of(const Face& face, const ImageGeometry& geometry) {
  constexpr double kMin = 0.25;  // keeps the tolerance of grazing faces finite
  if (!face.bowed || face.moments.n < 1) return 1.0;
  const hal::Vec3 ray = geometry.ray_W(face.moments.u / face.moments.n, face.moments.v / face.moments.n);
  return std::max(std::abs(geometry.to_W(face.plane).normal.dot(ray)), kMin);
}

FaceExtent extent_of(const Face& face, const ImageGeometry& geometry) {
  const InverseMoments& m = face.moments;
  if (m.n < 3) return {};
  const double U = m.u / m.n, V = m.v / m.n;
  // how a step of one pixel moves on the plane
  const double q = face.plane.at(U, V);
  const hal::Vec3 p = geometry.point_W(U, V, q);
  const hal::Vec3 du = geometry.point_W(U + 1, V, face.plane.at(U + 1, V)) - p;
  const hal::Vec3 dv = geometry.point_W(U, V + 1, face.plane.at(U, V + 1)) - p;
  const double cuu = m.uu / m.n - U * U, cuv = m.uv / m.n - U * V, cvv = m.vv / m.n - V * V;
  const double guu = du.squaredNorm(), guv = du.dot(dv), gvv = dv.squaredNorm();
  const double trace = guu * cuu + 2 * guv * cuv + gvv * cvv;
  const double det = std::max((guu * gvv - guv * guv) * (cuu * cvv - cuv * cuv), 0.0);
  const double root = std::sqrt(std::max(0.25 * trace * trace - det, 0.0));
  return {std::sqrt(12 * std::max(0.5 * trace - root, 0.0)), std::sqrt(12 * (0.5 * trace + root))};
}

}  // namespace colift::perception
