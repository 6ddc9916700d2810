#include <fmt/format.h>

#include <fstream>
#include <map>
#include <set>
#include <utility>

#include "tools/telemetry/channels/json_parts.hpp"
#include "tools/telemetry/replay/export.hpp"
#include "tools/telemetry/replay/export_files.hpp"

namespace colift::telemetry {
namespace {

constexpr std::size_t kMostInList = 16;
constexpr std::size_t kMostColumns = 400;
constexpr std::size_t kLongestText = 1000;  // longer ones are data

using Row = std::map<std::string, std::string>;

/// A text as a cell (RFC 4180).
std::string quoted(const std::string& text) {
  std::string cell = "\"";
  for (const char c : text) {
    if (c == '"') cell += '"';
    cell += c;
  }
  return cell + '"';
}

void flatten(const Json& j, const std::string& path, Row& row) {
  const auto below = [&](const std::string& name) { return path.empty() ? name : path + "." + name; };
  if (j.is_object()) {
    for (const auto& [key, value] : j.items()) flatten(value, below(key), row);
  } else if (j.is_array()) {
    if (j.size() > kMostInList) return;
    for (std::size_t i = 0; i < j.size(); ++i) flatten(j[i], below(std::to_string(i)), row);
  } else if (j.is_number()) {
    row[path] = j.dump();
  } else if (j.is_boolean()) {
    row[path] = std::string(1, j.get<bool>() ? '1' : '0');
  } else if (j.is_string()) {
    const auto& text = j.get_ref<const std::string&>();
    if (text.size() <= kLongestText) row[path] = quoted(text);
  }
}

/// "/task/status" as a file's name; what a stranger's recording calls its topics leads nowhere else.
std::string file_name(const std::string& topic) {
  std::string name;
  for (const char c : topic) {
    const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-';
    name += plain ? c : '_';
  }
  while (!name.empty() && name.front() == '_') name.erase(0, 1);
  return (name.empty() ? "messages" : name.substr(0, 100)) + ".csv";
}

constexpr std::size_t kBuffer = 1 << 16;

/// The table of one topic: the first pass over the recording finds its columns, the second writes its rows.
/// Its file is open only while it is written to: a stranger's recording may have more topics than a program
/// may open files.
struct Table {
  std::filesystem::path file;
  std::vector<std::string> columns;
  std::set<std::string> seen;
  std::string text;  ///< Not written yet.
  bool good = true;

  void find_columns(const Row& row) {
    for (const auto& [name, value] : row)
      if (columns.size() < kMostColumns && seen.insert(name).second) columns.push_back(name);
  }
  void begin() {
    good = std::ofstream(file, std::ios::binary | std::ios::trunc).good();
    text = "log_time_s";
    for (const std::string& c : columns)
      text += ',' + (c.find_first_of(",\"\r\n") == std::string::npos ? c : quoted(c));
    text += '\n';
  }
  void add(std::uint64_t log_time_ns, const Row& row) {
    text += fmt::format("{}.{:09}", log_time_ns / 1'000'000'000, log_time_ns % 1'000'000'000);
    for (const std::string& c : columns) {
      const auto cell = row.find(c);
      text += ',';
      if (cell != row.end()) text += cell->second;
    }
    text += '\n';
    if (text.size() > kBuffer) write();
  }
  void write() {
    std::ofstream out(file, std::ios::binary | std::ios::app);
    good = good && (out << text).flush().good();
    text.clear();
  }
};

/// Calls `use` with the table and the row of each message that has one, in the order of the recording.
template <class Use>
void for_each_row(const McapReader& file, std::map<std::uint16_t, Table>& tables,
                  const std::set<std::string>& topics, Use&& use) {
  auto cursor = file.messages(topics);
  while (const auto message = cursor.next()) {
    const auto table = tables.find(message->channel_id);
    if (table == tables.end()) continue;
    const Json j = Json::parse(message->data, nullptr, false);
    if (j.is_discarded()) continue;
    Row row;
    flatten(j, "", row);
    if (!row.empty()) use(table->second, *message, row);
  }
}

}  // namespace

hal::Result<Exported> export_csv(const McapReader& file, const std::filesystem::path& folder) {
  if (auto made = make_folder(folder); !made) return tl::unexpected(made.error());
  // twice over the recording, not over each topic: most of its bytes are depth images, which every pass
  // decompresses
  std::map<std::uint16_t, Table> tables;
  std::set<std::string> topics, names;
  for (const auto& [id, channel] : file.info().channels) {
    if (channel.message_encoding != "json") continue;
    // topics of a stranger may differ in what a file's name cannot have
    std::string name = file_name(channel.topic);
    for (int n = 2; !names.insert(name).second; ++n) name = fmt::format("{}_{}", n, file_name(channel.topic));
    tables[id].file = folder / name;
    topics.insert(channel.topic);
  }
  // without a topic all of them would be read
  if (!topics.empty())
    for_each_row(file, tables, topics,
                 [](Table& table, const Message&, const Row& row) { table.find_columns(row); });
  std::erase_if(tables, [](const auto& table) { return table.second.columns.empty(); });
  for (auto& [id, table] : tables) table.begin();
  if (!tables.empty())
    for_each_row(file, tables, topics, [](Table& table, const Message& message, const Row& row) {
      table.add(message.log_time, row);
    });
  Exported out;
  for (auto& [id, table] : tables) {
    table.write();
    if (!table.good) return cannot_write(table.file);
    out.files.push_back(table.file);
    ++out.count;
  }
  if (out.count == 0)
    return hal::failure(hal::ErrorCode::BadInput, "export",
                        "the recording has no JSON messages with numbers or words in them");
  return out;
}

}  // namespace colift::telemetry
