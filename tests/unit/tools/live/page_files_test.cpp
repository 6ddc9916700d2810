#include "tools/live/page_files.hpp"

#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>

using namespace colift::live;
namespace fs = std::filesystem;

TEST_CASE("a path is cleaned, or not served") {
  CHECK(clean_path("/assets/a.js?v=1#x") == "/assets/a.js");
  CHECK(clean_path("/a%20b.png") == "/a b.png");
  for (const char* bad : {"", "a", "/..", "/../etc/passwd", "/a/../b", "/%2e%2e/x", "/.hidden", "//x", "/a%0",
                          "/a%zz", "/a\\b", "/a%00.html", "/a%0d%0aX: 1"}) {
    INFO(bad);
    CHECK_FALSE(clean_path(bad));
  }
}

TEST_CASE("files of the page are served with their types, and nothing beside them") {
  const fs::path root = fs::temp_directory_path() / "colift_page_files_test";
  fs::remove_all(root);
  fs::create_directories(root / "page" / "assets");
  std::ofstream(root / "page" / "index.html") << "<p>hello";
  std::ofstream(root / "page" / "assets" / "a.js") << "1";
  std::ofstream(root / "page" / "key.pem") << "secret";
  std::ofstream(root / "outside.js") << "secret";

  PageFiles files(root / "page");
  files.add("/robot.urdf", {"application/xml", "<robot/>"});
  CHECK(files.find("/")->body == "<p>hello");
  CHECK(files.find("/?token=x")->type == "text/html; charset=utf-8");
  CHECK(files.find("/assets/a.js")->type == "text/javascript; charset=utf-8");
  CHECK(files.find("/robot.urdf")->body == "<robot/>");
  CHECK_FALSE(files.find("/key.pem"));
  CHECK_FALSE(files.find("/../outside.js"));
  CHECK_FALSE(files.find("/assets"));
  fs::remove_all(root);
}

TEST_CASE("without a built page the address still explains itself") {
  const PageFiles files("/nowhere/at/all");
  REQUIRE(files.find("/"));
  CHECK(files.find("/")->body.find("npm") != std::string::npos);
  CHECK_FALSE(files.find("/assets/a.js"));
}
