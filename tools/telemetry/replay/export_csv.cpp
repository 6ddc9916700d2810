#include <fmt/format.h>

#include <fstream>
#include <map>
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

hal::Result<> write_table(const McapReader& file, const Channel& channel, const std::filesystem::path& to,
                          bool& any) {
  // twice over the messages: first which columns there are
  std::vector<std::string> columns;
  std::map<std::string, bool> seen;
  any = false;
  for (const bool writing : {false, true}) {
    std::ofstream out;
    if (writing) {
      if (!any) return {};
      out.open(to, std::ios::binary | std::ios::trunc);
      out << "log_time_s";
      for (const std::string& c : columns)
        out << ',' << (c.find_first_of(",\"\r\n") == std::string::npos ? c : quoted(c));
      out << '\n';
    }
    auto cursor = file.messages({channel.topic});
    while (const auto message = cursor.next()) {
      const Json j = Json::parse(message->data, nullptr, false);
      if (j.is_discarded()) continue;
      Row row;
      flatten(j, "", row);
      if (row.empty()) continue;
      any = true;
      if (!writing) {
        for (const auto& [name, value] : row)
          if (columns.size() < kMostColumns && !std::exchange(seen[name], true)) columns.push_back(name);
        continue;
      }
      out << fmt::format("{}.{:09}", message->log_time / 1'000'000'000, message->log_time % 1'000'000'000);
      for (const std::string& c : columns) {
        const auto cell = row.find(c);
        out << ',';
        if (cell != row.end()) out << cell->second;
      }
      out << '\n';
    }
    if (writing && !out.flush()) return cannot_write(to);
  }
  return {};
}

}  // namespace

hal::Result<Exported> export_csv(const McapReader& file, const std::filesystem::path& folder) {
  if (auto made = make_folder(folder); !made) return tl::unexpected(made.error());
  Exported out;
  for (const auto& [id, channel] : file.info().channels) {
    if (channel.message_encoding != "json") continue;
    const std::filesystem::path to = folder / file_name(channel.topic);
    bool any = false;
    if (auto done = write_table(file, channel, to, any); !done) return tl::unexpected(done.error());
    if (!any) continue;
    out.files.push_back(to);
    ++out.count;
  }
  if (out.count == 0)
    return hal::failure(hal::ErrorCode::BadInput, "export",
                        "the recording has no JSON messages with numbers or words in them");
  return out;
}

}  // namespace colift::telemetry
