#include <atomic>
#include <chrono>
#include <future>

#include "tools/experiments/campaign.hpp"
#include "tools/python/bindings.hpp"

namespace colift::python {
namespace {

using experiments::Experiment;

py::dict columns_of(const experiments::TrialTable& table) {
  py::dict out;
  for (std::size_t c = 0; c < table.columns().size(); ++c) {
    py::list column;
    for (const experiments::Row& row : table.rows()) column.append(c < row.size() ? row[c] : "");
    out[py::str(table.columns()[c])] = column;
  }
  return out;
}

py::list figures_of(const Experiment& e, const experiments::Campaign& campaign) {
  py::list out;
  for (const std::string& method : experiments::methods_of(campaign)) {
    const experiments::Campaign one = experiments::of_method(campaign, method);
    for (const experiments::Figure& f : e.figures({one.trials, one.details})) {
      py::dict d;
      d["method"] = method;
      d["key"] = f.key;
      d["name"] = f.name;
      d["value"] = f.estimate.value;
      d["interval"] = py::make_tuple(f.estimate.low, f.estimate.high);
      d["n"] = f.estimate.n;
      d["unit"] = f.unit;
      d["goal"] = f.goal;
      d["met"] = f.met();
      out.append(d);
    }
  }
  return out;
}

experiments::Methods methods_of(const std::string& word) {
  using experiments::Methods;
  for (const Methods m : {Methods::Fast, Methods::Thesis, Methods::Both})
    if (word == experiments::word(m)) return m;
  refuse("method", "\"" + word + "\" is not known; expected fast, thesis or both");
}

const Experiment& experiment_of(const std::string& name) {
  if (const Experiment* e = experiments::find_experiment(name)) return *e;
  std::string all;
  for (const Experiment& other : experiments::all_experiments())
    all += (all.empty() ? "" : ", ") + other.name;
  refuse("name", "\"" + name + "\" is no experiment; there are " + all);
}

// Trials run in threads of their own, so that this one, the interpreter's main thread as a rule, hears
// Ctrl-C.
py::dict run(const std::string& name, int trials, std::uint64_t seed, const std::string& method, int jobs,
             const std::string& out, const py::object& progress) {
  const Experiment& e = experiment_of(name);
  experiments::CampaignOptions options;
  options.trials = trials;
  options.seed = seed;
  options.jobs = jobs;
  options.out = out;
  options.methods = methods_of(method);
  if (trials < 0 || jobs < 0) refuse("trials", "the numbers of trials and jobs cannot be negative");
  std::optional<py::error_already_set> raised;  // with the interpreter's lock only
  std::atomic<bool> stop = false;
  experiments::CampaignHooks hooks;
  hooks.interrupted = [&] { return stop.load(); };
  hooks.progress = [&](const experiments::CampaignProgress& p) {
    const py::gil_scoped_acquire in_python;
    if (progress.is_none() || raised) return;
    try {
      progress(p.done, p.to_do, p.words);
    } catch (py::error_already_set& error) {
      raised.emplace(error);
      stop = true;
    }
  };
  constexpr auto kLook = std::chrono::milliseconds(50);
  auto running = std::async(std::launch::async, [&] { return experiments::run_campaign(e, options, hooks); });
  for (bool done = false; !done;) {
    {
      const Unlocked trials_run;
      done = running.wait_for(kLook) == std::future_status::ready;
    }
    if (raised || PyErr_CheckSignals() == 0) continue;
    raised.emplace();
    stop = true;
  }
  const auto campaign = running.get();
  if (raised) throw py::error_already_set(*raised);
  if (!campaign) throw Failure{campaign.error()};
  py::dict d;
  d["name"] = e.name;
  d["question"] = e.question;
  d["trials"] = columns_of(campaign->trials);
  d["details"] = columns_of(campaign->details);
  d["figures"] = figures_of(e, *campaign);
  return d;
}

}  // namespace

void bind_experiments(py::module_& m) {
  m.def("experiment", &run, py::arg("name"), py::arg("trials"), py::arg("seed"), py::arg("method"),
        py::arg("jobs"), py::arg("out"), py::arg("progress"));
  m.def("experiments", [] {
    py::list out;
    for (const Experiment& e : experiments::all_experiments())
      out.append(py::make_tuple(e.name, e.title, e.question));
    return out;
  });
}

}  // namespace colift::python
