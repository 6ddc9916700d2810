#include "tools/cli/json_tree.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

namespace colift::tools {
namespace {

using hal::ErrorCode;
using nlohmann::json;

// No document of ours is half as deep; anything deeper is an attack on somebody's stack.
constexpr std::size_t kMaxDepth = 16;
// A million candidates; more values are a wrong file, and would fill the memory before they are found wrong.
constexpr std::size_t kMaxValues = 5'000'000;

/// Input iterator that tells how far the reader has come.
class Cursor {
 public:
  using iterator_category = std::input_iterator_tag;
  using value_type = char;
  using difference_type = std::ptrdiff_t;
  using pointer = const char*;
  using reference = const char&;

  Cursor(const char* at, const char** furthest) : at_(at), furthest_(furthest) {}
  reference operator*() const { return *at_; }
  Cursor& operator++() {
    *furthest_ = ++at_;
    return *this;
  }
  Cursor operator++(int) {
    Cursor before = *this;
    ++*this;
    return before;
  }
  bool operator==(const Cursor& other) const { return at_ == other.at_; }
  bool operator!=(const Cursor& other) const { return at_ != other.at_; }

 private:
  const char* at_;
  const char** furthest_;
};

/// Builds the tree from nlohmann's events; refuses depth, doubled keys and numbers beyond the doubles on the
/// way.
class TreeBuilder final : public nlohmann::json_sax<json> {
 public:
  TreeBuilder(std::string_view text, const char* const* furthest) : text_(text), furthest_(furthest) {}

  bool null() override { return add(JsonNode::Kind::Null, 4); }
  bool boolean(bool value) override { return add(JsonNode::Kind::Boolean, value ? 4 : 5); }
  bool number_integer(number_integer_t value) override { return add_number(static_cast<double>(value)); }
  bool number_unsigned(number_unsigned_t value) override { return add_number(static_cast<double>(value)); }
  bool number_float(number_float_t value, const string_t&) override { return add_number(value); }
  bool string(string_t& value) override {
    if (!add(JsonNode::Kind::String, quoted_length())) return false;
    last_->texts = std::make_unique<std::vector<std::string>>(1, std::move(value));
    return true;
  }
  bool binary(binary_t&) override { return false; }
  bool start_object(std::size_t) override { return open(JsonNode::Kind::Object); }
  bool start_array(std::size_t) override { return open(JsonNode::Kind::Array); }
  bool key(string_t& value) override {
    auto& keys = *path_.back()->texts;
    if (std::find(keys.begin(), keys.end(), value) != keys.end()) {
      return refuse(offset() - quoted_length(),
                    fmt::format("the key \"{}\" comes twice in one object", shown(value)));
    }
    // an object with thousands of keys is none of ours, and looking for doubles in it would take forever
    if (keys.size() >= 64) return refuse(offset() - quoted_length(), "an object with more than 64 keys");
    keys.push_back(std::move(value));
    return true;
  }
  bool end_object() override { return close(); }
  bool end_array() override { return close(); }
  bool parse_error(std::size_t, const std::string&, const json::exception& error) override {
    std::string what = error.what();
    // "[json.exception...] parse error at line 1, column 2: ..." -> what follows; the place is told
    // separately
    if (const auto colon = what.find("column"); colon != std::string::npos) {
      what = what.substr(std::min(what.size(), what.find(':', colon) + 2));
    } else if (const auto bracket = what.find("] "); bracket != std::string::npos) {
      what = what.substr(bracket + 2);
    }
    if (const auto last = what.find("; last read: "); last != std::string::npos) {
      what = what.substr(0, last + 13) + shown(what.substr(last + 13));  // the bytes of a stranger
    }
    const std::size_t end = offset();
    return refuse(end > 0 && end < text_.size() ? end - 1 : end, "is not valid JSON: " + what);
  }

  [[nodiscard]] JsonNode take() { return std::move(root_); }
  [[nodiscard]] const std::optional<std::pair<std::size_t, std::string>>& refusal() const { return refusal_; }

 private:
  [[nodiscard]] std::size_t offset() const { return static_cast<std::size_t>(*furthest_ - text_.data()); }

  /// Length of the quoted text that ends here.
  [[nodiscard]] std::size_t quoted_length() const {
    const std::size_t end = offset();
    std::size_t begin = end < 2 ? 0 : end - 2;
    while (begin > 0) {
      if (text_[begin] == '"') {
        std::size_t slashes = 0;
        while (slashes < begin && text_[begin - 1 - slashes] == '\\') ++slashes;
        if (slashes % 2 == 0) break;
      }
      --begin;
    }
    return end - begin;
  }

  bool refuse(std::size_t at, std::string why) {
    if (!refusal_) refusal_.emplace(at, std::move(why));
    return false;
  }

  bool place(JsonNode node) {
    if (++values_ > kMaxValues) return refuse(node.at, fmt::format("more than {} values", kMaxValues));
    if (path_.empty()) {
      root_ = std::move(node);
      last_ = &root_;
    } else {
      path_.back()->items.push_back(std::move(node));
      last_ = &path_.back()->items.back();
    }
    return true;
  }
  bool add(JsonNode::Kind kind, std::size_t length) {
    JsonNode node;
    node.kind = kind;
    node.at = static_cast<std::uint32_t>(offset() - std::min(length, offset()));
    return place(std::move(node));
  }
  bool add_number(double value) {
    // the reader has looked one character past the number, unless the text ended with it
    std::size_t begin = offset();
    const auto in_number = [](char c) {
      return (c >= '0' && c <= '9') || c == '+' || c == '-' || c == '.' || c == 'e' || c == 'E';
    };
    while (begin > 0 && !in_number(text_[begin - 1])) --begin;
    while (begin > 0 && in_number(text_[begin - 1])) --begin;
    if (!std::isfinite(value)) return refuse(begin, "a number that is not finite");
    JsonNode node;
    node.kind = JsonNode::Kind::Number;
    node.at = static_cast<std::uint32_t>(begin);
    node.number = value;
    return place(std::move(node));
  }
  bool open(JsonNode::Kind kind) {
    if (path_.size() >= kMaxDepth) {
      return refuse(offset() - 1, fmt::format("is nested deeper than {} levels", kMaxDepth));
    }
    if (!add(kind, 1)) return false;
    if (kind == JsonNode::Kind::Object) last_->texts = std::make_unique<std::vector<std::string>>();
    path_.push_back(last_);
    return true;
  }
  bool close() {
    path_.pop_back();
    return true;
  }

  std::string_view text_;
  const char* const* furthest_;
  JsonNode root_;
  JsonNode* last_ = nullptr;
  std::size_t values_ = 0;
  std::vector<JsonNode*> path_;  // open lists and objects; their addresses hold while they are open
  std::optional<std::pair<std::size_t, std::string>> refusal_;
};

}  // namespace

std::string shown(std::string text) {
  if (text.size() > 40) text = text.substr(0, 40) + "...";
  for (char& c : text) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = '?';
  }
  return text;
}

std::string JsonNode::found() const {
  switch (kind) {
    case Kind::Null:
      return "null";
    case Kind::Boolean:
      return "true or false";
    case Kind::Number:
      return fmt::format("the number {}", number);
    case Kind::String:
      return fmt::format("the text \"{}\"", shown(texts->front()));
    case Kind::Array:
      return fmt::format("a list of {}", items.size());
    case Kind::Object:
      return "an object";
  }
  return {};
}

tl::unexpected<hal::Error> failure_at(std::string_view text, const std::string& name, std::size_t at,
                                      std::string why) {
  at = std::min(at, text.size());
  const auto begin = text.begin();
  const auto line = 1 + std::count(begin, begin + static_cast<std::ptrdiff_t>(at), '\n');
  const std::size_t newline = at == 0 ? std::string_view::npos : text.rfind('\n', at - 1);
  const std::size_t column = newline == std::string_view::npos ? at + 1 : at - newline;
  return hal::failure(ErrorCode::BadInput, fmt::format("{}:{}:{}", name, line, column), std::move(why));
}

hal::Result<JsonNode> parse_json_tree(std::string_view text, const std::string& name) {
  if (text.size() > std::numeric_limits<std::uint32_t>::max()) {
    return hal::failure(ErrorCode::BadInput, name, "is longer than 4 GiB");
  }
  if (text.find_first_not_of(" \t\r\n") == std::string_view::npos) {
    return failure_at(text, name, 0, "the document is empty, expected an object");
  }
  const char* furthest = text.data();
  TreeBuilder tree(text, &furthest);
  const Cursor begin(text.data(), &furthest), end(text.data() + text.size(), &furthest);
  const bool whole = json::sax_parse(begin, end, &tree);
  if (tree.refusal()) return failure_at(text, name, tree.refusal()->first, tree.refusal()->second);
  if (!whole) return failure_at(text, name, 0, "is not valid JSON");
  return tree.take();
}

}  // namespace colift::tools
