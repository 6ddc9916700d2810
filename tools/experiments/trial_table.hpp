#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "hal/types/result.hpp"

namespace colift::experiments {

/// One line of results: a text per column.
using Row = std::vector<std::string>;

/// A number as it stands in a table; NaN is an empty cell. Nine digits: what is computed from a table that
/// was read is the same as what is computed from one that was just written.
[[nodiscard]] std::string cell(double value);
[[nodiscard]] std::string cell(int value);
[[nodiscard]] std::string cell(bool value);  ///< 1 or 0.

/// Rows under names, as one CSV file (RFC 4180) after a first line that says what it belongs to:
/// "# colift.experiment/1 tilt seed=1 ...". Rows of the same first column (the trial) stay together.
class TrialTable {
 public:
  TrialTable() = default;
  TrialTable(std::string header, std::vector<std::string> columns);

  /// Reads a table. A last line that was cut off is dropped. Errors: BadInput with file and line (not such a
  /// table, a row of another length).
  [[nodiscard]] static hal::Result<TrialTable> read(const std::filesystem::path& file);
  [[nodiscard]] std::string text() const;
  /// One row as it stands in the file.
  [[nodiscard]] static std::string line(const Row& row);
  [[nodiscard]] std::string head() const;  ///< The first two lines.

  [[nodiscard]] const std::string& header() const { return header_; }
  [[nodiscard]] const std::vector<std::string>& columns() const { return columns_; }
  [[nodiscard]] const std::vector<Row>& rows() const { return rows_; }
  void add(Row row) { rows_.push_back(std::move(row)); }
  void erase_if_trial(const std::function<bool(int)>& drop);
  /// By trial, then as added.
  void sort();

  /// A cell by its column's name; "" for a column that is not there.
  [[nodiscard]] const std::string& text(const Row& row, const std::string& column) const;
  [[nodiscard]] double number(const Row& row, const std::string& column) const;  ///< NaN where empty.
  /// All numbers of a column, NaN where empty.
  [[nodiscard]] std::vector<double> numbers(const std::string& column) const;
  [[nodiscard]] static int trial_of(const Row& row);

 private:
  std::string header_;
  std::vector<std::string> columns_;
  std::map<std::string, std::size_t> index_;
  std::vector<Row> rows_;
};

}  // namespace colift::experiments
