#include "planner/motion/collision/squared_distances.hpp"

#include <catch2/catch.hpp>

#include "sim_hal/synthetic/hash_random.hpp"

namespace {

using namespace colift;
using planner::GridSize;

std::vector<std::uint8_t> random_cells(const GridSize& size, std::uint64_t seed, double density) {
  sim_hal::Draws draws(seed, 1);
  std::vector<std::uint8_t> cells;
  for (int i = 0; i < size.nx * size.ny * size.nz; ++i) cells.push_back(draws.chance(density));
  return cells;
}

/// From every corner to the corners of every obstacle cell.
std::vector<std::int16_t> by_definition(const GridSize& size, const std::vector<std::uint8_t>& cells,
                                        int reach) {
  std::vector<std::int16_t> out;
  for (int z = 0; z <= size.nz; ++z)
    for (int y = 0; y <= size.ny; ++y)
      for (int x = 0; x <= size.nx; ++x) {
        int least = reach * reach;
        std::size_t i = 0;
        for (int cz = 0; cz < size.nz; ++cz)
          for (int cy = 0; cy < size.ny; ++cy)
            for (int cx = 0; cx < size.nx; ++cx, ++i) {
              if (cells[i] == 0) continue;
              const auto away = [](int corner, int cell) {
                return std::max({cell - corner, corner - cell - 1, 0});
              };
              const int dx = away(x, cx), dy = away(y, cy), dz = away(z, cz);
              least = std::min(least, dx * dx + dy * dy + dz * dz);
            }
        out.push_back(static_cast<std::int16_t>(least));
      }
  return out;
}

}  // namespace

TEST_CASE("squared distances are those of the definition, for short and for long reaches") {
  // rows shorter and longer than a strip of 16 or 32 corners, and values of one and of two bytes
  const std::vector<GridSize> sizes{{3, 5, 7}, {31, 9, 4}, {32, 4, 9}, {47, 12, 6}};
  for (const GridSize& size : sizes)
    for (const int reach : {1, 4, 15, 16, 40})
      for (const double density : {0.0, 0.003, 0.05, 0.9}) {
        const auto cells = random_cells(size, static_cast<std::uint64_t>(reach), density);
        CAPTURE(size.nx, size.ny, size.nz, reach, density);
        REQUIRE(planner::squared_distances(size, cells, reach) == by_definition(size, cells, reach));
      }
}

TEST_CASE("a single obstacle in a corner of the grid is seen from the opposite one") {
  const GridSize size{40, 3, 2};
  std::vector<std::uint8_t> cells(240, 0);
  cells.front() = 1;
  const auto squared = planner::squared_distances(size, cells, planner::kMaxReach_cells);
  CHECK(squared.front() == 0);
  CHECK(squared.back() == 39 * 39 + 2 * 2 + 1);
}
