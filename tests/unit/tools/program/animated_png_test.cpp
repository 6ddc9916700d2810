// A film is read again by the rules of the PNG specification, chunk by chunk, and shows what went in.
#include <zlib.h>

#include <catch2/catch.hpp>
#include <cstring>
#include <random>
#include <string>

#include "tools/visualization/animated_png.hpp"

namespace colift::picture {
namespace {

using Bytes = std::vector<std::uint8_t>;

std::uint32_t number(const Bytes& b, std::size_t at, int bytes = 4) {
  std::uint32_t x = 0;
  for (int k = 0; k < bytes; ++k) x = 256 * x + b.at(at + static_cast<std::size_t>(k));
  return x;
}

struct Film {
  int width = 0, height = 0;
  std::uint32_t promised = 0;
  std::vector<Bytes> frames;  // 3 bytes a pixel
  std::vector<double> delays_s;
};

Bytes inflated(const Bytes& data, std::size_t size) {
  Bytes out(size);
  uLongf got = static_cast<uLongf>(size);
  REQUIRE(uncompress(out.data(), &got, data.data(), static_cast<uLong>(data.size())) == Z_OK);
  REQUIRE(got == size);
  return out;
}

Film read(const Bytes& png) {
  Film film;
  REQUIRE(std::memcmp(png.data(), "\x89PNG\r\n\x1a\n", 8) == 0);
  std::uint32_t next = 0, w = 0, h = 0, x = 0, y = 0;
  Bytes canvas;
  std::string type;
  for (std::size_t at = 8; at < png.size();) {
    const std::uint32_t length = number(png, at);
    type.assign(png.begin() + static_cast<std::ptrdiff_t>(at + 4),
                png.begin() + static_cast<std::ptrdiff_t>(at + 8));
    Bytes data(png.begin() + static_cast<std::ptrdiff_t>(at + 8),
               png.begin() + static_cast<std::ptrdiff_t>(at + 8 + length));
    CHECK(number(png, at + 8 + length) == crc32(0, png.data() + at + 4, length + 4));
    at += 12 + length;
    if (type == "IHDR") {
      film.width = static_cast<int>(number(data, 0));
      film.height = static_cast<int>(number(data, 4));
      canvas.resize(3U * static_cast<std::size_t>(film.width) * static_cast<std::size_t>(film.height));
    } else if (type == "acTL") {
      film.promised = number(data, 0);
    } else if (type == "fcTL") {
      CHECK(number(data, 0) == next++);
      w = number(data, 4), h = number(data, 8), x = number(data, 12), y = number(data, 16);
      REQUIRE(x + w <= static_cast<std::uint32_t>(film.width));
      REQUIRE(y + h <= static_cast<std::uint32_t>(film.height));
      film.delays_s.push_back(static_cast<double>(number(data, 20, 2)) / number(data, 22, 2));
    } else if (type == "IDAT" || type == "fdAT") {
      if (type == "fdAT") {
        CHECK(number(data, 0) == next++);
        data.erase(data.begin(), data.begin() + 4);
      }
      const std::size_t row = 4U * w;
      Bytes raw = inflated(data, (row + 1) * h), above(row, 0);
      for (std::size_t v = 0; v < h; ++v) {
        std::uint8_t* const p = raw.data() + v * (row + 1) + 1;
        for (std::size_t k = 0; k < row; ++k) {
          if (p[-1] == 1 && k >= 4) p[k] = static_cast<std::uint8_t>(p[k] + p[k - 4]);
          if (p[-1] == 2) p[k] = static_cast<std::uint8_t>(p[k] + above[k]);
        }
        std::memcpy(above.data(), p, row);
        for (std::size_t u = 0; u < w; ++u)
          if (p[4 * u + 3] == 255)
            std::memcpy(canvas.data() + 3 * ((y + v) * static_cast<std::size_t>(film.width) + x + u),
                        p + 4 * u, 3);
      }
      film.frames.push_back(canvas);
    }
  }
  CHECK(type == "IEND");
  return film;
}

}  // namespace

TEST_CASE("a film shows every picture that went in, the last one longest", "[program]") {
  std::mt19937_64 random(GENERATE(1U, 2U, 3U));
  const int width = 1 + static_cast<int>(random() % 40), height = 1 + static_cast<int>(random() % 30);
  std::vector<Bytes> frames;
  Bytes frame(3U * static_cast<std::size_t>(width) * static_cast<std::size_t>(height), 200);
  for (int k = 0; k < 8; ++k) {
    if (k != 4)  // one that is as the one before
      for (int n = 0; n < 20; ++n) frame[random() % frame.size()] = static_cast<std::uint8_t>(random());
    frames.push_back(frame);
  }
  const Film film = read(animated_png(width, height, frames, 0.15, 2.0));
  CHECK(film.width == width);
  CHECK(film.height == height);
  CHECK(film.promised == frames.size());
  CHECK(film.frames == frames);
  CHECK(film.delays_s.front() == Approx(0.15));
  CHECK(film.delays_s.back() == Approx(2.0));
}

TEST_CASE("what is no picture of the film's size is left out of it", "[program]") {
  const std::vector<Bytes> frames{Bytes(12, 1), Bytes(11, 2), Bytes(12, 3), {}};
  CHECK(read(animated_png(2, 2, frames, 0.1, 0.1)).frames.size() == 2);
  CHECK(animated_png(2, 2, {}, 0.1, 0.1).empty());
  CHECK(animated_png(0, 2, frames, 0.1, 0.1).empty());
  CHECK(animated_png(-3, -3, frames, 0.1, 0.1).empty());
  CHECK(read(animated_png(2, 2, frames, 1e9, -1.0)).delays_s == std::vector<double>{60.0, 0.0});
}

}  // namespace colift::picture
