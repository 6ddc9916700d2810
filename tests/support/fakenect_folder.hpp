#pragma once

#include <filesystem>
#include <fstream>
#include <random>
#include <string>
#include <vector>

#include "tests/support/temporary_folder.hpp"

namespace colift::tests {

/// A recording in a folder of its own that goes away with it, made of the frame in tests/data/fakenect.
class FakenectFolder {
 public:
  FakenectFolder() { write_index(); }

  [[nodiscard]] const std::filesystem::path& path() const { return folder_.path(); }

  void depth(double at_s, std::uint32_t ticks) { link(name('d', at_s, ticks, ".pgm"), "depth.pgm"); }
  void accelerometer(double at_s, std::uint32_t ticks) {
    link(name('a', at_s, ticks, ".dump"), "accelerometer.dump");
  }
  /// A frame file without a byte: the library reports one error, and goes on.
  void bad_transfer(double at_s, std::uint32_t ticks) {
    const std::string n = name('d', at_s, ticks, ".pgm");
    std::ofstream(path() / n);
    add(n);
  }
  /// A depth frame of other pixels.
  void depth(double at_s, std::uint32_t ticks, const std::vector<std::uint16_t>& codes) {
    const std::string n = name('d', at_s, ticks, ".pgm");
    std::ofstream out(path() / n, std::ios::binary);
    out << "P5 640 480 65535\n";
    out.write(reinterpret_cast<const char*>(codes.data()), static_cast<std::streamsize>(2 * codes.size()));
    add(n);
  }

 private:
  static std::string name(char kind, double at_s, std::uint32_t ticks, const char* ending) {
    char text[80];
    std::snprintf(text, sizeof text, "%c-%f-%u%s", kind, at_s, ticks, ending);
    return text;
  }
  void link(const std::string& n, const char* to) {
    std::filesystem::create_symlink(std::filesystem::path(COLIFT_TEST_DATA) / "fakenect" / to, path() / n);
    add(n);
  }
  void add(const std::string& n) {
    names_.push_back(n);
    write_index();
  }
  void write_index() const {
    std::ofstream out(path() / "INDEX.txt");
    for (const std::string& n : names_) out << n << "\n";
  }

  TemporaryFolder folder_;
  std::vector<std::string> names_;
};

}  // namespace colift::tests
