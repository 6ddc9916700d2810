// One file to send: a tar archive that the system's tar reads.
#include "tools/bring_up/bundle/bundle.hpp"

#include <catch2/catch.hpp>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

using namespace colift::tools;
namespace fs = std::filesystem;

TEST_CASE("a bundle is read by tar, byte for byte, and names that cannot be are left out", "[bundle]") {
  const fs::path folder = fs::temp_directory_path() / "colift_bundle_test";
  fs::remove_all(folder);
  fs::create_directories(folder);
  std::string text(512, 'x');
  for (const char c : {'\n', 'e', 'n', 'd'}) text.push_back(c);
  REQUIRE(write_bundle(folder / "hand.tar", {{"state.txt", text}, {"../evil", "no"}, {"empty.log", ""}}));
  CHECK_FALSE(write_bundle(folder / "hand.tar", {}));  // it is kept
  REQUIRE(std::system(("tar -xf " + (folder / "hand.tar").string() + " -C " + folder.string()).c_str()) == 0);
  std::ifstream in(folder / "hand" / "state.txt");
  CHECK(std::string(std::istreambuf_iterator<char>(in), {}) == text);
  CHECK(fs::file_size(folder / "hand" / "empty.log") == 0);
  CHECK(std::distance(fs::directory_iterator(folder / "hand"), fs::directory_iterator()) == 2);
  fs::remove_all(folder);
}
