// The program as a user starts it: exit codes, one JSON document on stdout, one sentence on stderr.

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "tests/stories/run_program.hpp"

namespace {

using Json = nlohmann::json;

using story::run_colift;
using story::scratch;
using story::slurp;
using Run = story::ProgramRun;

const std::string kReal = std::string(COLIFT_TEST_DATA) + "/real/";
const std::string kCan = kReal + "05_can_on_table/depth.png";
const std::string kLaptop = kReal + "02_laptop_and_box/depth_0.png";

bool unit(const Json& v) {
  double square = 0;
  for (const auto& x : v) square += x.get<double>() * x.get<double>();
  return std::abs(square - 1.0) < 1e-6;
}

}  // namespace

TEST_CASE("look prints one JSON document of the agreed form", "[program]") {
  const Run r = run_colift("look " + kLaptop + " --json --quiet");
  CHECK(r.code == 0);
  const Json j = Json::parse(r.out);
  CHECK(j["schema"] == "colift.look/1");
  CHECK(j["method"] == "fast");
  CHECK(j["points"] == 307200);
  CHECK(unit(j["ground"]["normal"]));
  for (const char* key : {"points", "aabb", "obb", "cog", "cog_sigma", "shape"})
    CHECK(j["target"].contains(key));
  CHECK(j["target"]["obb"]["axes"].size() == 3);
  CHECK_FALSE(j["surfaces"].empty());
  CHECK_FALSE(j["candidates"].empty());
  int id = 0;
  for (const auto& c : j["candidates"]) {
    CHECK(c["id"] == id++);
    CHECK(unit(c["approach"]));
    CHECK(unit(c["closing"]));
    CHECK((c["verdict"] == "ok" || c.contains("because")));
  }
  for (const char* key : {"ground", "target", "surfaces", "candidates", "total"})
    CHECK(j["timing_ms"][key].is_number());
}

TEST_CASE("a frame without a target is a finding, exit code 1", "[program]") {
  const Run r = run_colift("look " + kReal + "04_five_people/depth.png --json");
  CHECK(r.code == 1);
  const Json j = Json::parse(r.out);
  CHECK(j["target"].is_null());
  CHECK(j["candidates"].empty());
  CHECK(j["because"].get<std::string>().find("no target") == 0);
}

TEST_CASE("what counts as a target on a table is what the configuration says", "[program]") {
  const std::string office = "look " + kReal + "12_office/depth.png --support table";
  CHECK(run_colift(office).code == 0);
  CHECK(run_colift(office + " --set target.on_table.max_height_m=0.05").code == 1);
  // that of what stands on the floor is another one
  CHECK(run_colift(office + " --set target.max_height_m=0.05").code == 0);
}

TEST_CASE("results are in the robot's frame when the camera's pose is known", "[program]") {
  // the camera one metre above the floor, looking along the base's x axis and 35 degrees down
  const Run r =
      run_colift("look " + kLaptop + " --json --camera-pose 0,0,1,-0.64086,0.64086,-0.29884,0.29884");
  INFO(r.err);
  REQUIRE((r.code == 0 || r.code == 1));
  const Json j = Json::parse(r.out);
  if (!j["ground"].is_null()) CHECK(j["ground"]["normal"][2].get<double>() > 0.9);
}

TEST_CASE("decide names the chosen candidate and says why", "[program]") {
  const Run r = run_colift("decide " + kLaptop + " --partner -0.27,-0.03,0.78 --json");
  CHECK(r.code == 0);
  const Json j = Json::parse(r.out);
  CHECK(j["schema"] == "colift.decide/1");
  const int chosen = j["decision"]["candidate"];
  int marked = 0;
  for (const auto& c : j["candidates"]) {
    if (c["verdict"] != "chosen") continue;
    ++marked;
    CHECK(c["id"] == chosen);
  }
  CHECK(marked == 1);
  CHECK(j["decision"]["because"].get<std::string>().size() > 40);
  for (const auto& c : j["candidates"])
    if (c["verdict"] == "ok") CHECK(c["cost"].get<double>() >= j["decision"]["cost"].get<double>());
}

TEST_CASE("a larger wanted share moves the choice towards the centre of gravity", "[program]") {
  const auto share = [](const char* s) {
    const Run r = run_colift("decide " + kLaptop + " --partner -0.27,-0.03,0.78 --json --share " + s);
    REQUIRE(r.code == 0);
    return Json::parse(r.out)["decision"]["share"].get<double>();
  };
  CHECK(share("0.7") > share("0.3"));
}

TEST_CASE("decide says which shares are possible, and never that 55 % are the 30 % that were asked",
          "[program]") {
  const std::string decide = "decide " + kLaptop + " --partner -0.27,-0.03,0.78 --share 0.3";
  const Run r = run_colift(decide + " --json");
  REQUIRE(r.code == 0);
  const Json share = Json::parse(r.out)["share"];
  CHECK(share["wanted"] == 0.3);
  const double low = share["reachable"][0], high = share["reachable"][1], predicted = share["predicted"];
  CHECK(0.3 < low);
  CHECK((low <= predicted && predicted <= high && predicted <= low + 0.02));
  CHECK((share["interval"][0] <= predicted && predicted <= share["interval"][1]));
  CHECK(share["as_wished"] == false);
  CHECK(share["because"].get<std::string>().find("30 % asked: ") == 0);
  CHECK(share["mass_kg"].is_null());
  CHECK(share["partner_load_n"].is_null());
  CHECK(share["partner_limit_n"] == 245.0);
  CHECK(Json::parse(r.out)["decision"]["share"] == predicted);

  const Run strict = run_colift(decide + " --share-strict 0.1 --json");
  CHECK(strict.code == 1);
  const Json refused = Json::parse(strict.out);
  CHECK(refused["decision"].is_null());
  CHECK(refused["because"].get<std::string>().find("30 % of the load were wanted") != std::string::npos);
  CHECK(refused["share"]["reachable"].size() == 2);
}

TEST_CASE("a run with a strict share that cannot be had is refused, and nothing moves", "[program]") {
  const Run r = run_colift("run --seed 1 --share 0.3 --share-strict 0.05 --json --quiet");
  CHECK(r.code == 1);
  const Json run = Json::parse(r.out);
  CHECK(run["outcome"] == "refused");
  CHECK(run["because"].get<std::string>().find("limit 5.0 %") != std::string::npos);
  CHECK(run["asked"].empty());
  CHECK(run["share"]["wanted"] == 0.3);
}

TEST_CASE("the same frame gives the same decision, but for the times", "[program]") {
  const auto once = [] {
    Json j = Json::parse(run_colift("decide " + kLaptop + " --partner -0.27,-0.03,0.78 --json").out);
    j.erase("timing_ms");
    return j;
  };
  CHECK(once() == once());
}

TEST_CASE("picture and report are written", "[program]") {
  const auto png = scratch() / "p.png", html = scratch() / "r.html";
  const Run r = run_colift("decide " + kLaptop + " --partner -0.27,-0.03,0.78 --quiet --png " + png.string() +
                           " --report " + html.string());
  CHECK(r.code == 0);
  CHECK(slurp(png).substr(1, 3) == "PNG");
  CHECK(slurp(html).find("<html") != std::string::npos);
}

TEST_CASE("what is wrong is said in one line with the place, exit code 2", "[program]") {
  const auto [arguments, words] = GENERATE(table<std::string, std::string>({
      {"", "see colift --help"},
      {"frobnicate", "\"frobnicate\" is no command"},
      {"runn", "\"runn\" is no command; did you mean \"run\"?"},
      {"log exprt x", "colift log: \"exprt\" is no command; did you mean \"export\"?"},
      {"log replay no.mcap --beside b.mcap", "no.mcap: "},
      {"hal amr state", "did you mean \"arm\"?"},
      {"hal hand", "colift hal hand: expected one of "},
      {"--verison", "\"--verison\" is no option; did you mean \"--version\"?"},
      {"run --senario pipe", "did you mean --scenario?"},
      {"run --seed=3 --dryrun", "did you mean --dry-run?"},
      {"run --scenario pip",
       "pip: there is no such file, and no scenario of that name is shipped; did you mean \"pipe\"?"},
      {"run --scenario xylophone", "\"colift scenarios\" lists those that are"},
      {"run --robot emulatd", "did you mean \"emulated\"?"},
      {"run --scenario ./pipe", "./pipe: there is no such file"},
      {"look", "CLOUD is required"},
      {"look /no/such.pcd", "/no/such.pcd: there is no such file"},
      {"look " + kReal, "directory"},
      {"look " + kCan + " --method quick", "--method"},
      {"look " + kCan + " --camera-pose 1,2,3", "--camera-pose: \"1,2,3\" has 3 numbers, 7 were expected"},
      {"look " + kCan + " --camera-pose 0,0,0,0,0,0,2", "length 2"},
      {"look " + kCan + " --at 1,2,inf", "--at"},
      {"look " + kCan + " --png /no/such/dir/x.png", "/no/such/dir"},
      {"look " + kCan + " --set ground.max_tlit_deg=3", "max_tilt_deg"},
      {"look " + kCan + " --config /no/such.yaml", "/no/such.yaml"},
      {"decide " + kCan, "--partner"},
      {"decide " + kCan + " --partner 1,2", "2 numbers"},
      {"decide " + kCan + " --partner 0,0,0.6 --share 1", "--share"},
      {"decide " + kCan + " --partner 0,0,0.6 --share 0.5 --epsilon 1", "--epsilon"},
      {"decide " + kCan + " --partner 0,0,0.6 --epsilon 0", "--epsilon"},
      {"decide " + kCan + " --partner 0,0,0.6 --share-strict 0.1", "--share-strict: needs a wanted share"},
      {"decide " + kCan + " --partner-cloud /no/such.pcd", "/no/such.pcd"},
      {"rank /no/such.json", "/no/such.json"},
      {"check --set a.b=1", "--set a.b=1"},
  }));
  const Run r = run_colift(arguments);
  INFO(arguments << "\n" << r.err);
  CHECK(r.code == 2);
  CHECK(r.err.find(words) != std::string::npos);
  CHECK(std::count(r.err.begin(), r.err.end(), '\n') == 1);
}

TEST_CASE("a page on a port that somebody else has is refused before the run, with what to do", "[program]") {
  const int taken = ::socket(AF_INET, SOCK_STREAM, 0);
  REQUIRE(taken >= 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  REQUIRE(::bind(taken, reinterpret_cast<const sockaddr*>(&address), size) == 0);
  REQUIRE(::listen(taken, 1) == 0);
  REQUIRE(::getsockname(taken, reinterpret_cast<sockaddr*>(&address), &size) == 0);
  const Run r = run_colift("run --view " + std::to_string(ntohs(address.sin_port)));
  ::close(taken);
  INFO(r.err);
  CHECK(r.code == 2);
  CHECK(r.err.find("choose another port with --view PORT") != std::string::npos);
  CHECK(r.out.empty());
}

TEST_CASE(
    "shipped scenarios, robots and frames are found by name from any folder, and a file of that name goes "
    "first",
    "[program]") {
  const auto here = std::filesystem::current_path();
  std::filesystem::create_directories(scratch() / "elsewhere");
  std::filesystem::current_path(scratch() / "elsewhere");
  const Run pipe = run_colift("run --scenario pipe --dry-run --json --quiet");
  std::ofstream("pipe") << "schema: colift.scenario/1\nobject: {kind: anvil}\n";
  const Run own = run_colift("run --scenario pipe --dry-run --json --quiet");
  const Run robot = run_colift("check --for run --robot emulated --json");
  const Run frame = run_colift("look 01_office_chair_and_bottles --json");
  const Run no_frame = run_colift("look 01_office_chair --json");
  std::filesystem::current_path(here);
  INFO(pipe.err << own.err << robot.err << frame.err << no_frame.err);
  CHECK(pipe.code == 0);
  CHECK(Json::parse(pipe.out)["scenario"].get<std::string>().find("pipe") != std::string::npos);
  CHECK(own.code == 2);
  CHECK(own.err.find("anvil") != std::string::npos);
  CHECK(robot.code == 0);
  CHECK(frame.code == 0);
  CHECK(no_frame.code == 2);
  CHECK(no_frame.err.find("did you mean \"01_office_chair_and_bottles\"?") != std::string::npos);
}

TEST_CASE("a run whose hand has no bus is denied at its start: nothing is guessed, nothing moves (row 35)",
          "[program]") {
  const auto [can, words] = GENERATE(table<std::string, std::string>({
      {"socketcan:nosuch0", "there is no interface nosuch0"},
      {"socketcan:lo", "lo is no CAN interface"},
      {"socketcan:", "is no name of an interface"},
  }));
  const auto rig = scratch() / "no_bus.yaml";
  std::ofstream(rig) << "arm: fri\nemulator: always\nfri: {address: 127.0.0.1, krc: 127.0.0.1, port: 0}\n"
                     << "hand: barrett\nbarrett: {can: \"" << can << "\"}\ncamera: simulated\n";
  const Run r = run_colift("run --robot " + rig.string() + " --json");
  INFO(can << "\n" << r.err);
  CHECK(r.code == 2);
  CHECK(r.out.empty());
  CHECK(r.err.find(words) != std::string::npos);
  CHECK(std::count(r.err.begin(), r.err.end(), '\n') == 1);
}

TEST_CASE("a run of real devices alone is refused until somebody says where the camera stands", "[program]") {
  const auto robot = [](const std::string& text) {
    const auto file = scratch() / "real.yaml";
    std::ofstream(file) << text;
    return "run --robot " + file.string() + " --dry-run --json";
  };
  const std::string arm = "arm: fri\nemulator: never\nfri: {address: 127.0.0.1, port: 49901}\n";
  const Run blind = run_colift(robot(arm + "hand: barrett\ncamera: kinect\n"));
  CHECK(blind.code == 2);
  CHECK(blind.out.empty());
  CHECK(blind.err.find("colift calibrate --robot") != std::string::npos);
  // what stands in a simulated world has no place beside a real arm
  const Run mixed = run_colift(robot(arm + "hand: barrett\ncamera: simulated\n"));
  CHECK(mixed.code == 2);
  CHECK(mixed.err.find("expected camera: kinect") != std::string::npos);
  const Run lost = run_colift(robot(arm + "hand: barrett\ncamera: kinect\ncalibration: nowhere.yaml\n"));
  CHECK(lost.code == 2);
  CHECK(lost.err.find("nowhere.yaml") != std::string::npos);
}

TEST_CASE("a rig is served for three real drivers, and once", "[program]") {
  const auto file = scratch() / "half.yaml";
  std::ofstream(file) << "arm: fri\nhand: simulated\ncamera: kinect\n";
  const Run half = run_colift("emulate rig --robot " + file.string());
  CHECK(half.code == 2);
  CHECK(half.err.find("expected arm: fri, hand: barrett") != std::string::npos);
  const Run fast = run_colift("emulate rig --speed 2");
  CHECK(fast.code == 2);
  CHECK(fast.err.find("--speed") != std::string::npos);
}

TEST_CASE("every broken file is refused in one line", "[program]") {
  int files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(std::string(COLIFT_TEST_DATA) + "/bad")) {
    if (!entry.is_regular_file() || entry.path().extension() == ".json" || entry.path().extension() == ".md")
      continue;
    const Run r = run_colift("look '" + entry.path().string() + "' --json");
    INFO(entry.path() << "\n" << r.err);
    CHECK(r.code == 2);
    CHECK(r.out.empty());
    CHECK(std::count(r.err.begin(), r.err.end(), '\n') == 1);
    ++files;
  }
  CHECK(files > 20);
}

TEST_CASE("rank answers the documented example", "[program]") {
  const auto problem = scratch() / "problem.json";
  std::ofstream(problem)
      << R"({"cog":[0,0,0],"partner":[-0.4,0,0],"candidates":[[0.4,0,0],[0.2,0,0]],"wrenches":[[0,0,40,0,0,0]],
    "weights":{"epsilon":1,"omega1":1,"omega2":1}})";
  const Run r = run_colift("rank " + problem.string() + " --json");
  CHECK(r.code == 0);
  const Json j = Json::parse(r.out);
  CHECK(j["best"] == 0);
  CHECK(j["ranking"][0]["cost"].get<double>() == Approx(800.0).epsilon(1e-9));
  CHECK(j["ranking"][0]["share"].get<double>() == Approx(0.5).epsilon(1e-9));
}

TEST_CASE("check prints a configuration that loads back", "[program]") {
  const Run first = run_colift("check --set decision.near_partner_m=0.2");
  REQUIRE(first.code == 0);
  const auto file = scratch() / "effective.yaml";
  std::ofstream(file) << first.out;
  const Run second = run_colift("check --config " + file.string() + " --json");
  INFO(second.err);
  REQUIRE(second.code == 0);
  CHECK(Json::parse(second.out)["config"].get<std::string>().find("near_partner_m: 0.2") !=
        std::string::npos);
}

TEST_CASE("--version and --help are not errors", "[program]") {
  CHECK(run_colift("--version").out.find("colift 0.") == 0);
  for (const char* help : {"--help", "look --help", "decide --help", "rank --help", "check --help"}) {
    const Run r = run_colift(help);
    CHECK(r.code == 0);
    CHECK(r.out.size() > 200);
  }
}

TEST_CASE("every command is there, whichever program has it", "[program]") {
  for (const char* command : {"run", "log", "experiment", "look", "decide", "rank", "check", "hal",
                              "calibrate", "doctor", "emulate"}) {
    const Run r = run_colift(std::string(command) + " --help");
    INFO(command << "\n" << r.err);
    CHECK(r.code == 0);
    CHECK_THAT(r.out, Catch::Contains(std::string("colift ") + command));
  }
}

TEST_CASE("a command whose program was not built yet says which and who builds it", "[program]") {
  const auto alone = scratch() / "alone";
  std::filesystem::create_directories(alone);
  const std::filesystem::path program = COLIFT_PROGRAM;
  for (const char* name : {"colift", "colift-simulate"})
    std::filesystem::copy_file(program.parent_path() / name, alone / name,
                               std::filesystem::copy_options::overwrite_existing);
  const Run r = story::run_program(alone / "colift", "log info some.mcap");
  CHECK(r.code == 4);
  CHECK_THAT(r.err, Catch::Contains("colift-log is not there yet; tools/build builds it"));
  CHECK(story::run_program(alone / "colift", "run --help").code == 0);
}

TEST_CASE("two runs are compared by their recordings", "[program]") {
  const auto file = [](const char* name) { return (scratch() / name).string(); };
  const std::string run = "run --quiet --dry-run --seed 3 --record ";
  for (const std::string& more : {file("a.mcap"), file("b.mcap") + " --set decision.near_partner_m=1.2"}) {
    const Run r = run_colift(run + more);
    INFO(r.err);
    REQUIRE(r.code <= 1);
  }
  const Run same = run_colift("log compare " + file("a.mcap") + " " + file("a.mcap"));
  INFO(same.err);
  CHECK(same.code == 0);
  CHECK_THAT(same.out, Catch::Contains("the same in everything that is compared"));

  const Run other =
      run_colift("log compare --json " + file("a.mcap") + " " + file("b.mcap") + " --out " + file("ab.html"));
  INFO(other.err);
  REQUIRE(other.code == 0);
  const Json j = Json::parse(other.out);
  CHECK(j["same"] == false);
  REQUIRE(j["config"].size() == 1);
  CHECK(j["config"][0]["key"] == "decision.near_partner_m");
  CHECK(j["config"][0]["b"] == "1.2");
  CHECK_THAT(j["a"]["because"].get<std::string>(),
             Catch::Contains("dry run: a collision-free path was found"));
  CHECK(j["decision"]["same_candidates"] == true);
  CHECK_FALSE(j["decision"]["verdicts"].empty());
  CHECK(std::filesystem::file_size(scratch() / "ab.html") > 10000);

  const Run none = run_colift("log compare " + file("a.mcap") + " nowhere.mcap");
  CHECK(none.code == 2);
  CHECK_THAT(none.err, Catch::Contains("nowhere.mcap"));
}

TEST_CASE("a file behind --view is the recording, a number is the port", "[program]") {
  for (const char* arguments : {"log replay --view nowhere.mcap", "log replay nowhere.mcap --view 0"}) {
    const Run r = run_colift(arguments);
    INFO(arguments << "\n" << r.err);
    CHECK(r.code == 2);
    CHECK_THAT(r.err, Catch::Contains("nowhere.mcap"));
    CHECK_THAT(r.err, !Catch::Contains("port"));
  }
}
