#pragma once

namespace colift::tools {

class CommandLine;
struct RunParts;

// What a main() needs, without the parser's headers.

/// `run` in simulation; and with all its parts.
void add_job_commands(CommandLine& line, const RunParts& parts);
void add_simulated_job(CommandLine& line);    ///< run, and the names of the commands that other programs have
void add_whole_job(CommandLine& line);        ///< run
void add_sight_commands(CommandLine& line);   ///< look, decide, rank, check
void add_device_commands(CommandLine& line);  ///< hal, calibrate, doctor
void add_emulate_commands(CommandLine& line);     ///< emulate
void add_log_commands(CommandLine& line);         ///< log
void add_experiment_commands(CommandLine& line);  ///< experiment
void add_ros2_commands(CommandLine& line);        ///< ros2

/// A program with these commands. What its main() returns.
[[nodiscard]] int run_program(int argc, char** argv, void (*add_commands)(CommandLine& line));

}  // namespace colift::tools
