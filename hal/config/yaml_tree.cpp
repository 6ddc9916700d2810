#include "hal/config/yaml_tree.hpp"

#include <fmt/format.h>
#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/exceptions.h>
#include <yaml-cpp/parser.h>

#include <algorithm>
#include <exception>
#include <sstream>
#include <utility>

namespace colift::hal {
namespace {

struct Refusal {
  YamlPlace place;
  std::string reason;
};

YamlPlace place_of(const YAML::Mark& mark) {
  // yaml-cpp counts from 0, and gives -1 where it does not know
  return {mark.line < 0 ? 1 : mark.line + 1, mark.column < 0 ? 1 : mark.column + 1};
}

/// Length of the UTF-8 sequence at the start of `rest`, or 0 if there is none (RFC 3629, section 4).
std::size_t utf8_length(std::string_view rest) {
  const auto byte = [&](std::size_t i) { return i < rest.size() ? static_cast<unsigned char>(rest[i]) : 0U; };
  const auto tail = [&](std::size_t i) { return (byte(i) & 0xC0U) == 0x80U; };
  const unsigned first = byte(0);
  const unsigned second = byte(1);
  if (first < 0x80) return 1;
  if (first >= 0xC2 && first <= 0xDF) return tail(1) ? 2 : 0;
  if ((first & 0xF0U) == 0xE0U) {
    const bool overlong = first == 0xE0 && second < 0xA0;
    const bool surrogate = first == 0xED && second > 0x9F;
    return tail(1) && tail(2) && !overlong && !surrogate ? 3 : 0;
  }
  if (first >= 0xF0 && first <= 0xF4) {
    const bool overlong = first == 0xF0 && second < 0x90;
    const bool beyond = first == 0xF4 && second > 0x8F;
    return tail(1) && tail(2) && tail(3) && !overlong && !beyond ? 4 : 0;
  }
  return 0;
}

std::optional<Refusal> check_is_text(std::string_view text) {
  YamlPlace place;
  for (std::size_t i = 0; i < text.size();) {
    const auto byte = static_cast<unsigned char>(text[i]);
    const std::size_t length = utf8_length(text.substr(i));
    const bool control = (byte < 0x20 && byte != '\t' && byte != '\n' && byte != '\r') || byte == 0x7F;
    if (length == 0 || control) {
      return Refusal{
          place, fmt::format("byte {} is 0x{:02X}, which no UTF-8 text file holds; is this a YAML file?", i,
                             unsigned{byte})};
    }
    i += length;
    if (byte == '\n') {
      place = {place.line + 1, 1};
    } else {
      ++place.column;
    }
  }
  return std::nullopt;
}

/// What a person would look at first. yaml-cpp's own words name the parser's state, not the slip.
std::string syntax_error(std::string_view text, const YAML::Exception& error) {
  std::string sentence = "this is no YAML: " + quotable(error.msg, 120);
  std::string_view rest = text;
  for (int line = 0; line < error.mark.line && !rest.empty(); ++line) {
    const std::size_t end = rest.find('\n');
    rest.remove_prefix(end == std::string_view::npos ? rest.size() : end + 1);
  }
  const std::size_t indent = std::min(rest.find_first_not_of(" \t"), rest.size());
  if (rest.substr(0, indent).find('\t') != std::string_view::npos) {
    return sentence + "; this line is indented with a tab, YAML wants spaces";
  }
  if (error.msg == YAML::ErrorMsg::MAP_VALUE) {
    sentence += "; check the indentation, and quote a text that holds \": \"";
  }
  return sentence;
}

/// Builds the tree from the parser's events. Events come before the parser descends, so refusing here bounds
/// its stack.
class TreeBuilder final : public YAML::EventHandler {
 public:
  YamlTree tree;

  void OnDocumentStart(const YAML::Mark& mark) override {
    if (++documents_ > 1) throw Refusal{place_of(mark), "a second document starts here, expected only one"};
  }
  void OnDocumentEnd() override {}

  void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    add(YamlNode::Kind::Null, mark, "", anchor);
  }

  void OnAlias(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    const auto known = anchor < anchors_.size() ? anchors_[anchor] : std::nullopt;
    if (!known) throw Refusal{place_of(mark), "an alias points to nothing known"};
    for (const std::uint32_t open : open_) {
      if (open == *known) throw Refusal{place_of(mark), "an alias points to the value that it stands in"};
    }
    attach(*known, place_of(mark));
  }

  void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                const std::string& value) override {
    const bool quoted = tag == "!";
    refuse_tag(mark, quoted ? "" : tag);
    tree.nodes[add(quoted ? YamlNode::Kind::Quoted : YamlNode::Kind::Plain, mark, "", anchor)].text = value;
  }

  void OnSequenceStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                       YAML::EmitterStyle::value /*style*/) override {
    open(YamlNode::Kind::List, mark, tag, anchor);
  }
  void OnSequenceEnd() override { open_.pop_back(); }

  void OnMapStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                  YAML::EmitterStyle::value /*style*/) override {
    open(YamlNode::Kind::Map, mark, tag, anchor);
  }
  void OnMapEnd() override { open_.pop_back(); }

 private:
  static void refuse_tag(const YAML::Mark& mark, const std::string& tag) {
    if (tag.empty() || tag == "?") return;
    throw Refusal{place_of(mark),
                  fmt::format("the tag \"{}\" is not understood; write plain values", quotable(tag))};
  }

  void open(YamlNode::Kind kind, const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor) {
    if (static_cast<int>(open_.size()) >= kMaxYamlDepth) {
      throw Refusal{place_of(mark), fmt::format("nested deeper than {} levels", kMaxYamlDepth)};
    }
    open_.push_back(add(kind, mark, tag, anchor));
  }

  std::uint32_t add(YamlNode::Kind kind, const YAML::Mark& mark, const std::string& tag,
                    YAML::anchor_t anchor) {
    refuse_tag(mark, tag);
    if (tree.nodes.size() >= kMaxYamlNodes) {
      throw Refusal{place_of(mark), fmt::format("more than {} values", kMaxYamlNodes)};
    }
    const auto index = static_cast<std::uint32_t>(tree.nodes.size());
    attach(index, place_of(mark));
    tree.nodes.push_back({kind, place_of(mark), "", {}});
    if (anchor != YAML::NullAnchor) {
      if (anchors_.size() <= anchor) anchors_.resize(anchor + 1);
      anchors_[anchor] = index;
    }
    return index;
  }

  void attach(std::uint32_t index, YamlPlace place) {
    if (open_.empty()) {
      tree.root = index;
      return;
    }
    YamlNode& parent = tree.nodes[open_.back()];
    parent.children.push_back(index);
    // a long list of aliases has few nodes of its own
    if (++attached_ > kMaxYamlNodes) throw Refusal{place, fmt::format("more than {} values", kMaxYamlNodes)};
  }

  int documents_ = 0;
  std::size_t attached_ = 0;
  std::vector<std::uint32_t> open_;
  std::vector<std::optional<std::uint32_t>> anchors_;
};

/// Keys have to be plain names, each once.
std::optional<Refusal> check_keys(const YamlTree& tree) {
  for (const YamlNode& node : tree.nodes) {
    if (node.kind != YamlNode::Kind::Map) continue;
    for (std::size_t i = 0; i + 1 < node.children.size(); i += 2) {
      const YamlNode& key = tree.at(node.children[i]);
      if (key.kind != YamlNode::Kind::Plain && key.kind != YamlNode::Kind::Quoted) {
        return Refusal{key.place, "a key has to be a name"};
      }
    }
  }
  return std::nullopt;
}

}  // namespace

std::string place_text(const std::string& name, YamlPlace place) {
  return fmt::format("{}:{}:{}", name, place.line, place.column);
}

bool is_utf8(std::string_view text) {
  while (!text.empty()) {
    const std::size_t length = utf8_length(text);
    if (length == 0) return false;
    text.remove_prefix(length);
  }
  return true;
}

std::string quotable(std::string_view text, std::size_t longest) {
  std::string out;
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t length = utf8_length(text.substr(i));
    const auto byte = static_cast<unsigned char>(text[i]);
    if (out.size() + length > longest) return out + "...";
    if (length == 0 || byte < 0x20 || byte == 0x7F) {
      out += '?';
    } else {
      out += text.substr(i, length);
    }
    i += length == 0 ? 1 : length;
  }
  return out;
}

Result<YamlTree> parse_yaml(std::string_view text, const std::string& name) {
  const auto refuse = [&](const Refusal& refusal) {
    return failure(ErrorCode::BadConfig, place_text(name, refusal.place), refusal.reason);
  };
  if (text.size() > kMaxYamlBytes) {
    return failure(
        ErrorCode::BadConfig, name,
        fmt::format("the text is larger than {} bytes, too large for a configuration", kMaxYamlBytes));
  }
  if (const auto refusal = check_is_text(text)) return refuse(*refusal);

  TreeBuilder builder;
  try {
    std::istringstream stream{std::string(text)};
    YAML::Parser parser(stream);
    while (parser.HandleNextDocument(builder)) {
    }
  } catch (const Refusal& refusal) {
    return refuse(refusal);
  } catch (const YAML::Exception& error) {
    return refuse({place_of(error.mark), syntax_error(text, error)});
  } catch (const std::exception& error) {
    return failure(ErrorCode::BadConfig, name,
                   fmt::format("this is no YAML: {}", quotable(error.what(), 120)));
  }
  if (builder.tree.nodes.empty()) builder.tree.nodes.emplace_back();
  if (const auto refusal = check_keys(builder.tree)) return refuse(*refusal);
  return std::move(builder.tree);
}

}  // namespace colift::hal
