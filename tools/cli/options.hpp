#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace colift::tools {

/// Exit codes of the program (what scripts rely on).
enum Exit : int {
  kDone = 0,
  kNoGoal = 1,
  kBadInput = 2,
  kDeviceFailed = 3,
  kInternal = 4,
  kInterrupted = 130
};

/// What every command takes.
struct CommonOptions {
  std::vector<std::string> config_files;
  std::vector<std::string> settings;
  bool json = false;
  bool quiet = false;
  std::string command;  ///< The whole command line, for the report.
};

/// What `look` and `decide` take. Texts are as typed; they are parsed where they are used, with their
/// option's name.
struct LookOptions {
  std::filesystem::path cloud;
  std::string method;       ///< Empty: as configured.
  std::string camera_pose;  ///< "X,Y,Z,QX,QY,QZ,QW"; empty: unknown.
  std::string at;           ///< "X,Y,Z"; empty: the largest object.
  std::string support;      ///< "floor", "table" or "auto"; empty: as configured.
  std::optional<std::filesystem::path> camera;
  std::optional<std::filesystem::path> png;
  std::optional<std::filesystem::path> report;
};

struct DecideOptions {
  LookOptions look;
  std::string partner;  ///< "X,Y,Z"; empty: seen in the second frame.
  std::optional<std::filesystem::path> partner_cloud;
  std::string share;         ///< Part of the load for the robot; empty: by epsilon.
  std::string share_strict;  ///< Max deviation from it; empty: as configured.
  std::string epsilon;       ///< Empty: as configured.
  std::optional<int> why;    ///< Id of a candidate to explain.
};

struct CheckOptions {
  std::string command;  ///< Whose configuration is shown, "log replay".
  bool explain = false;
  bool graph = false;  ///< The rules of the job instead of the configuration.
};

/// The live view, where a command has one.
struct ViewOptions {
  std::optional<std::string> view;  ///< Port; empty: the usual one.
  std::string view_address = "127.0.0.1";
  bool allow_operator = false;             ///< Who has the token may stop the run.
  std::vector<std::string> allow_origins;  ///< Pages from elsewhere that may connect.
  std::optional<double> speed;             ///< Of a simulated run; 0: as fast as it goes.
};

/// Publishing to ROS 2.
struct Ros2Options {
  bool on = false;
  std::optional<int> domain;             ///< Unset: ROS_DOMAIN_ID, else 0.
  std::optional<std::string> interface;  ///< Unset: loopback.
};

struct RunOptions {
  Ros2Options ros2;
  ViewOptions live;
  std::optional<std::filesystem::path> scenario;  ///< Unset: the built-in table.
  std::optional<std::filesystem::path> robot;     ///< Unset: the simulated rig.
  std::optional<std::filesystem::path> rig;       ///< Unset: ideal sensors; "imperfect" or a file.
  std::string method;
  std::string share;
  std::string share_strict;
  std::uint64_t seed = 1;
  bool dry_run = false;
  bool recover = false;  ///< A stopped run is recovered at once; in simulation.
  std::optional<std::filesystem::path> report;
  std::optional<std::filesystem::path> png;     ///< Picture of the lift.
  std::optional<std::filesystem::path> record;  ///< The whole run (MCAP).
  std::optional<std::filesystem::path> flight;  ///< Its last seconds, when something went wrong.
};

}  // namespace colift::tools
