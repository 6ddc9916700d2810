// Options of recordings.

#include "tools/log/cmd_log.hpp"
#include "tools/programs/command_line.hpp"

namespace colift::tools {
namespace {

/// A verb of `log`, with what all of them take.
CLI::App& add_log_verb(CLI::App& log, const char* name, const char* help, LogOptions& o,
                       const char* file_help) {
  CLI::App* verb = log.add_subcommand(name, help);
  verb->callback([&o, name] { o.verb = name; });
  verb->add_option("FILE", o.file, file_help)->required();
  return *verb;
}

void add_log(CommandLine& line, CLI::App& log, LogOptions& o) {
  constexpr const char* kRecording = "Recording (MCAP); a truncated one is read up to its end";
  log.require_subcommand(1);
  line.add_output(add_log_verb(log, "info", "Prints a summary", o, kRecording));
  CLI::App& compared =
      add_log_verb(log, "compare", "Compares two runs: settings, states, decisions, figures, curves", o,
                   "Recording of run A (MCAP)");
  compared.add_option("OTHER", o.other, "Recording of run B (MCAP)")->required();
  compared.add_option("--out", o.out, "Page with tables and curves of both runs (HTML)")->type_name("FILE");
  line.add_output(compared);
  CLI::App& exported = add_log_verb(log, "export", "Exports tables or images", o, kRecording);
  exported.add_option("--out", o.out, "Folder (default: FILE-export)")->type_name("FOLDER");
  exported
      .add_option("--format", o.formats,
                  "csv (default): a table for each channel; png: depth images and camera.json; fakenect: for "
                  "libfreenect's player; ros2: a bag of ROS 2; may be given several times")
      ->type_name("FORMAT")
      ->take_all()
      ->allow_extra_args(false);
  line.add_output(exported);
  CLI::App& recovered =
      add_log_verb(log, "recover", "Repairs a truncated or damaged recording", o, kRecording);
  recovered.add_option("--out", o.out, "The new file (default: FILE.recovered.mcap)")->type_name("FILE");
  line.add_output(recovered);
  CLI::App& replayed = add_log_verb(log, "replay",
                                    "Runs the task again on the recorded inputs and compares; --config and "
                                    "--set override the configuration",
                                    o, kRecording);
  add_view(replayed, o.live);
  replayed
      .add_option("--beside", o.beside,
                  "Another recording, played side by side with this one on the page (both.html)")
      ->type_name("FILE");
  line.add_common(replayed);
  CLI::App& snapshot = add_log_verb(log, "snapshot", "Requests the flight recording of a running colift run",
                                    o, "Output file");
  snapshot.add_option("--pid", o.pid, "Process id of the run (default: the newest of this user)")
      ->type_name("PID");
  line.add_output(snapshot);
}

}  // namespace

void add_log_commands(CommandLine& line) {
  CommonOptions& common = line.common;
  CLI::App& log_command = line.command("log");
  const auto log = std::make_shared<LogOptions>();
  add_log(line, log_command, *log);
  line.when(log_command, [&common, log] { return cmd_log(common, *log); });
  line.configured(*log_command.get_subcommand("replay"),
                  {[&common, log] { return config_of_replay(common, *log); }});
}

}  // namespace colift::tools
