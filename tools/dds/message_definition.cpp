#include "tools/dds/message_definition.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <map>
#include <optional>
#include <utility>
#include <vector>

namespace colift::ros2 {
namespace {

constexpr std::string_view kIdl =
#include "idl.inc"
    ;

struct Member {
  std::string type, name;  ///< "geometry_msgs/msg/Pose" or "float64"; arrays as in a .msg file: "float64[9]".
};
using Types = std::map<std::string, std::vector<Member>>;  ///< By "package/msg/Type".

constexpr std::array<std::pair<std::string_view, std::string_view>, 10> kBasic{{
    {"boolean", "bool"},
    {"octet", "uint8"},
    {"short", "int16"},
    {"long", "int32"},
    {"long long", "int64"},
    {"unsigned long", "uint32"},
    {"unsigned long long", "uint64"},
    {"float", "float32"},
    {"double", "float64"},
    {"string", "string"},
}};

bool is_basic(std::string_view type) {
  return std::any_of(kBasic.begin(), kBasic.end(), [&](const auto& b) { return b.second == type; });
}

/// Words and single signs; "::" is one.
std::vector<std::string> tokens_of(std::string_view idl) {
  std::vector<std::string> out;
  const auto part_of_word = [](char c) { return std::isalnum(static_cast<unsigned char>(c)) || c == '_'; };
  for (std::size_t i = 0; i < idl.size();) {
    if (idl.substr(i, 2) == "//" || idl[i] == '#') {
      i = std::min(idl.find('\n', i), idl.size());
    } else if (std::isspace(static_cast<unsigned char>(idl[i]))) {
      ++i;
    } else if (idl[i] == '@') {
      for (++i; i < idl.size() && part_of_word(idl[i]);) ++i;
    } else if (part_of_word(idl[i])) {
      const std::size_t from = i;
      while (i < idl.size() && part_of_word(idl[i])) ++i;
      out.emplace_back(idl.substr(from, i - from));
    } else if (idl.substr(i, 2) == "::") {
      out.emplace_back("::");
      i += 2;
    } else {
      out.emplace_back(1, idl[i++]);
    }
  }
  return out;
}

/// Reads the little of IDL that messages of ROS 2 need.
class IdlReader {
 public:
  explicit IdlReader(std::string_view idl) : tokens_(tokens_of(idl)) {}

  hal::Result<Types> read() {
    while (!failed() && at_ < tokens_.size()) declaration();
    if (failed()) return hal::failure(hal::ErrorCode::BadInput, "idl", *fault_);
    return std::move(types_);
  }

 private:
  [[nodiscard]] bool failed() const { return fault_.has_value(); }
  [[nodiscard]] std::string peek() const { return at_ < tokens_.size() ? tokens_[at_] : ""; }
  std::string next() {
    std::string token = peek();
    if (token.empty() && !fault_) fault_ = "it ends in the middle of a declaration";
    ++at_;
    return token;
  }
  void expect(std::string_view token) {
    const std::string found = next();
    if (!fault_ && found != token) fault_ = fmt::format("\"{}\" where \"{}\" is expected", found, token);
  }

  void declaration() {
    const std::string token = next();
    if (token == "module") {
      modules_.push_back(next());
      expect("{");
    } else if (token == "}" && !modules_.empty()) {
      modules_.pop_back();
      expect(";");
    } else if (token == "struct") {
      read_struct();
    } else if (token == "typedef") {
      const std::string type = type_name();
      const std::string name = next();
      expect("[");
      arrays_[name] = type + "[" + next() + "]";
      expect("]"), expect(";");
    } else if (!fault_) {
      fault_ = fmt::format("\"{}\" where a declaration is expected", token);
    }
  }

  void read_struct() {
    const std::string name = qualified(next());
    std::vector<Member>& members = types_[name];
    expect("{");
    while (!failed() && peek() != "}") {
      std::string type = type_name();
      members.push_back({std::move(type), next()});
      expect(";");
    }
    expect("}"), expect(";");
  }

  std::string type_name() {
    std::string first = next();
    if (first == "sequence") {
      expect("<");
      std::string element = type_name();
      expect(">");
      return element + "[]";
    }
    while (peek() == "long" || (first == "unsigned" && peek() == "short")) first += " " + next();
    while (peek() == "::") {
      first += next();
      first += next();
    }
    if (first == "string" && peek() == "<") {  // bounded: the bound does not change the encoding
      next(), next(), expect(">");
    }
    for (const auto& [idl, ros] : kBasic)
      if (first == idl) return std::string(ros);
    if (const auto array = arrays_.find(first); array != arrays_.end()) return array->second;
    return first.find("::") == std::string::npos ? qualified(first) : ros2_type(first);
  }

  /// A type of the module that is being read.
  [[nodiscard]] std::string qualified(const std::string& name) const {
    return ros2_type(fmt::format("{}::{}", fmt::join(modules_, "::"), name));
  }

  std::vector<std::string> tokens_;
  std::size_t at_ = 0;
  std::optional<std::string> fault_;
  std::vector<std::string> modules_;
  std::map<std::string, std::string> arrays_;
  Types types_;
};

std::string element_of(const std::string& type) {
  return type.substr(0, type.find('['));
}

/// "sensor_msgs/msg/Image" as definitions have it: "sensor_msgs/Image".
std::string short_name(const std::string& type) {
  const std::size_t msg = type.find("/msg/");
  return msg == std::string::npos ? type : type.substr(0, msg) + type.substr(msg + 4);
}

hal::Result<std::string> definition(const Types& types, const std::string& type) {
  std::vector<std::string> order{type};
  std::string out;
  for (std::size_t i = 0; i < order.size(); ++i) {
    const auto found = types.find(order[i]);
    if (found == types.end()) return hal::failure(hal::ErrorCode::NotFound, order[i], "is no known message");
    if (i > 0) out += std::string(80, '=') + "\nMSG: " + short_name(order[i]) + "\n";
    for (const Member& m : found->second) {
      out += short_name(m.type) + " " + m.name + "\n";
      const std::string element = element_of(m.type);
      if (!is_basic(element) && std::find(order.begin(), order.end(), element) == order.end())
        order.push_back(element);
    }
  }
  return out;
}

}  // namespace

std::string ros2_type(std::string_view dds_type) {
  std::string name(dds_type);
  const std::size_t msg = name.find("::msg::dds_::");
  if (msg == std::string::npos || name.back() != '_') return name;
  return name.substr(0, msg) + "/msg/" + name.substr(msg + 13, name.size() - msg - 14);
}

hal::Result<std::string> message_definition(std::string_view idl, const std::string& ros2_type) {
  const auto types = IdlReader(idl).read();
  if (!types) return tl::unexpected(types.error());
  return definition(*types, ros2_type);
}

hal::Result<std::string> message_definition(const std::string& ros2_type) {
  return message_definition(kIdl, ros2_type);
}

}  // namespace colift::ros2
