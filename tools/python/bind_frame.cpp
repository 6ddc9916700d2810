#include <algorithm>
#include <cmath>

#include "sim_hal/synthetic/scenes.hpp"
#include "tools/cli/shipped_files.hpp"
#include "tools/python/bindings.hpp"
#include "tools/scenes/depth_file.hpp"

namespace colift::python {
namespace {

using Depth = py::array_t<float, py::array::c_style | py::array::forcecast>;
using Colour = py::array_t<std::uint8_t, py::array::c_style | py::array::forcecast>;

constexpr py::ssize_t kLargestSide = 8192, kMostPixels = 1 << 24;
constexpr float kFarthest_m = 100.0f;

// what is beyond any depth camera's range was not measured; mostly so: it is in other units
void clean(std::vector<float>& depth_m) {
  std::size_t near = 0, far = 0;
  for (float& d : depth_m) {
    if (std::isfinite(d) && d > kFarthest_m) ++far;
    if (!(d > 0.0f) || d > kFarthest_m)
      d = NAN;
    else
      ++near;
  }
  if (far > near) refuse("depth", "most values are more than 100; expected metres");
}

std::size_t measured(const std::vector<float>& depth_m) {
  return static_cast<std::size_t>(
      std::count_if(depth_m.begin(), depth_m.end(), [](float d) { return std::isfinite(d); }));
}

hal::CameraIntrinsics camera_of(int width, int height, const std::optional<std::array<double, 4>>& given) {
  hal::CameraIntrinsics k;
  if (!given && (width != k.width || height != k.height))
    refuse("intrinsics", "those of a Kinect are known for 640 x 480 pixels only; expected fx, fy, cx, cy");
  k.width = width;
  k.height = height;
  if (!given) return k;
  const auto [fx, fy, cx, cy] = *given;
  const auto within = [](double x, double low, double high) { return x >= low && x <= high; };
  if (!within(fx, 1.0, 1e5) || !within(fy, 1.0, 1e5))
    refuse("intrinsics", "expected fx and fy of 1 to 100000 pixels");
  if (!within(cx, 0.0, width) || !within(cy, 0.0, height))
    refuse("intrinsics", "expected cx and cy inside the image, in pixels");
  k.fx = fx;
  k.fy = fy;
  k.cx = cx;
  k.cy = cy;
  return k;
}

std::shared_ptr<Frame> frame_of(const py::array& depth, std::optional<std::array<double, 4>> intrinsics,
                                const std::optional<py::array>& rgb, const std::optional<hal::Vec3>& up) {
  if (depth.dtype().kind() != 'f')
    refuse("depth", "the type is " + py::str(depth.dtype()).cast<std::string>() +
                        "; expected float32 or float64, in metres");
  if (depth.ndim() != 2 || depth.shape(0) < 1 || depth.shape(1) < 1)
    refuse("depth", "expected an array of height x width, in metres, NaN where nothing was measured");
  if (depth.shape(0) > kLargestSide || depth.shape(1) > kLargestSide || depth.size() > kMostPixels)
    refuse("depth", "expected at most 8192 pixels along a side and 2^24 in all");
  auto made = std::make_shared<Frame>();
  hal::DepthFrame& f = made->frame;
  f.intrinsics = camera_of(static_cast<int>(depth.shape(1)), static_cast<int>(depth.shape(0)), intrinsics);
  const Depth depth_m(depth);
  if (!depth_m) throw py::error_already_set();
  f.depth_m.assign(depth_m.data(), depth_m.data() + depth_m.size());
  clean(f.depth_m);
  if (rgb) {
    if (rgb->dtype().kind() != 'u' || rgb->itemsize() != 1 || rgb->ndim() != 3 ||
        rgb->shape(0) != depth.shape(0) || rgb->shape(1) != depth.shape(1) || rgb->shape(2) != 3)
      refuse("rgb", "expected an array of uint8, height x width x 3, aligned with the depth");
    const Colour colour(*rgb);
    f.rgb.assign(colour.data(), colour.data() + colour.size());
  }
  if (up) {
    if (!up->allFinite() || std::abs(up->norm() - 1.0) > 1e-3) refuse("up", "expected a unit vector");
    f.up_C = *up;
  }
  made->points = f.depth_m.size();
  made->valid_points = measured(f.depth_m);
  made->note = "a frame made of arrays";
  return made;
}

sim_hal::ObjectKind kind_of(const std::string& name) {
  using sim_hal::ObjectKind;
  if (name == "table") return ObjectKind::Table;
  if (name == "box") return ObjectKind::Box;
  if (name == "pipe") return ObjectKind::Pipe;
  refuse("kind", "\"" + name + "\" is not known; expected table, box or pipe");
}

py::dict synthetic_scene(const std::string& kind, std::uint64_t seed, bool two_hands) {
  const sim_hal::ObjectKind object = kind_of(kind);
  auto before = std::make_shared<Frame>(), after = std::make_shared<Frame>();
  sim_hal::SyntheticScene room;
  sim_hal::PartnerPose person;
  {
    const Unlocked other_threads_run;
    room = sim_hal::make_scene(object, seed);
    person = sim_hal::make_partner(room, seed, two_hands);
    const auto film = [&](Frame& out, const sim_hal::World& world, std::uint64_t noise) {
      out.frame = sim_hal::measure(sim_hal::cast_rays(world, room.intrinsics, room.X_WC), {}, noise);
      out.points = out.frame.depth_m.size();
      out.valid_points = measured(out.frame.depth_m);
      out.note = "a synthetic frame with a Kinect's noise";
    };
    film(*before, room.world, seed);
    film(*after, sim_hal::with_partner(room.world, person), seed + 1);
  }
  py::dict out;
  out["frame"] = before;
  out["frame_with_partner"] = after;
  out["camera_pose"] = Eigen::Matrix4d(room.X_WC.matrix());
  out["contact"] = Eigen::Vector3d(person.contact);
  out["cog"] = Eigen::Vector3d(room.cog);
  return out;
}

}  // namespace

void bind_frame(py::module_& m) {
  py::class_<Frame, std::shared_ptr<Frame>>(m, "Frame", R"(A depth image of one camera.

Frame(depth, intrinsics=None, rgb=None, up=None) copies arrays; Frame.read(file) reads a recording. It never changes
afterwards, so many threads may look at one.

depth       height x width, float32 or float64, metres along the optical axis; NaN or 0 where nothing was measured
intrinsics  (fx, fy, cx, cy) in pixels, pixel centres at integer coordinates; None: a Kinect's, for 640 x 480
rgb         height x width x 3, uint8, aligned with the depth; None: unknown
up          unit vector against gravity in the camera's optical frame (x right, y down, z forward); None: unknown

Raises Error (bad-input) for another type, shape, unit or range.)")
      .def(py::init(&frame_of), py::arg("depth"), py::arg("intrinsics") = py::none(),
           py::arg("rgb") = py::none(), py::arg("up") = py::none())
      .def_static(
          "read",
          [](const std::string& file, const std::optional<std::string>& camera) {
            const Unlocked other_threads_run;
            std::optional<std::filesystem::path> camera_json;
            if (camera) camera_json = *camera;
            const auto path = value_of(tools::file_or_shipped(tools::ShippedKind::Scene, file));
            return std::make_shared<Frame>(value_of(hal::read_frame(path, camera_json)));
          },
          py::arg("file"), py::arg("camera") = py::none(),
          "Reads a 16-bit depth PNG (with `camera`, or camera.json beside it), a PCD or a PLY file, or a "
          "frame that is shipped, by its name (`colift scenes`). Raises Error (bad-input) with the place in "
          "the file.")
      .def(
          "write",
          [](const Frame& self, const std::string& png) {
            const Unlocked other_threads_run;
            value_of(tools::write_depth(png, self.frame));
          },
          py::arg("png"),
          "Writes the depth as a 16-bit PNG in millimetres, with camera.json beside it, as Frame.read and "
          "the program read them; without "
          "colour. Raises Error (bad-input) where that cannot be.")
      .def_property_readonly(
          "depth",
          [](const std::shared_ptr<Frame>& self) {
            const hal::DepthFrame& f = self->frame;
            return view(self, f.depth_m.data(), {f.intrinsics.height, f.intrinsics.width});
          },
          "height x width, float32, metres; NaN where nothing was measured. A read-only view, not a copy.")
      .def_property_readonly(
          "rgb",
          [](const std::shared_ptr<Frame>& self) -> py::object {
            const hal::DepthFrame& f = self->frame;
            if (f.rgb.empty()) return py::none();
            return view(self, f.rgb.data(), {f.intrinsics.height, f.intrinsics.width, 3});
          },
          "height x width x 3, uint8, a read-only view; None where the file has no colour.")
      .def_property_readonly(
          "intrinsics",
          [](const Frame& f) {
            const auto& k = f.frame.intrinsics;
            return py::make_tuple(k.fx, k.fy, k.cx, k.cy);
          },
          "(fx, fy, cx, cy) in pixels.")
      .def_property_readonly(
          "up", [](const Frame& f) { return f.frame.up_C; },
          "Unit vector against gravity in the optical frame; None: unknown.")
      .def_property_readonly(
          "time_s", [](const Frame& f) { return hal::seconds(f.frame.exposed_at); },
          "When it was exposed, on the clock of its camera (s).")
      .def_property_readonly(
          "X_FC", [](const Frame& f) { return Eigen::Matrix4d(f.X_FC.matrix()); },
          "The optical frame C in the file's own frame F, 4 x 4; another one than F where points were drawn "
          "by a "
          "virtual camera.")
      .def_readonly("note", &Frame::note, "What was done to make a depth image of the file.")
      .def("__repr__", [](const Frame& f) {
        return "<colift.Frame " + std::to_string(f.frame.intrinsics.width) + " x " +
               std::to_string(f.frame.intrinsics.height) + ", " + std::to_string(f.valid_points) +
               " pixels with depth>";
      });
  m.def("synthetic_scene", &synthetic_scene, py::arg("kind"), py::arg("seed"), py::arg("two_hands") = false);
}

}  // namespace colift::python
