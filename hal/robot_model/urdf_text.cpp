#include "hal/robot_model/urdf_text.hpp"

#include <console_bridge/console.h>
#include <fmt/format.h>
#include <tinyxml.h>
#include <urdf_parser/urdf_parser.h>

#include <algorithm>
#include <exception>
#include <mutex>
#include <optional>

namespace colift::hal {
namespace {

constexpr std::size_t kMaxBytes = 4u << 20;
/// The XML reader descends by recursion; a URDF is about six deep.
constexpr int kMaxDepth = 64;

/// Keeps what the reader complains of (detail first, then the element); it prints to stderr otherwise.
class Complaints : public console_bridge::OutputHandler {
 public:
  Complaints() { console_bridge::useOutputHandler(this); }
  ~Complaints() override { console_bridge::restorePreviousOutputHandler(); }
  Complaints(const Complaints&) = delete;
  Complaints& operator=(const Complaints&) = delete;

  void log(const std::string& text, console_bridge::LogLevel level, const char*, int) override {
    if (level < console_bridge::CONSOLE_BRIDGE_LOG_ERROR || ++count_ > kMost) return;
    text_ += (text_.empty() ? "" : "; ") + text;
  }
  [[nodiscard]] const std::string& text() const { return text_; }

 private:
  static constexpr int kMost = 3;
  std::string text_;
  int count_ = 0;
};

/// Most elements open at a time; an upper bound where the text is no XML.
int depth_of(const std::string& text) {
  int depth = 0, deepest = 0;
  for (std::size_t i = 0; i + 1 < text.size(); ++i) {
    if (text.compare(i, 4, "<!--") == 0) {
      i = text.find("-->", i);
      if (i == std::string::npos) break;
    } else if (text[i] == '<' && text[i + 1] == '/') {
      depth = depth > 0 ? depth - 1 : 0;
    } else if (text[i] == '/' && text[i + 1] == '>') {
      depth = depth > 0 ? depth - 1 : 0;
    } else if (text[i] == '<' && text[i + 1] != '?' && text[i + 1] != '!') {
      deepest = std::max(deepest, ++depth);
    }
  }
  return deepest;
}

std::string place(const std::string& name, const std::map<std::string, int>& lines, const std::string& key) {
  const auto it = lines.find(key);
  return it == lines.end() ? name : fmt::format("{}:{}", name, it->second);
}

std::map<std::string, int> lines_of(const TiXmlElement& robot, const char* kind) {
  std::map<std::string, int> lines;
  for (const TiXmlElement* e = robot.FirstChildElement(kind); e; e = e->NextSiblingElement(kind)) {
    if (const char* name = e->Attribute("name")) lines.emplace(name, e->Row());
  }
  return lines;
}

/// What keeps the links from being a tree; the reader would tie such links to each other and never free them.
std::optional<std::string> no_tree(const TiXmlElement& robot) {
  constexpr int kLongestChain = 500;
  const auto link_of = [](const TiXmlElement& joint, const char* side) -> std::string {
    const TiXmlElement* e = joint.FirstChildElement(side);
    const char* link = e ? e->Attribute("link") : nullptr;
    return link ? link : "";
  };
  std::map<std::string, std::string> parent_of;
  for (const TiXmlElement* e = robot.FirstChildElement("joint"); e; e = e->NextSiblingElement("joint")) {
    const std::string child = link_of(*e, "child");
    if (!child.empty() && !parent_of.emplace(child, link_of(*e, "parent")).second) {
      return fmt::format("link {} is carried by two joints", child);
    }
  }
  for (const auto& start : parent_of) {
    auto it = parent_of.find(start.second);
    for (int i = 0; it != parent_of.end(); ++i, it = parent_of.find(it->second)) {
      if (i == kLongestChain)
        return fmt::format("link {} hangs on itself or on too long a chain", start.first);
    }
  }
  return std::nullopt;
}

}  // namespace

std::string UrdfText::place_of_link(const std::string& link) const {
  return place(name, line_of_link, link);
}
std::string UrdfText::place_of_joint(const std::string& joint) const {
  return place(name, line_of_joint, joint);
}

Result<UrdfText> read_urdf_text(const std::string& urdf, const std::string& name) {
  const auto bad = [&](const std::string& where, std::string text) {
    return failure(ErrorCode::BadInput, where, std::move(text));
  };
  if (urdf.find_first_not_of(" \t\r\n") == std::string::npos) return bad(name, "is empty, expected a URDF");
  if (urdf.size() > kMaxBytes) {
    return bad(name, fmt::format("has {} bytes; a URDF of a robot has less than {}", urdf.size(), kMaxBytes));
  }
  if (const int depth = depth_of(urdf); depth > kMaxDepth) {
    return bad(name, fmt::format("nests elements {} deep; a URDF needs less than {}", depth, kMaxDepth));
  }
  TiXmlDocument document;
  document.Parse(urdf.c_str(), nullptr, TIXML_ENCODING_UTF8);
  if (document.Error()) {
    const std::string where = document.ErrorRow() > 0
                                  ? fmt::format("{}:{}:{}", name, document.ErrorRow(), document.ErrorCol())
                                  : name;
    return bad(where, fmt::format("is no XML: {}", document.ErrorDesc()));
  }
  const TiXmlElement* robot = document.FirstChildElement("robot");
  if (!robot) return bad(name, "has no element <robot>");

  UrdfText out;
  out.name = name;
  out.line_of_link = lines_of(*robot, "link");
  out.line_of_joint = lines_of(*robot, "joint");

  if (const auto why = no_tree(*robot)) return failure(ErrorCode::BadConfig, name, *why);

  // the reader's way of complaining is one handler for the whole process
  static std::mutex one_at_a_time;
  const std::lock_guard lock(one_at_a_time);
  const Complaints complaints;
  std::string thrown;
  try {
    out.model = urdf::parseURDF(urdf);
  } catch (const std::exception& e) {
    thrown = e.what();
  }
  if (!out.model || !complaints.text().empty()) {
    const std::string& text = complaints.text().empty() ? thrown : complaints.text();
    return failure(ErrorCode::BadConfig, name, text.empty() ? "the URDF reader refuses it" : text);
  }
  return out;
}

}  // namespace colift::hal
