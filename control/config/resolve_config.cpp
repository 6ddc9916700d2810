#include "control/config/resolve_config.hpp"

#include <fmt/format.h>

#include <utility>

#include "control/config/arm_mode.hpp"
#include "hal/config/config_file.hpp"
#include "hal/config/field_value.hpp"

namespace colift::control {
namespace {

constexpr const char* kMethod = "method";
constexpr const char* kSupport = "support";
constexpr const char* kShare = "decision.share";
constexpr const char* kEpsilon = "decision.weights.epsilon";
constexpr const char* kRecorded = "recorded config.yaml";

struct OwnDefaults {
  const char* origin;
  Config config;
};

OwnDefaults defaults_of(Command command) {
  switch (command) {
    case Command::Run:
    case Command::Replay:
      return {"run's default", run_defaults()};
    case Command::Experiment:
      return {"experiment's default", run_defaults()};
    case Command::SceneAnalysis:
    case Command::Decide:
    case Command::Calibrate:
    case Command::Hal:
      break;
  }
  return {"default", Config{}};
}

/// A --config, read once: it may be a pipe.
struct File {
  std::string name, text;
};

hal::Result<std::vector<File>> read_files(const std::vector<std::string>& names) {
  std::vector<File> files;
  for (const std::string& name : names) {
    auto text = hal::read_yaml_file(name);
    if (!text) return tl::unexpected(text.error());
    files.push_back({hal::quotable(name, 300), std::move(*text)});
  }
  return files;
}

/// A configuration in the making: one source of values after the other.
class Layers {
 public:
  Layers() = default;
  Layers(const Layers&) = delete;  // the table points into the configuration
  Layers& operator=(const Layers&) = delete;

  [[nodiscard]] const Config& config() const { return config_; }

  /// What the program itself says; only what it changes gets the origin.
  template <class Change>
  void program(const std::string& origin, Change change) {
    const std::vector<std::string> before = values();
    change(config_);
    const std::vector<std::string> after = values();
    for (std::size_t i = 0; i < before.size(); ++i)
      if (before[i] != after[i]) table_.fields()[i].origin = origin;
    epsilon_ = {config_.decision.weights.epsilon, table_.find(kEpsilon)->origin};
  }

  /// What a person or a recording says, by one call of hal/config.
  template <class Apply>
  hal::Result<> person(Apply apply) {
    hal::Field &share = *table_.find(kShare), &epsilon = *table_.find(kEpsilon);
    std::string share_before = std::exchange(share.origin, ""),
                epsilon_before = std::exchange(epsilon.origin, "");
    const hal::Result<> done = apply(table_);
    const bool said_share = !share.origin.empty(), said_epsilon = !epsilon.origin.empty();
    if (!said_share) share.origin = std::move(share_before);
    if (!said_epsilon) epsilon.origin = std::move(epsilon_before);
    if (!done) return done;
    return settle(share, epsilon, said_share, said_epsilon);
  }

  hal::Result<> files_and_settings(const std::vector<File>& files, const std::vector<std::string>& settings) {
    for (const File& file : files) {
      auto done = person([&](hal::FieldTable& t) { return hal::apply_yaml_text(t, file.text, file.name); });
      if (!done) return done;
    }
    for (const std::string& setting : settings) {
      auto done = person([&](hal::FieldTable& t) { return hal::apply_setting(t, setting); });
      if (!done) return done;
    }
    return {};
  }

  /// What the recording's text says, by a program that may have been older or newer than this one.
  hal::Result<> recorded(const RecordedConfig& run) {
    auto done = person([&](hal::FieldTable& t) {
      return hal::apply_yaml_text(t, run.yaml, kRecorded, hal::UnknownKeys::LeftOut);
    });
    if (!done) return done;
    // what the options of that run said, its text may not know
    program("recorded run", [&](Config& c) { c.method = to_string(run.method); });
    if (run.complete) return {};
    program("recorded run", [&](Config& c) {
      Config used;
      set_method_defaults(run.method, used);
      if (run.method != Method::Fast) c.candidates = used.candidates;
    });
    return {};
  }

  /// A recorded run with another method: what was a default of the one becomes the other's.
  void change_method(Method from, Method to) {
    Config old_defaults = run_defaults(), new_defaults = run_defaults();
    set_method_defaults(from, old_defaults);
    set_method_defaults(to, new_defaults);
    const hal::FieldTable old_table = hal::table_of(old_defaults), new_table = hal::table_of(new_defaults);
    program(fmt::format("method {}", to_string(to)), [&](Config&) {
      for (std::size_t i = 0; i < table_.fields().size(); ++i) {
        if (is_list(table_.fields()[i])) continue;
        if (text_at(table_, i) == text_at(old_table, i))
          hal::write_value(table_.fields()[i], hal::value_of(new_table.fields()[i]));
      }
    });
  }

  /// The thesis's method has no such choice: whoever asks for one is told so. A recorded run may have made it
  /// with another method.
  hal::Result<> check_support(Method method) const {
    const std::string& origin = table_.find(kSupport)->origin;
    if (method != Method::Thesis || config_.support != "table" || origin.starts_with(kRecorded)) return {};
    return hal::failure(hal::ErrorCode::BadConfig, origin,
                        "support = table goes with --method fast: the thesis takes the largest plane");
  }

  [[nodiscard]] hal::Result<> check() const { return hal::check_fields(table_); }

  [[nodiscard]] ResolvedConfig result() && {
    ResolvedConfig out;
    for (const hal::Field& field : table_.fields())
      if (field.origin != hal::kDefaultOrigin) out.origins.emplace(field.path, field.origin);
    out.warnings = std::move(table_.warnings);
    out.method = method_named(config_.method).value_or(Method::Fast);
    out.config = std::move(config_);
    return out;
  }

 private:
  struct Epsilon {
    double value = 1.0;
    std::string origin;
  };

  static bool is_list(const hal::Field& field) {
    return std::holds_alternative<std::shared_ptr<hal::StructList>>(field.slot);
  }
  static std::string text_at(const hal::FieldTable& table, std::size_t i) {
    return hal::value_text(hal::value_of(table.fields()[i]));
  }
  [[nodiscard]] std::vector<std::string> values() const {
    std::vector<std::string> out;
    for (std::size_t i = 0; i < table_.fields().size(); ++i)
      out.push_back(is_list(table_.fields()[i]) ? std::string() : text_at(table_, i));
    return out;
  }

  /// Of share and epsilon the one that was said last makes the other.
  hal::Result<> settle(hal::Field& share, hal::Field& epsilon, bool said_share, bool said_epsilon) {
    planner::DecisionConfig& d = config_.decision;
    if (said_epsilon) epsilon_ = {d.weights.epsilon, epsilon.origin};
    if (said_share && d.share) {
      const auto wanted = planner::epsilon_for_share(*d.share);
      if (!wanted)
        return hal::failure(hal::ErrorCode::BadConfig, share.origin,
                            fmt::format("{} {}", kShare, wanted.error().detail));
      if (said_epsilon && *wanted != d.weights.epsilon)
        return hal::failure(hal::ErrorCode::BadConfig, share.origin,
                            fmt::format("{} = {} and {} = {} contradict each other; expected one of them",
                                        kShare, *d.share, kEpsilon, d.weights.epsilon));
      d.weights.epsilon = *wanted;
      epsilon.origin = fmt::format("{} ({})", kShare, share.origin);
    } else if (said_epsilon) {
      if (d.share) share.origin = fmt::format("{} ({})", kEpsilon, epsilon.origin);
      d.share.reset();
    } else if (said_share) {  // ~: what was said before it
      d.weights.epsilon = epsilon_.value;
      epsilon.origin = epsilon_.origin;
    }
    return {};
  }

  Config config_;
  hal::FieldTable table_ = hal::table_of(config_);
  Epsilon epsilon_{config_.decision.weights.epsilon, std::string(hal::kDefaultOrigin)};  ///< But for a share.
};

/// The method is named in the same places as everything else, and its defaults come before them.
hal::Result<Method> find_method(const ConfigRequest& request, const std::vector<File>& files) {
  Layers first;
  if (request.recorded) {
    if (auto done = first.recorded(*request.recorded); !done) return tl::unexpected(done.error());
  }
  if (auto done = first.files_and_settings(files, request.settings); !done)
    return tl::unexpected(done.error());
  std::string name = first.config().method;
  for (const OptionValue& option : request.options)
    if (option.path == kMethod) name = option.value;
  // another name is refused when the option is applied
  return method_named(name).value_or(Method::Fast);
}

}  // namespace

hal::Result<ResolvedConfig> resolve_config(const ConfigRequest& request) {
  const auto files = read_files(request.files);
  if (!files) return tl::unexpected(files.error());
  const auto method = find_method(request, *files);
  if (!method) return tl::unexpected(method.error());

  Layers layers;
  OwnDefaults own = defaults_of(request.command);
  layers.program(own.origin, [&](Config& c) { c = std::move(own.config); });
  const Method first_method = request.recorded ? request.recorded->method : *method;
  layers.program(fmt::format("method {}", to_string(first_method)),
                 [&](Config& c) { set_method_defaults(first_method, c); });
  if (request.recorded) {
    if (auto done = layers.recorded(*request.recorded); !done) return tl::unexpected(done.error());
    if (*method != first_method) layers.change_method(first_method, *method);
  } else if (request.task) {
    layers.program(request.task->origin, [&](Config& c) {
      c.task.lift_height_m = request.task->lift_height_m;
      c.task.hold_s = request.task->hold_s;
    });
  }
  if (auto done = layers.files_and_settings(*files, request.settings); !done)
    return tl::unexpected(done.error());
  for (const OptionValue& o : request.options) {
    auto done = layers.person([&](hal::FieldTable& table) {
      return hal::apply_value(table, o.path, o.value, fmt::format("{} {}", o.option, o.value), o.option);
    });
    if (!done) return tl::unexpected(done.error());
  }
  layers.program("arm_mode t1", [](Config& c) { c = for_arm_mode(std::move(c)); });
  if (auto done = layers.check_support(*method); !done) return tl::unexpected(done.error());
  if (auto done = layers.check(); !done) return tl::unexpected(done.error());
  return std::move(layers).result();
}

std::string yaml_of(const ResolvedConfig& resolved, bool explain) {
  Config config = resolved.config;
  hal::FieldTable table = hal::table_of(config);
  for (hal::Field& field : table.fields())
    if (const auto found = resolved.origins.find(field.path); found != resolved.origins.end())
      field.origin = found->second;
  return hal::effective_yaml(table, explain);
}

}  // namespace colift::control
