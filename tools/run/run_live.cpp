#include "tools/run/run_live.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <array>
#include <charconv>
#include <chrono>
#include <random>
#include <thread>

#include "hal/drivers/recorded/file_bytes.hpp"
#include "tools/rig/robot_file.hpp"
#include "tools/telemetry/channels/built_in_texts.hpp"

namespace colift::tools {
namespace {

constexpr auto kLook = std::chrono::milliseconds(100);

hal::Result<std::uint16_t> port_of(const std::string& text) {
  if (text.empty()) return live::ServerConfig{}.port;
  unsigned port = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), port);
  if (error != std::errc() || end != text.data() + text.size() || port > 65535)
    return hal::failure(
        hal::ErrorCode::BadInput, "--view",
        fmt::format("'{}' is no port; expected a number from 0 (any free one) to 65535", text));
  return static_cast<std::uint16_t>(port);
}

/// Empty where the system does not tell.
std::string machine_name() {
  std::array<char, 256> name{};
  return ::gethostname(name.data(), name.size() - 1) == 0 ? std::string(name.data()) : std::string();
}

/// 128 bits that nobody can guess.
std::string new_token() {
  std::random_device source;
  std::string token;
  for (int i = 0; i < 4; ++i) token += fmt::format("{:08x}", source());
  return token;
}

/// The description of the robot that a robot file names; the built-in one where it names none. Errors: of
/// both files.
hal::Result<std::string> robot_urdf(const std::optional<std::filesystem::path>& robot_file) {
  const auto robot = read_robot_file(robot_file);
  if (!robot) return tl::unexpected(robot.error());
  if (robot->model.empty()) return telemetry::built_in_robot_urdf();
  const auto bytes = hal::load_file(robot->model);
  if (!bytes) return tl::unexpected(bytes.error());
  return std::string(hal::as_text(*bytes));
}

}  // namespace

hal::Result<std::unique_ptr<RunLive>> RunLive::open(const ViewOptions& options, const std::string& title,
                                                    std::string urdf,
                                                    std::map<std::string, live::Document> documents) {
  if (!options.view) {
    if (options.allow_operator || !options.allow_origins.empty())
      return hal::failure(hal::ErrorCode::BadInput, "--allow-operator", "belongs to --view");
    return std::unique_ptr<RunLive>();
  }
  const auto port = port_of(*options.view);
  if (!port) return tl::unexpected(port.error());
  std::unique_ptr<RunLive> view(new RunLive);
  live::ServerConfig config;
  config.port = *port;
  config.address = options.view_address;
  config.name = title;
  config.door.origins = options.allow_origins;
  if (options.view_address != "127.0.0.1" && options.view_address != "::1") {
    // whoever opens it to a network calls the machine by its name there
    if (const std::string name = machine_name(); !name.empty()) {
      config.door.hosts.push_back(name);
      config.door.hosts.push_back(name + ".local");
    }
  }
  if (options.allow_operator) {
    config.door.token = new_token();
    config.on_stop = [raw = view.get()] { raw->stopped_ = true; };
    config.on_lower = [raw = view.get()] { raw->lower_confirmed_ = true; };
    config.on_continue = [raw = view.get()] { raw->continue_confirmed_ = true; };
  }
  live::PageFiles files(live::PageFiles::beside_program());
  documents["/robot.urdf"] = {"application/xml", std::move(urdf)};
  for (auto& [path, document] : documents) files.add(path, std::move(document));
  auto server = live::LiveServer::open(config, std::move(files));
  if (!server) return tl::unexpected(server.error());
  view->server_ = std::move(*server);
  return view;
}

void RunLive::stay(const std::function<bool()>& enough) const {
  while (!enough()) std::this_thread::sleep_for(kLook);
}

hal::Result<std::unique_ptr<LiveView>> open_view(const RunOptions& options, const std::string& title) {
  auto urdf = robot_urdf(options.robot);
  if (!urdf) return tl::unexpected(urdf.error());
  return RunLive::open(options.live, title, std::move(*urdf));
}

}  // namespace colift::tools
