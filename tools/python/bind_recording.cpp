#include <mutex>
#include <set>

#include "tools/python/bindings.hpp"
#include "tools/telemetry/channels/recorded_frame.hpp"
#include "tools/telemetry/mcap/mcap_reader.hpp"

namespace colift::python {
namespace {

/// One file, read by one thread at a time.
struct PyRecording {
  telemetry::McapReader reader;
  mutable std::mutex reading = {};
};

struct PyMessages {
  std::shared_ptr<const PyRecording> recording;
  telemetry::McapReader::Cursor cursor;
};

/// Frames of a recording, one after the other.
struct PyFrames {
  std::shared_ptr<const PyRecording> recording;
  telemetry::McapReader::Cursor cursor;
  telemetry::FrameJoiner joiner;
};

std::shared_ptr<PyRecording> open_recording(const std::string& file) {
  const Unlocked other_threads_run;
  auto source = value_of(telemetry::open_file(file));
  return std::shared_ptr<PyRecording>(
      new PyRecording{value_of(telemetry::McapReader::open(std::move(source), file))});
}

py::dict info_of(const PyRecording& r) {
  const telemetry::McapInfo& info = r.reader.info();
  py::dict topics;
  for (const auto& [id, channel] : info.channels) {
    const auto count = info.statistics.per_channel.find(id);
    const auto schema = info.schemas.find(channel.schema_id);
    py::dict topic;
    topic["messages"] = count == info.statistics.per_channel.end() ? 0 : count->second;
    topic["encoding"] = channel.message_encoding;
    topic["schema"] = schema == info.schemas.end() ? "" : schema->second.name;
    topics[py::str(channel.topic)] = topic;
  }
  py::list attachments;
  for (const auto& a : info.attachments) attachments.append(a.name);
  py::dict out;
  out["topics"] = topics;
  out["attachments"] = attachments;
  out["start_ns"] = info.statistics.start_time;
  out["end_ns"] = info.statistics.end_time;
  out["complete"] = info.complete;
  out["damage"] = info.damage;
  return out;
}

// Cursors read the same file: each call has it for itself. Never waits for it with the interpreter's lock.
py::tuple next_message(PyMessages& m) {
  const auto& info = m.recording->reader.info();
  std::string data;
  std::uint64_t at_ns = 0;
  const telemetry::Channel* channel = nullptr;
  {
    const Unlocked other_threads_run;
    const std::lock_guard alone(m.recording->reading);
    while (channel == nullptr) {
      const auto message = m.cursor.next();
      if (!message) break;
      const auto found = info.channels.find(message->channel_id);
      if (found == info.channels.end()) continue;
      channel = &found->second;
      data = message->data;
      at_ns = message->log_time;
    }
  }
  if (channel == nullptr) throw py::stop_iteration();
  return py::make_tuple(channel->topic, at_ns, py::bytes(data), channel->message_encoding);
}

py::tuple next_frame(PyFrames& f) {
  const auto& info = f.recording->reader.info();
  std::shared_ptr<Frame> frame;
  std::uint64_t number = 0, at_ns = 0;
  {
    const Unlocked other_threads_run;
    const std::lock_guard alone(f.recording->reading);
    while (!frame) {
      const auto part = f.cursor.next();
      if (!part) break;
      const auto channel = info.channels.find(part->channel_id);
      if (channel == info.channels.end()) continue;
      const auto encoded = f.joiner.add(channel->second.topic, part->data);
      if (!encoded) continue;
      telemetry::NumberedFrame decoded = value_of(telemetry::decode_frame(*encoded));
      frame = std::make_shared<Frame>();
      frame->frame = std::move(decoded.frame);
      frame->points = frame->frame.depth_m.size();
      for (const float d : frame->frame.depth_m) frame->valid_points += d > 0.0f ? 1 : 0;
      frame->note = "frame " + std::to_string(decoded.number) + " of a recording";
      number = decoded.number;
      at_ns = part->log_time;
    }
  }
  if (!frame) throw py::stop_iteration();
  return py::make_tuple(number, at_ns, frame);
}

py::bytes attachment(const PyRecording& r, const std::string& name) {
  const telemetry::Attachment found = [&] {
    const Unlocked other_threads_run;
    const std::lock_guard alone(r.reading);
    return value_of(r.reader.attachment(name));
  }();
  return {found.data.data(), found.data.size()};
}

}  // namespace

void bind_recording(py::module_& m) {
  py::class_<PyMessages>(m, "Messages")
      .def("__iter__", [](py::object self) { return self; })
      .def("__next__", &next_message);
  py::class_<PyFrames>(m, "Frames")
      .def("__iter__", [](py::object self) { return self; })
      .def("__next__", &next_frame);
  py::class_<PyRecording, std::shared_ptr<PyRecording>>(m, "Recording")
      .def(py::init(&open_recording), py::arg("file"))
      .def_property_readonly("info", &info_of)
      .def("attachment", &attachment, py::arg("name"))
      .def(
          "messages",
          [](const std::shared_ptr<PyRecording>& r, const std::set<std::string>& topics) {
            return PyMessages{r, r->reader.messages(topics)};
          },
          py::arg("topics"))
      .def("frames", [](const std::shared_ptr<PyRecording>& r) {
        return PyFrames{r, r->reader.messages({"/camera/frame", "/camera/color", "/camera/depth"}), {}};
      });
}

}  // namespace colift::python
