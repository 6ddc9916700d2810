#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string>

#include "sim_hal/synthetic/kinect/kinect_noise.hpp"
#include "sim_hal/synthetic/ray_caster.hpp"
#include "sim_hal/synthetic/shapes.hpp"
#include "tools/visualization/canvas.hpp"
#include "tools/visualization/palette.hpp"
#include "tools/visualization/report/report.hpp"
#include "tools/visualization/scene/frame_raster.hpp"
#include "tools/visualization/scene/scene_picture.hpp"
#include "tools/visualization/scene/top_view.hpp"
#include "tools/visualization/utf8.hpp"

using namespace colift;
using namespace colift::picture;

namespace {

// A box on the floor seen from 1.4 m away and 1 m above, without noise, with a hole in the depth.
struct Example {
  hal::Pose X_WC = sim_hal::look_at({-1.4, 0, 1.0}, {0, 0, 0.15});
  hal::CameraIntrinsics intrinsics{160, 120, 144, 144, 79.5, 59.5};
  perception::OrganisedCloud cloud;
  perception::Scene scene;
  std::vector<planner::GraspCandidate> candidates;
  ScenePicture what;

  Example() {
    sim_hal::World world;
    world.shapes.push_back(sim_hal::half_space({0, 0, 0}, {0, 0, 1}, sim_hal::Label::Ground));
    world.shapes.push_back(sim_hal::box({0, 0, 0.15}, {0.3, 0.5, 0.3}, 0, sim_hal::Label::Target));
    const sim_hal::Rendering truth = sim_hal::cast_rays(world, intrinsics, X_WC);
    hal::DepthFrame frame = sim_hal::measure_ideal(truth);
    for (int v = 100; v < 110; ++v)
      for (int u = 10; u < 20; ++u) frame.depth_m[static_cast<std::size_t>(v * 160 + u)] = std::nanf("");
    cloud = perception::deproject(frame, X_WC);
    scene.ground = perception::Ground{{hal::Vec3::UnitZ(), 0.0}, 9000, 0.001};
    perception::Target target;
    for (std::size_t i = 0; i < cloud.size(); ++i)
      if (truth.label[i] == sim_hal::Label::Target) {
        target.pixels.push_back(static_cast<std::uint32_t>(i));
        target.points.push_back(cloud.point(i).cast<float>());
      }
    target.obb = {{0, 0, 0.15}, Eigen::Matrix3d::Identity(), {0.3, 0.5, 0.3}};
    target.shape = target.obb;
    target.cog = {0, 0, 0.15};
    target.cog_covariance = 1e-4 * Eigen::Matrix3d::Identity();
    scene.target = target;
    scene.surfaces.push_back(perception::Rectangle{
        {-0.15, 0, 0.15}, -hal::Vec3::UnitX(), -hal::Vec3::UnitY(), hal::Vec3::UnitZ(), {0.5, 0.3}, 1.0});
    what.cloud = &cloud;
    what.scene = &scene;
    what.candidates = &candidates;
    what.title = "Example";
    what.reason = "made by hand";
  }
  Example(const Example&) = delete;
  Example& operator=(const Example&) = delete;

  // Colour of the picture at a point in W.
  [[nodiscard]] Colour at(const Canvas& canvas, const hal::Vec3& p) const {
    const auto px = cloud.project(p);
    const double s = picture_scale(cloud);
    return canvas.at(static_cast<int>(s * (px.u + 0.5)), static_cast<int>(s * (px.v + 0.5)));
  }
};

double distance(const Colour& a, const Colour& b) {
  return std::max({std::abs(a.r - b.r), std::abs(a.g - b.g), std::abs(a.b - b.b)});
}

bool column_is(const Canvas& canvas, int x, const Colour& colour) {
  for (int y = 0; y < canvas.height(); ++y)
    if (distance(canvas.at(x, y), colour) > 0.02) return false;
  return true;
}

std::uint32_t big_endian(const std::vector<std::uint8_t>& bytes, std::size_t at) {
  return (std::uint32_t{bytes[at]} << 24) | (std::uint32_t{bytes[at + 1]} << 16) |
         (std::uint32_t{bytes[at + 2]} << 8) | bytes[at + 3];
}

}  // namespace

TEST_CASE("the picture shows the frame where the camera saw it") {
  Example e;
  e.what.partner = perception::PartnerGrasp{{0, -0.25, 0.28}, 1e-5 * Eigen::Matrix3d::Identity(), 10};
  planner::GraspCandidate ok, refused;
  ok.position = {-0.15, 0.2, 0.2};
  ok.approach = hal::Vec3::UnitX();
  ok.closing = hal::Vec3::UnitZ();
  refused = ok;
  refused.id = 1;
  refused.position = {-0.15, 0.1, 0.05};
  refused.verdict = planner::Verdict::NearPartner;
  e.candidates = {ok, refused};
  const Canvas canvas = draw_scene_picture(e.what);

  CHECK(picture_scale(e.cloud) == 8);
  CHECK(canvas.width() > 8 * 160 + 300);
  CHECK(canvas.height() >= 8 * 120);
  CHECK(distance(e.at(canvas, e.scene.target->cog), kCog) < 0.02);
  CHECK(distance(e.at(canvas, e.what.partner->position), kPartner) < 0.02);
  CHECK(distance(e.at(canvas, ok.position), style_of(ok.verdict).colour) < 0.02);
  CHECK(distance(canvas.at(8 * 15, 8 * 105), kMissing) < 0.02);

  const Colour on_top = e.at(canvas, {0.0, 0.18, 0.3}), on_floor = e.at(canvas, {-0.6, 0.40, 0.0});
  CHECK(on_top.r > on_top.b + 0.1);
  CHECK(on_floor.b > on_floor.r + 0.02);

  SECTION("the same input gives the same bits") {
    CHECK(canvas.png() == draw_scene_picture(e.what).png());
  }
}

TEST_CASE("the grid on the ground has lines at whole multiples of its step") {
  Example e;
  const int scale = 8;
  const std::vector<std::uint8_t> raster = frame_raster(e.what, scale);
  const auto bright = [&](const hal::Vec3& p) {
    const auto px = e.cloud.project(p);
    const auto x = static_cast<std::size_t>(scale * (px.u + 0.5)),
               y = static_cast<std::size_t>(scale * (px.v + 0.5));
    const std::uint8_t* c = raster.data() + 3 * (y * 160 * scale + x);
    return c[0] + c[1] + c[2];
  };
  CHECK(grid_step_m(1.0) == Approx(0.25));
  // the grid starts beneath the camera, at x = -1.4
  for (const double along : {0.75, 1.0})
    for (const double across : {-0.25, 0.25}) {
      const hal::Vec3 knot(-1.4 + along, across, 0.0);
      const hal::Vec3 inside = knot + hal::Vec3(0.1, 0.125, 0);
      INFO("knot " << along << ", " << across);
      CHECK(bright(knot) > bright(inside) + 40);
      CHECK(bright(knot + hal::Vec3(0.1, 0, 0)) > bright(inside) + 40);
    }
}

TEST_CASE("points of a method that knows no pixels still mark the target") {
  Example e;
  const std::vector<std::uint8_t> by_pixels = target_mask(e.cloud, *e.scene.target);
  perception::Target no_pixels = *e.scene.target;
  no_pixels.pixels.clear();
  const std::vector<std::uint8_t> by_points = target_mask(e.cloud, no_pixels);
  std::size_t both = 0, either = 0;
  for (std::size_t i = 0; i < by_pixels.size(); ++i)
    both += by_pixels[i] && by_points[i], either += by_pixels[i] || by_points[i];
  CHECK(static_cast<double>(both) > 0.85 * static_cast<double>(either));
}

TEST_CASE("a frame without a target shows the reason, whole, however long it is") {
  Example e;
  e.scene.target.reset();
  e.scene.surfaces.clear();
  for (int i = 0; i < 60; ++i)
    e.what.reason += " and nothing that stands free on the ground was larger than 50 cm2";
  e.what.reason += " " + std::string(200, 'W');
  e.what.notes.assign(3, std::string(400, 'n'));
  const Canvas canvas = draw_scene_picture(e.what);
  CHECK(canvas.height() > 8 * 120 + 300);
  // nothing reaches the margins
  for (int x = canvas.width() - 20; x < canvas.width(); ++x) CHECK(column_is(canvas, x, kPanel));
  for (int x = 8 * 160; x < 8 * 160 + 20; ++x) CHECK(column_is(canvas, x, kPanel));
}

TEST_CASE("places that cannot be drawn are left out and do no harm") {
  Example e;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  planner::GraspCandidate lost, behind;
  lost.position = {nan, nan, nan};
  behind.position = {-5, 0, 1};
  behind.verdict = planner::Verdict::Chosen;
  e.candidates = {lost, behind};
  e.scene.target->cog_covariance.setConstant(nan);
  e.what.partner =
      perception::PartnerGrasp{{-1.4, 0, 1.0}, Eigen::Matrix3d::Zero(), 0};  // in the camera's centre
  e.what.optimum = hal::Vec3(1e6, 0, 0);
  e.what.partner_pixels = {4'000'000'000u};
  e.what.share = 1.7;
  const Canvas canvas = draw_scene_picture(e.what);
  CHECK(distance(e.at(canvas, {0.0, 0.18, 0.3}), kTarget) < 0.45);
  CHECK(draw_scene_picture({}).width() > 1000);
}

TEST_CASE("the file is a PNG of the picture's size") {
  Canvas canvas(123, 45, kPaper);
  const std::vector<std::uint8_t> png = canvas.png();
  REQUIRE(png.size() > 33);
  CHECK(std::string(png.begin() + 1, png.begin() + 4) == "PNG");
  CHECK(big_endian(png, 16) == 123);
  CHECK(big_endian(png, 20) == 45);

  const std::filesystem::path file = std::filesystem::temp_directory_path() / "colift_picture_test.png";
  REQUIRE(canvas.write_png(file));
  CHECK(std::filesystem::file_size(file) == png.size());
  CHECK_FALSE(std::filesystem::exists(file.string() + ".part"));
  std::filesystem::remove(file);
}

TEST_CASE("a path that cannot be written is refused with what is in the way") {
  const Canvas canvas(4, 4, kPaper);
  const auto nowhere = canvas.write_png("/no/such/folder/picture.png");
  REQUIRE_FALSE(nowhere);
  CHECK(nowhere.error().code == hal::ErrorCode::BadInput);
  CHECK(nowhere.error().text() ==
        "/no/such/folder/picture.png: cannot be written: the directory '/no/such/folder' does not exist");
  const auto out = std::filesystem::temp_directory_path() / "colift_picture_test_out";
  std::filesystem::remove_all(out);
  CHECK(canvas.write_png(out / "picture.png"));  // the last folder alone is made
  std::filesystem::remove_all(out);
  const auto folder = canvas.write_png(std::filesystem::temp_directory_path());
  REQUIRE_FALSE(folder);
  CHECK(folder.error().detail == "cannot be written: it is a directory");
  CHECK_FALSE(canvas.write_png(""));
  if (std::filesystem::exists("/dev/full")) {
    const auto full = write_report("/dev/full", Report{});
    REQUIRE_FALSE(full);
    CHECK(full.error().detail.find("No space left on device") != std::string::npos);
  }
}

TEST_CASE("text is broken into lines that fit and loses no letter") {
  const Canvas canvas(10, 10, kPaper);
  const TextStyle style{.size = 16};
  const std::string words = "Größe × Höhe: " + std::string(60, 'x') + " näher  als\n1 cm";
  std::string joined;
  for (const std::string& line : canvas.wrap(words, 90, style)) {
    CHECK(canvas.text_width(line, style) <= 90);
    CHECK(valid_utf8(line) == line);
    joined += line;
  }
  const auto letters = [](std::string s) {
    std::erase_if(s, [](char c) { return c == ' ' || c == '\n'; });
    return s;
  };
  CHECK(letters(joined) == letters(words));
  CHECK(canvas.wrap("wide", 0.5, style).size() == 4);
  CHECK(canvas.wrap("", 90, style).empty());
}

TEST_CASE("the uncertainty ellipse has the covariance it was made from") {
  Eigen::Matrix2d covariance;
  covariance << 5, -2, -2, 3;
  const Eigen::Matrix2d axes = ellipse_of(covariance, 2.0);
  CHECK((axes * axes.transpose() - 4 * covariance).norm() < 1e-12);
}

TEST_CASE("bytes that are no UTF-8 become question marks") {
  CHECK(valid_utf8("Höhe 1 m") == "Höhe 1 m");
  CHECK(valid_utf8("a\xFF"
                   "b\xC3") == "a?b?");
  CHECK(valid_utf8("\xED\xA0\x80") == "???");  // half of a surrogate pair
  CHECK(valid_utf8("a\x01\x7F") == "a  ");
}

TEST_CASE("nothing in a report can break out of its place in the page") {
  Report report;
  report.title = "<script>alert('a')</script>";
  report.summary = {"5 < 6 & \"7\""};
  report.candidates.push_back({.id = 1, .kind = "<b>", .reason = "</td><img src=x>"});
  report.facts = {{"file", "a\"onload=\"b.png"}};
  report.command = "colift look '<x>'";
  report.pictures.push_back({{}, "\"><i>"});
  const std::string page = report_html(report);
  for (const char* bad : {"<script", "<b>", "<img src=x", "\"onload", "<x>", "\"><i>"}) {
    INFO(bad);
    CHECK(page.find(bad) == std::string::npos);
  }
  CHECK(page.find("5 &lt; 6 &amp; &quot;7&quot;") != std::string::npos);
}

TEST_CASE("a report holds its pictures and puts the best candidates first") {
  Report report;
  report.pictures.push_back({{'M', 'a', 'n'}, "whole"});
  report.pictures.push_back({{'M', 'a'}, "one short"});
  report.pictures.push_back({{'M'}, "two short"});
  using planner::Verdict;
  report.candidates.push_back({.id = 1, .verdict = Verdict::Collision, .reason = "row one"});
  report.candidates.push_back({.id = 2, .verdict = Verdict::Ok, .cost = 9.0, .reason = "row two"});
  report.candidates.push_back({.id = 3, .verdict = Verdict::Ok, .cost = 2.0, .reason = "row three"});
  report.candidates.push_back(
      {.id = 4, .verdict = Verdict::Chosen, .share = 0.525, .cost = 1.0, .reason = "row four"});
  report.timing = {{"ground", 1.25}, {"target", 0.0}};
  const std::string page = report_html(report);
  for (const char* part : {"base64,TWFu\"", "base64,TWE=\"", "base64,TQ==\"", "52.5 %", "1.25 ms"}) {
    INFO(part);
    CHECK(page.find(part) != std::string::npos);
  }
  CHECK(page.find("row four") < page.find("row three"));
  CHECK(page.find("row three") < page.find("row two"));
  CHECK(page.find("row two") < page.find("row one"));
  CHECK(page.find("src=\"http") == std::string::npos);
}
