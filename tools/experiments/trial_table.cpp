#include "tools/experiments/trial_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <sstream>

namespace colift::experiments {
namespace {

using hal::ErrorCode;

std::string quoted(const std::string& text) {
  if (text.find_first_of(",\"\n\r") == std::string::npos) return text;
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"') out += '"';
    out += c;
  }
  return out + '"';
}

// One record from `at` on; false at the end, and for a record without its line end (cut off while written).
bool next_record(const std::string& text, std::size_t& at, Row& row) {
  row.assign(1, "");
  bool inside = false;
  while (at < text.size()) {
    const char c = text[at++];
    if (inside) {
      if (c != '"') {
        row.back() += c;
      } else if (at < text.size() && text[at] == '"') {
        row.back() += text[at++];
      } else {
        inside = false;
      }
    } else if (c == '"') {
      inside = true;
    } else if (c == ',') {
      row.emplace_back();
    } else if (c == '\n') {
      return true;
    } else if (c != '\r') {
      row.back() += c;
    }
  }
  return false;
}

const std::string kNothing;

}  // namespace

std::string cell(double value) {
  return std::isnan(value) ? "" : fmt::format("{:.9g}", value);
}
std::string cell(int value) {
  return std::to_string(value);
}
std::string cell(bool value) {
  return value ? "1" : "0";
}

TrialTable::TrialTable(std::string header, std::vector<std::string> columns)
    : header_(std::move(header)), columns_(std::move(columns)) {
  for (std::size_t i = 0; i < columns_.size(); ++i) index_[columns_[i]] = i;
}

hal::Result<TrialTable> TrialTable::read(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in) return hal::failure(ErrorCode::BadInput, file.string(), "cannot be read");
  std::stringstream all;
  all << in.rdbuf();
  const std::string text = all.str();
  const std::size_t end = text.find('\n');
  if (!text.starts_with("# colift.experiment/") || end == std::string::npos)
    return hal::failure(ErrorCode::BadInput, file.string() + ":1",
                        "is no table of an experiment; expected \"# colift.experiment/1 NAME ...\"");
  std::size_t at = end + 1;
  Row row;
  if (!next_record(text, at, row))
    return hal::failure(ErrorCode::BadInput, file.string() + ":2", "the names of the columns are missing");
  TrialTable table(text.substr(0, end), row);
  for (int number = 3; next_record(text, at, row); ++number) {
    int trial = -1;
    const std::string& first = row.front();
    const auto [stop, error] = std::from_chars(first.data(), first.data() + first.size(), trial);
    const bool good = error == std::errc() && stop == first.data() + first.size() && trial >= 0;
    if (row.size() != table.columns_.size() || !good)
      return hal::failure(
          ErrorCode::BadInput, fmt::format("{}:{}", file.string(), number),
          fmt::format("has {} cells and begins with \"{}\", expected {} cells and the number of a trial",
                      row.size(), first.substr(0, 20), table.columns_.size()));
    table.rows_.push_back(row);
  }
  return table;
}

std::string TrialTable::line(const Row& row) {
  std::string out;
  for (std::size_t i = 0; i < row.size(); ++i) {
    if (i) out += ',';
    out += quoted(row[i]);
  }
  return out + '\n';
}

std::string TrialTable::head() const {
  return header_ + '\n' + line(columns_);
}

std::string TrialTable::text() const {
  std::string out = head();
  for (const Row& row : rows_) out += line(row);
  return out;
}

void TrialTable::erase_if_trial(const std::function<bool(int)>& drop) {
  std::erase_if(rows_, [&](const Row& row) { return drop(trial_of(row)); });
}

void TrialTable::sort() {
  std::stable_sort(rows_.begin(), rows_.end(),
                   [](const Row& a, const Row& b) { return trial_of(a) < trial_of(b); });
}

const std::string& TrialTable::text(const Row& row, const std::string& column) const {
  const auto found = index_.find(column);
  return found == index_.end() || found->second >= row.size() ? kNothing : row[found->second];
}

double TrialTable::number(const Row& row, const std::string& column) const {
  const std::string& t = text(row, column);
  double value = NAN;
  const auto [stop, error] = std::from_chars(t.data(), t.data() + t.size(), value);
  return error == std::errc() && stop == t.data() + t.size() ? value : NAN;
}

std::vector<double> TrialTable::numbers(const std::string& column) const {
  std::vector<double> all;
  all.reserve(rows_.size());
  for (const Row& row : rows_) all.push_back(number(row, column));
  return all;
}

int TrialTable::trial_of(const Row& row) {
  return row.empty() ? -1 : std::atoi(row.front().c_str());
}

}  // namespace colift::experiments
