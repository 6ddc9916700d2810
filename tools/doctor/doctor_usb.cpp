#include <fmt/format.h>
#include <unistd.h>

#include "tools/doctor/doctor_row.hpp"

namespace colift::tools {
namespace {

namespace fs = std::filesystem;
using Verdict = DoctorRow::Verdict;

struct UsbDevice {
  std::string name, product;  ///< "1-2", "02ae".
  fs::path folder, node;
  long long speed = 0;
};

std::vector<UsbDevice> devices_of(const fs::path& root, const std::string& vendor) {
  std::vector<UsbDevice> found;
  const fs::path usb = root / "sys/bus/usb/devices";
  for (const std::string& name : names_in(usb)) {
    if (read_small(usb / name / "idVendor").value_or("") != vendor) continue;
    UsbDevice d{name, read_small(usb / name / "idProduct").value_or(""), usb / name, {}, 0};
    d.node = root / fmt::format("dev/bus/usb/{:03}/{:03}", read_number(d.folder / "busnum").value_or(0),
                                read_number(d.folder / "devnum").value_or(0));
    d.speed = read_number(d.folder / "speed").value_or(0);
    found.push_back(std::move(d));
  }
  return found;
}

/// The kernel's driver that holds one of the device's interfaces; empty when none does.
std::string driver_of(const fs::path& root, const UsbDevice& device) {
  const fs::path usb = root / "sys/bus/usb/devices";
  for (const std::string& name : names_in(usb)) {
    if (name.rfind(device.name + ":", 0) != 0) continue;
    std::error_code error;
    const fs::path driver = fs::read_symlink(usb / name / "driver", error);
    if (!error) return driver.filename().string();
  }
  return "";
}

void look_at_camera(const fs::path& root, const UsbDevice& camera, DoctorRows& rows) {
  const bool windows = camera.product == "02bf";
  rows.push_back({"Kinect", fmt::format("{} camera at USB {}, {} Mbit/s",
                                        windows ? "Kinect for Windows" : "Kinect for Xbox 360", camera.name,
                                        camera.speed)});
  if (camera.speed != 0 && camera.speed < 480) {
    rows.back().verdict = Verdict::Bad;
    rows.back().found += ": it needs 480";
    rows.back().repair =
        "plug it into a USB 2 or 3 port of the machine itself, no hub, alone on its controller";
  }
  const std::string node = fmt::format("/{}", camera.node.lexically_relative(root).string());
  std::error_code none;
  if (!fs::exists(camera.node, none))
    rows.push_back({"Kinect's device node", fmt::format("{} is not there", node), Verdict::Bad,
                    "sudo udevadm trigger    # in a container: hand /dev/bus/usb in"});
  else if (::access(camera.node.c_str(), R_OK | W_OK) != 0)
    rows.push_back(
        {"Kinect's device node", fmt::format("{} may not be opened by this user", node), Verdict::Bad,
         windows
             ? "echo 'SUBSYSTEM==\"usb\", ATTR{idVendor}==\"045e\", ATTR{idProduct}==\"02bf\", "
               "MODE=\"0666\"' | "
               "sudo tee /etc/udev/rules.d/60-kinect.rules; sudo udevadm control --reload; plug it in anew"
             : "sudo apt install libfreenect0.5    # its udev rules; then plug the Kinect in anew"});
  else
    rows.push_back({"Kinect's device node", fmt::format("{} may be opened", node)});
  const std::string driver = driver_of(root, camera);
  if (driver == "kinect" || driver == "gspca_kinect")
    rows.push_back(
        {"webcam driver", "gspca_kinect holds the camera: two may fight for it", Verdict::Warn,
         "echo 'blacklist gspca_kinect' | sudo tee /etc/modprobe.d/colift-kinect.conf; sudo modprobe -r "
         "gspca_kinect"});
}

}  // namespace

DoctorRows usb_rows(const fs::path& root) {
  DoctorRows rows;
  std::error_code none;
  if (!fs::is_directory(root / "sys/bus/usb/devices", none))
    return {
        {"USB", "this machine has none", Verdict::Warn, "a machine with a USB 2 or 3 port for the Kinect"}};
  bool motor = false;
  int cameras = 0;
  for (const UsbDevice& d : devices_of(root, "045e")) {
    motor = motor || d.product == "02b0";
    if (d.product != "02ae" && d.product != "02bf") continue;
    ++cameras;
    look_at_camera(root, d, rows);
  }
  if (cameras > 0) return rows;
  if (motor)
    return {{"Kinect", "its motor answers, its camera does not: the 12 V supply is missing", Verdict::Bad,
             "plug in the Kinect's power supply"}};
  return {{"Kinect", "no camera 045e:02ae on USB", Verdict::Warn,
           "plug it into a USB port of the machine and into its power supply; lsusb -d 045e:"}};
}

}  // namespace colift::tools
