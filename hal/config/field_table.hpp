#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "hal/config/range.hpp"
#include "hal/types/geometry.hpp"

namespace colift::hal {

class FieldTable;

/// A std::vector of some struct, seen without knowing the struct.
class StructList {
 public:
  virtual ~StructList() = default;

  [[nodiscard]] virtual std::size_t size() const = 0;

  /// The fields of one element; valid until the list changes its length.
  [[nodiscard]] virtual FieldTable element(std::size_t index) = 0;

  /// Another list of the same type with its own storage and `count` elements at their defaults.
  [[nodiscard]] virtual std::unique_ptr<StructList> fresh(std::size_t count) const = 0;

  /// Moves the content of a list made by fresh() of this one into this one.
  virtual void take(StructList& other) = 0;
};

/// Value of one field, without the struct that it lives in.
using FieldValue = std::variant<bool, int, double, std::string, Vec3, std::vector<double>,
                                std::optional<double>, std::optional<Vec3>>;

/// Where one field lives.
using FieldSlot = std::variant<bool*, int*, double*, std::string*, Vec3*, std::vector<double>*,
                               std::optional<double>*, std::optional<Vec3>*, std::shared_ptr<StructList>>;

inline constexpr std::string_view kDefaultOrigin = "default";

/// One entry of a configuration.
struct Field {
  std::string path;  ///< Dotted, "ground.max_tilt_deg".
  FieldSlot slot;
  Range range;                       ///< For numbers, each one of a list.
  std::vector<std::string> choices;  ///< For texts; empty: any text.
  std::string help;
  Presence presence = Presence::Optional;
  bool may_be_nan = false;       ///< The default is NaN: unset.
  bool may_be_infinite = false;  ///< The default is infinite, no limit, or or_infinite() was said.
  /// Who said the value: "default", "FILE:LINE", "--set", or what a program writes here (a method, an
  /// option).
  std::string origin = std::string(kDefaultOrigin);
};

/// A nested struct.
struct FieldGroup {
  std::string path;
  std::string help;
};

/// A field or group that had another name once; files may still use it.
struct RenamedField {
  std::string old_path;  ///< Dotted, as `path`.
  std::string path;
};

/// What a file may say about a field that nobody knows.
enum class UnknownKeys { Refused, LeftOut };

/// All fields of a configuration struct as one flat list in the order of its visit(). The table points into
/// the struct: the struct has to outlive it and stay where it is. Copies of a table point to the same struct.
class FieldTable {
 public:
  [[nodiscard]] std::span<const Field> fields() const { return fields_; }
  [[nodiscard]] std::span<Field> fields() { return fields_; }
  [[nodiscard]] std::span<const FieldGroup> groups() const { return groups_; }

  /// nullptr when there is none of that path.
  [[nodiscard]] const Field* find(std::string_view path) const;
  [[nodiscard]] Field* find(std::string_view path);
  [[nodiscard]] const FieldGroup* find_group(std::string_view path) const;

  /// The path of today for one that may be an old name, or stands below one; nothing when it is none.
  [[nodiscard]] std::optional<std::string> renamed(std::string_view old_path) const;
  /// Whether an old name begins with this group, which need not exist any more.
  [[nodiscard]] bool has_renamed_below(std::string_view group) const;

  /// For TableVisitor. Throws std::logic_error for a name that is taken, empty, or not of [a-z0-9_] (a
  /// mistake in code).
  void add_field(Field field);
  void add_group(FieldGroup group);
  void add_renamed(RenamedField renamed);

  /// What was accepted and should be looked at, each with its place: old names, keys that were left out.
  std::vector<std::string> warnings;

 private:
  void check_name(const std::string& path) const;

  std::vector<Field> fields_;
  std::vector<FieldGroup> groups_;
  std::vector<RenamedField> renamed_;
};

/// The visitor that fills a FieldTable.
class TableVisitor {
 public:
  explicit TableVisitor(FieldTable& table) : table_(table) {}

  template <class T>
  void operator()(std::string_view name, T& value, Range range, std::string_view help,
                  Presence presence = Presence::Optional) {
    static_assert(kIsValue<T>,
                  "a Range belongs to int, double, Vec3, std::vector<double> or an optional of these");
    // kAny says nothing and may stand before any value, to be written alike
    if constexpr (!kHoldsNumbers<T>) range = kAny;
    add_value(name, value, range, {}, help, presence);
  }

  void operator()(std::string_view name, std::string& value, const Choices& choices, std::string_view help,
                  Presence presence = Presence::Optional) {
    add_value(name, value, kAny, choices.names, help, presence);
  }

  template <class T>
  void operator()(std::string_view name, T& value, std::string_view help,
                  Presence presence = Presence::Optional) {
    if constexpr (kIsValue<T>) {
      add_value(name, value, kAny, {}, help, presence);
    } else if constexpr (requires(T & t, TableVisitor & v) { t.visit(v); }) {
      table_.add_group({prefix_ + std::string(name), std::string(help)});
      const std::string outer = prefix_;
      prefix_ += std::string(name) + '.';
      value.visit(*this);
      prefix_ = outer;
    } else {
      add_list(name, value, help, presence);
    }
  }

  /// What was named before may be .inf, no limit, although its default is finite.
  void or_infinite(std::string_view name);

  /// What was named before had another name once. Files with the old one stay readable, with a warning:
  ///   v("timeout_s", timeout_s, Range{0.1, 3600}, "How long a partner is waited for (s).");
  ///   v.renamed("timeout_s", "timeout_s");
  /// Both names count from the struct; what moved between groups is renamed by the struct around them,
  /// v.renamed("task.timeout_s", "partner.timeout_s"). A group is renamed like an entry.
  void renamed(std::string_view old_name, std::string_view name) {
    table_.add_renamed({prefix_ + std::string(old_name), prefix_ + std::string(name)});
  }

 private:
  template <class T>
  static constexpr bool kIsValue = std::is_constructible_v<FieldSlot, std::in_place_type_t<T*>, T*>;
  template <class T>
  static constexpr bool kHoldsNumbers =
      kIsValue<T> && !std::is_same_v<T, bool> && !std::is_same_v<T, std::string>;

  template <class T>
  void add_value(std::string_view name, T& value, Range range, std::vector<std::string> choices,
                 std::string_view help, Presence presence) {
    add_slot(name, FieldSlot(std::in_place_type<T*>, &value), range, std::move(choices), help, presence);
  }

  template <class T>
  void add_list(std::string_view name, T& value, std::string_view help, Presence presence);

  void add_slot(std::string_view name, FieldSlot slot, Range range, std::vector<std::string> choices,
                std::string_view help, Presence presence);

  FieldTable& table_;
  std::string prefix_;
};

/// The table of a configuration struct.
template <class T>
[[nodiscard]] FieldTable table_of(T& config) {
  FieldTable table;
  TableVisitor visitor(table);
  config.visit(visitor);
  return table;
}

/// The value that a field has now. Not for a list of structs.
[[nodiscard]] FieldValue value_of(const Field& field);

/// A std::vector of structs as a StructList; borrowed, or its own.
template <class T>
class StructVector final : public StructList {
 public:
  explicit StructVector(std::vector<T>& target) : items_(&target) {}
  explicit StructVector(std::size_t count) : own_(count), items_(&own_) {}
  StructVector(const StructVector&) = delete;
  StructVector& operator=(const StructVector&) = delete;

  [[nodiscard]] std::size_t size() const override { return items_->size(); }
  [[nodiscard]] FieldTable element(std::size_t index) override { return table_of(items_->at(index)); }
  [[nodiscard]] std::unique_ptr<StructList> fresh(std::size_t count) const override {
    return std::make_unique<StructVector>(count);
  }
  void take(StructList& other) override { *items_ = std::move(*static_cast<StructVector&>(other).items_); }

 private:
  std::vector<T> own_;
  std::vector<T>* items_;
};

template <class T>
void TableVisitor::add_list(std::string_view name, T& value, std::string_view help, Presence presence) {
  static_assert(
      requires { typename T::value_type; } &&
          requires(typename T::value_type & t, TableVisitor & v) { t.visit(v); },
      "a configuration field is bool, int, double, std::string, Vec3, std::vector<double>, "
      "std::optional<double>, std::optional<Vec3>, a struct with visit(), or a std::vector of such a struct");
  add_slot(name, std::make_shared<StructVector<typename T::value_type>>(value), kAny, {}, help, presence);
}

}  // namespace colift::hal
