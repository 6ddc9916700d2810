#include "perception/map/bt_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string_view>

namespace colift::perception {
namespace {

using hal::ErrorCode;

constexpr int kDepth = 16;                // levels of an OctoMap tree
constexpr int kHalf = 1 << (kDepth - 1);  // its cells reach from -kHalf to kHalf - 1 along each axis
constexpr std::string_view kMagic = "# Octomap OcTree binary file";

tl::unexpected<hal::Error> bad(const std::filesystem::path& file, std::string detail) {
  return hal::failure(ErrorCode::BadInput, file.string(), std::move(detail));
}

struct Header {
  std::string id;
  double cell_m = 0.0;
  unsigned long long nodes = 0;
  std::size_t data = 0;  // where the nodes start
};

hal::Result<Header> read_header(const std::filesystem::path& file, const std::string& bytes) {
  if (bytes.empty()) return bad(file, "is empty, expected an OctoMap .bt file");
  if (std::string_view(bytes).substr(0, kMagic.size()) != kMagic) {
    return bad(file, fmt::format("does not start with '{}'", kMagic));
  }
  Header header;
  std::size_t at = 0;
  bool has_res = false, has_size = false;
  for (int line_number = 1; line_number <= 64; ++line_number) {
    const std::size_t end = bytes.find('\n', at);
    if (end == std::string::npos) return bad(file, "ends within its header");
    std::istringstream line(bytes.substr(at, end - at));
    at = end + 1;
    std::string key;
    line >> key;
    if (key.empty() || key[0] == '#') continue;
    if (key == "data") {
      header.data = at;
      if (header.id != "OcTree") {
        return bad(file, fmt::format("holds a tree of kind '{}', expected OcTree", header.id));
      }
      if (!has_res || !has_size) return bad(file, "has no size or no resolution in its header");
      return header;
    }
    if (key == "id") line >> header.id;
    if (key == "res") has_res = static_cast<bool>(line >> header.cell_m);
    if (key == "size") has_size = static_cast<bool>(line >> header.nodes);
  }
  return bad(file, "has no 'data' line in its header");
}

/// Reads nodes depth first, two bits for each of a node's eight children, as OctoMap writes them.
class Nodes {
 public:
  Nodes(const std::string& bytes, std::size_t at, CellGrid& grid) : bytes_(bytes), at_(at), grid_(grid) {
    for (int axis = 0; axis < 3; ++axis) {
      first_[axis] = static_cast<int>(std::lround(grid.origin[axis] / grid.cell_m)) + kHalf;
    }
  }

  /// Children of the node whose cube of 2^level cells starts at a corner (keys). What is wrong, or null.
  const char* read(int level, const Eigen::Vector3i& corner) {
    if (bytes_.size() - at_ < 2) return "ends within its tree";
    const unsigned low = static_cast<unsigned char>(bytes_[at_]);
    const unsigned high = static_cast<unsigned char>(bytes_[at_ + 1]);
    at_ += 2;
    ++nodes_;
    const unsigned kinds = low | (high << 8);
    const int half = 1 << (level - 1);
    for (int child = 0; child < 8; ++child) {
      const unsigned kind = (kinds >> (2 * child)) & 3u;
      if (kind == 0) continue;
      const Eigen::Vector3i at =
          corner + half * Eigen::Vector3i(child & 1, (child >> 1) & 1, (child >> 2) & 1);
      if (kind != 3) {
        ++nodes_;
        fill(at, half, kind == 2 ? CellState::Occupied : CellState::Free);
        continue;
      }
      if (level == 1) return "has a tree that is deeper than 16 levels";
      if (const char* wrong = read(level - 1, at)) return wrong;
    }
    return nullptr;
  }

  [[nodiscard]] std::size_t at() const { return at_; }
  [[nodiscard]] unsigned long long nodes() const { return nodes_; }

 private:
  void fill(const Eigen::Vector3i& corner, int size, CellState state) {
    const Eigen::Vector3i n(grid_.nx, grid_.ny, grid_.nz);
    const Eigen::Vector3i from = (corner - first_).cwiseMax(0);
    const Eigen::Vector3i to = (corner - first_ + Eigen::Vector3i::Constant(size)).cwiseMin(n);
    for (int z = from.z(); z < to.z(); ++z) {
      for (int y = from.y(); y < to.y(); ++y) {
        for (int x = from.x(); x < to.x(); ++x) grid_.cells[grid_.index(x, y, z)] = state;
      }
    }
  }

  const std::string& bytes_;
  std::size_t at_;
  CellGrid& grid_;
  Eigen::Vector3i first_;
  unsigned long long nodes_ = 0;
};

}  // namespace

hal::Result<> read_bt(const std::filesystem::path& file, CellGrid& grid) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error)) return bad(file, "is no file that can be read");
  std::ifstream in(file, std::ios::binary);
  if (!in) return bad(file, "cannot be opened");
  const std::string bytes{std::istreambuf_iterator<char>(in), {}};
  if (in.bad()) return bad(file, "cannot be read to its end");

  const auto header = read_header(file, bytes);
  if (!header) return tl::unexpected(header.error());
  if (!(std::abs(header->cell_m - grid.cell_m) <= 1e-6)) {
    return bad(file, fmt::format("has cells of {} m, expected {} m", header->cell_m, grid.cell_m));
  }
  if (header->nodes == 0) {
    if (header->data != bytes.size()) return bad(file, "says that it is empty but is not");
    return {};
  }
  Nodes nodes(bytes, header->data, grid);
  if (const char* wrong = nodes.read(kDepth, Eigen::Vector3i::Zero())) return bad(file, wrong);
  if (nodes.nodes() != header->nodes) {
    return bad(file, fmt::format("holds {} nodes, its header says {}", nodes.nodes(), header->nodes));
  }
  if (nodes.at() != bytes.size()) {
    return bad(file, fmt::format("goes on for {} bytes after its tree", bytes.size() - nodes.at()));
  }
  return {};
}

}  // namespace colift::perception
