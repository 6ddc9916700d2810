#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include "hal/config/effective_yaml.hpp"
#include "hal/config/field_table.hpp"
#include "hal/config/yaml_tree.hpp"
#include "hal/types/result.hpp"

namespace colift::hal {

// A configuration is a struct with defaults, then files in the order given, then settings in the order given;
// the later one wins, field by field (a list is replaced as a whole). A file or setting that is refused
// changes nothing.
//
//   AppConfig config;
//   FieldTable table = table_of(config);
//   if (auto done = apply_command_line(table, files, settings); !done) return done;
//   fmt::print("{}", effective_yaml(table, /*with_help=*/true));
//
// Every error is BadConfig; `where` is "FILE:LINE:COLUMN", "FILE", or "--set TEXT", `detail` one sentence
// that says what was found, what was expected and, for an unknown key, the nearest known name. An old name of
// an entry is accepted; FieldTable::warnings says which, and the caller shows it.

/// The bytes of a file, at most one more than kMaxYamlBytes, so that parse_yaml() can refuse it.
[[nodiscard]] Result<std::string> read_yaml_file(const std::filesystem::path& path);

/// Reads a YAML file into the struct behind the table. An empty file is fine.
[[nodiscard]] Result<> apply_yaml_file(FieldTable& table, const std::filesystem::path& path);

/// The same for a text in memory; `name` stands for the file's name in messages and origins.
/// Keys that the table does not know are refused, or left out with a warning in the table (for texts that
/// another version of the program wrote).
[[nodiscard]] Result<> apply_yaml_text(FieldTable& table, std::string_view text, const std::string& name,
                                       UnknownKeys unknown = UnknownKeys::Refused);

/// The same for a document that was parsed and prepared by the caller.
[[nodiscard]] Result<> apply_yaml_tree(FieldTable& table, const YamlTree& tree, const std::string& name,
                                       UnknownKeys unknown = UnknownKeys::Refused);

/// One value for `path`, written as after the "=" of a setting, for options of a command line that stand for
/// an entry. `where` is that of an error ("--share 2"), `origin` what the field says afterwards ("--share").
[[nodiscard]] Result<> apply_value(FieldTable& table, const std::string& path, std::string_view value,
                                   const std::string& where, const std::string& origin);

/// One "a.b=c" from a command line; c as in YAML, except that a text field takes it as it stands unless it is
/// quoted. "parts[1].mass=2" changes an element that a list of structs already has.
[[nodiscard]] Result<> apply_setting(FieldTable& table, std::string_view setting);

/// That every value is within its range, whoever wrote it, and that everything required was given.
/// `name` is `where` of the error.
[[nodiscard]] Result<> check_fields(const FieldTable& table, const std::string& name = "configuration");

/// Every `--config` in its order, then every `--set` in its order, then check_fields().
[[nodiscard]] Result<> apply_command_line(FieldTable& table, std::span<const std::string> files,
                                          std::span<const std::string> settings);

/// A struct from one YAML file, for files that stand for themselves (a hand, a scenario).
template <class T>
[[nodiscard]] Result<T> load_yaml(const std::filesystem::path& path) {
  T config{};
  FieldTable table = table_of(config);
  if (auto done = apply_yaml_file(table, path); !done) return tl::unexpected(done.error());
  if (auto done = check_fields(table, path.string()); !done) return tl::unexpected(done.error());
  return config;
}

}  // namespace colift::hal
