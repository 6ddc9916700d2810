// The job with all that it can have.

#include "tools/programs/run_program.hpp"
#include "tools/run/run_parts.hpp"

namespace colift::tools {

void add_whole_job(CommandLine& line) {
  add_job_commands(line, all_run_parts());
}

}  // namespace colift::tools
