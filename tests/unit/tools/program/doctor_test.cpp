// The doctor on machines that are only folders: each finding has its verdict and a line that repairs it.
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>

#include "tests/support/temporary_folder.hpp"
#include "tools/doctor/doctor_can.hpp"
#include "tools/doctor/doctor_row.hpp"

namespace colift {
using namespace tools;
namespace {

namespace fs = std::filesystem;
using tools::DoctorRow;
using tools::DoctorRows;
using Verdict = DoctorRow::Verdict;

/// A folder that is a machine, gone at the end.
struct FakeMachine {
  tests::TemporaryFolder folder;
  const fs::path& root = folder.path();

  void file(const std::string& path, const std::string& text) const { folder.write(path, text); }
  void good() const {
    file("proc/sys/kernel/osrelease", "6.1.0-18-rt-amd64\n");
    file("proc/version", "Linux version 6.1.0-18-rt-amd64 SMP PREEMPT_RT\n");
    file("sys/kernel/realtime", "1\n");
    file("proc/self/status", "Name:\tcolift\nCapEff:\t0000000000000000\n");
    file("sys/devices/system/cpu/online", "0-3\n");
    for (const char* cpu : {"cpu0", "cpu1", "cpu2", "cpu3"})
      file(std::string("sys/devices/system/cpu/") + cpu + "/cpufreq/scaling_governor", "performance\n");
    file("sys/devices/system/clocksource/clocksource0/current_clocksource", "tsc\n");
  }
};

const DoctorRow& row(const DoctorRows& rows, const std::string& what) {
  for (const DoctorRow& r : rows)
    if (r.what == what) return r;
  FAIL("no row on " << what);
  return rows.front();
}

bool has(const DoctorRows& rows, const std::string& what) {
  for (const DoctorRow& r : rows)
    if (r.what == what) return true;
  return false;
}

constexpr unsigned long long kGiB = 1024ull * 1024 * 1024;
const tools::DiskSpace kDisk{"/home/robot", 50 * kGiB};

hal::CanLink good_can() {
  hal::CanLink link;
  link.index = 3;
  link.is_can = link.up = link.running = true;
  link.kind = "can";
  link.state = hal::CanHealth::State::Active;
  link.bitrate = 1'000'000;
  link.sample_point = 0.75;
  link.restart_ms = 100;
  link.send_errors = link.receive_errors = 0;
  return link;
}

DoctorRow can_row(const FakeMachine& m, const hal::CanLink& link) {
  m.file("sys/class/net/can0/type", "280\n");
  return row(can_rows(m.root, "socketcan:can0", [&](const std::string&) { return link; }), "CAN can0");
}

void kinect(const FakeMachine& m, const std::string& product, const std::string& speed) {
  m.file("sys/bus/usb/devices/1-2/idVendor", "045e\n");
  m.file("sys/bus/usb/devices/1-2/idProduct", product + "\n");
  m.file("sys/bus/usb/devices/1-2/busnum", "1\n");
  m.file("sys/bus/usb/devices/1-2/devnum", "7\n");
  m.file("sys/bus/usb/devices/1-2/speed", speed + "\n");
}

}  // namespace

TEST_CASE("a machine made for it has nothing to repair", "[doctor]") {
  FakeMachine m;
  m.good();
  for (const DoctorRow& r : machine_rows(m.root, {95ull, std::nullopt}, kDisk)) {
    INFO(r.what << ": " << r.found);
    CHECK(r.verdict == Verdict::Ok);
    CHECK(r.repair.empty());
  }
}

TEST_CASE("an ordinary desktop is told what to change, and nothing is bad", "[doctor]") {
  FakeMachine m;
  m.good();
  fs::remove(m.root / "sys/kernel/realtime");
  m.file("proc/version", "Linux version 6.1.0-18-amd64 SMP PREEMPT_DYNAMIC\n");
  m.file("sys/devices/system/cpu/online", "0\n");
  m.file("sys/devices/system/cpu/cpu2/cpufreq/scaling_governor", "powersave\n");
  m.file("sys/devices/system/clocksource/clocksource0/current_clocksource", "hpet\n");
  m.file("sys/devices/system/clocksource/clocksource0/available_clocksource", "hpet tsc\n");
  const auto rows = machine_rows(m.root, {0ull, 8ull << 20}, {"/home/robot", kGiB});
  for (const char* what : {"kernel", "real-time priority", "locked memory", "processors", "governor",
                           "clock source", "disk space"}) {
    INFO(what << ": " << row(rows, what).found);
    CHECK(row(rows, what).verdict == Verdict::Warn);
    CHECK_FALSE(row(rows, what).repair.empty());
  }
  CHECK(row(rows, "kernel").repair.find("linux-image-rt-amd64") != std::string::npos);
  CHECK(row(rows, "clock source").repair.find("echo tsc") != std::string::npos);
}

TEST_CASE("capabilities are worth as much as limits", "[doctor]") {
  FakeMachine m;
  m.good();
  m.file("proc/self/status", "Name:\tcolift\nCapEff:\t000001ffffffffff\n");
  const auto rows = machine_rows(m.root, {0ull, 65536ull}, kDisk);
  CHECK(row(rows, "real-time priority").verdict == Verdict::Ok);
  CHECK(row(rows, "locked memory").verdict == Verdict::Ok);
}

TEST_CASE("a full disk is bad", "[doctor]") {
  FakeMachine m;
  m.good();
  CHECK(row(machine_rows(m.root, {}, {"/home/robot", 10ull << 20}), "disk space").verdict == Verdict::Bad);
}

TEST_CASE("an empty machine gives findings and no crash", "[doctor]") {
  FakeMachine m;
  CHECK(machine_rows(m.root, {}, kDisk).size() == 7);
  CHECK_FALSE(network_rows(m.root, 49938).empty());
  CHECK_FALSE(usb_rows(m.root).empty());
  CHECK_FALSE(can_rows(m.root, "socketcan:can0", [](const std::string&) { return hal::CanLink{}; }).empty());
}

TEST_CASE("files full of rubbish are findings too", "[doctor]") {
  FakeMachine m;
  const std::string rubbish("\xff\xfe:,-\n\0 zz:zzzz ::\n9999999999999999999999", 40);
  for (const char* path : {"proc/net/udp", "proc/net/route", "proc/self/status", "sys/kernel/realtime",
                           "sys/devices/system/cpu/online", "sys/class/net/x/type", "proc/modules",
                           "sys/bus/usb/devices/1-1/idVendor", "proc/sys/net/core/rmem_default"})
    m.file(path, rubbish);
  CHECK(machine_rows(m.root, {}, kDisk).size() == 7);
  CHECK_FALSE(network_rows(m.root, 49938).empty());
  CHECK_FALSE(usb_rows(m.root).empty());
  CHECK_FALSE(can_rows(m.root, "socketcan:can0", [](const std::string&) { return hal::CanLink{}; }).empty());
}

TEST_CASE("a port in use is bad, and its neighbour is not", "[doctor]") {
  FakeMachine m;
  m.file("proc/net/udp",
         "   sl  local_address rem_address   st tx_queue rx_queue tr tm->when retrnsmt   uid  timeout inode\n"
         "  277: 0100007F:C312 00000000:0000 07 00000000:00000000 00:00000000 00000000     0        0 4711 2 "
         "0 0\n");
  CHECK(row(network_rows(m.root, 49938), "UDP port 49938").verdict == Verdict::Bad);
  CHECK(row(network_rows(m.root, 49939), "UDP port 49939").verdict == Verdict::Ok);
}

TEST_CASE("a wired card of its own is what the KRC wants", "[doctor]") {
  FakeMachine m;
  const auto card = [&](const std::string& name, bool link) {
    m.file("sys/class/net/" + name + "/type", "1\n");
    m.file("sys/class/net/" + name + "/device/vendor", "0x8086\n");
    m.file("sys/class/net/" + name + "/carrier", link ? "1\n" : "0\n");
    m.file("sys/class/net/" + name + "/operstate", link ? "up\n" : "down\n");
    m.file("sys/class/net/" + name + "/speed", "1000\n");
  };
  m.file("sys/class/net/lo/type", "772\n");
  CHECK(row(network_rows(m.root, 49938), "network card").verdict == Verdict::Warn);
  card("eth0", true);
  m.file("proc/net/route", "Iface\tDestination\tGateway\neth0\t00000000\t0101A8C0\n");
  CHECK(row(network_rows(m.root, 49938), "network for the KRC").verdict == Verdict::Warn);
  card("eth1", false);
  CHECK(row(network_rows(m.root, 49938), "network for the KRC").verdict == Verdict::Warn);
  card("eth1", true);
  CHECK_FALSE(has(network_rows(m.root, 49938), "network for the KRC"));
  CHECK(row(network_rows(m.root, 49938), "network card eth1").verdict == Verdict::Ok);
}

TEST_CASE("no CAN interface is a warning with the lines that make one", "[doctor]") {
  FakeMachine m;
  m.file("sys/class/net/eth0/type", "1\n");
  const auto rows = can_rows(m.root, "socketcan:can0", [](const std::string&) { return hal::CanLink{}; });
  CHECK(row(rows, "CAN").verdict == Verdict::Warn);
  CHECK(row(rows, "CAN").found == "no CAN interface");
  CHECK(row(rows, "CAN")
            .repair.find("ip link set can0 up type can bitrate 1000000 sample-point 0.75 restart-ms 100") !=
        std::string::npos);
}

TEST_CASE("a CAN link is judged by what its controller tells", "[doctor]") {
  FakeMachine m;
  CHECK(can_row(m, good_can()).verdict == Verdict::Ok);

  hal::CanLink link = good_can();
  link.up = false;
  CHECK(can_row(m, link).verdict == Verdict::Bad);

  link = good_can();
  link.bitrate = 500'000;
  CHECK(can_row(m, link).verdict == Verdict::Bad);
  CHECK(can_row(m, link).repair.find("down; sudo ip link set can0 up") != std::string::npos);

  link = good_can();
  link.state = hal::CanHealth::State::BusOff;
  CHECK(can_row(m, link).verdict == Verdict::Bad);

  link = good_can();
  link.send_errors = 128;
  CHECK(can_row(m, link).verdict == Verdict::Warn);

  link = good_can();
  link.restart_ms = 0;
  CHECK(can_row(m, link).verdict == Verdict::Warn);

  link = {};
  link.index = 5;
  link.is_can = link.up = link.running = true;
  link.kind = "vcan";
  CHECK(can_row(m, link).verdict == Verdict::Ok);
}

TEST_CASE("another interface than the hand's is named; a gateway needs none", "[doctor]") {
  FakeMachine m;
  m.file("sys/class/net/can3/type", "280\n");
  const auto ask = [](const std::string&) { return good_can(); };
  CHECK(row(can_rows(m.root, "socketcan:can0", ask), "hand's bus").verdict == Verdict::Bad);
  CHECK(row(can_rows(m.root, "socketcand:10.0.0.2:29536/can0", ask), "hand's bus").verdict == Verdict::Ok);
}

TEST_CASE("a Kinect with its driver free is fine", "[doctor]") {
  FakeMachine m;
  kinect(m, "02ae", "480");
  m.file("dev/bus/usb/001/007", "");
  const auto rows = usb_rows(m.root);
  CHECK(row(rows, "Kinect").verdict == Verdict::Ok);
  CHECK(row(rows, "Kinect's device node").verdict == Verdict::Ok);
  CHECK_FALSE(has(rows, "webcam driver"));
}

TEST_CASE("what keeps a Kinect from working has its repair", "[doctor]") {
  FakeMachine m;
  CHECK(usb_rows(m.root).front().verdict == Verdict::Warn);
  fs::create_directories(m.root / "sys/bus/usb/devices");
  CHECK(row(usb_rows(m.root), "Kinect").verdict == Verdict::Warn);

  kinect(m, "02b0", "12");  // the motor alone: no 12 V
  CHECK(row(usb_rows(m.root), "Kinect").verdict == Verdict::Bad);

  kinect(m, "02ae", "12");
  CHECK(row(usb_rows(m.root), "Kinect").verdict == Verdict::Bad);
  CHECK(row(usb_rows(m.root), "Kinect's device node").verdict == Verdict::Bad);

  m.file("dev/bus/usb/001/007", "");
  fs::create_directories(m.root / "sys/bus/usb/devices/1-2:1.0");
  fs::create_directory_symlink("../../../bus/usb/drivers/kinect",
                               m.root / "sys/bus/usb/devices/1-2:1.0/driver");
  CHECK(row(usb_rows(m.root), "webcam driver").verdict == Verdict::Warn);
  CHECK(row(usb_rows(m.root), "webcam driver").repair.find("blacklist gspca_kinect") != std::string::npos);
}

TEST_CASE("a video device: there, a device, one of the kernel's video devices", "[doctor]") {
  const FakeMachine m;
  const auto found = [&](const char* device) { return row(video_rows(m.root, device), "video device"); };
  CHECK(found("/dev/video0").verdict == Verdict::Bad);
  CHECK_THAT(found("/dev/video0").repair, Catch::Contains("v4l2-ctl --list-devices"));
  m.file("dev/video0", "");
  CHECK_THAT(found("/dev/video0").found, Catch::Contains("is no device"));
  // a link by id to a node that everybody may open
  fs::create_directories(m.root / "dev/v4l/by-id");
  fs::create_symlink("/dev/null", m.root / "dev/v4l/by-id/camera");
  CHECK_THAT(found("/dev/v4l/by-id/camera").found, Catch::Contains("is no video device"));
  m.file("sys/class/video4linux/null/name", "Depth camera\n");
  CHECK(found("/dev/v4l/by-id/camera").verdict == Verdict::Ok);
  CHECK_THAT(found("/dev/v4l/by-id/camera").found, Catch::Contains("Depth camera"));
}

}  // namespace colift
