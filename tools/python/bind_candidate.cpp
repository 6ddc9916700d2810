#include <fmt/format.h>

#include "perception/scene.hpp"
#include "planner/grasp/grasp_candidates.hpp"
#include "tools/analyse/words.hpp"
#include "tools/python/bindings.hpp"

namespace colift::python {

using perception::PartnerGrasp;
using planner::GraspCandidate;

void bind_candidate(py::module_& m) {
  py::class_<GraspCandidate>(m, "Candidate", R"(A pose of the hand that may grasp the object; frame W, m.

Candidate(position, approach, closing, width, depth_m=0) is one of your own: it has a verdict once it is given to
Analysis.candidates, Analysis.judge or a run.

position    grasp point on the object's surface
approach    unit vector in which the palm moves
closing     unit vector along which the fingers close; perpendicular to approach
width       extent of the object between the fingers (m)
depth_m     how far behind the grasp point, along approach, the pads press: there the load hangs)")
      .def(py::init([](const hal::Vec3& position, const hal::Vec3& approach, const hal::Vec3& closing,
                       double width, double depth_m) {
             GraspCandidate c;
             c.position = position;
             c.approach = approach;
             c.closing = closing;
             c.width = width;
             c.depth_m = depth_m;
             return c;
           }),
           py::arg("position"), py::arg("approach"), py::arg("closing"), py::arg("width"),
           py::arg("depth_m") = 0.0)
      .def_readonly("id", &GraspCandidate::id, "Its number in documents and sentences.")
      .def_property_readonly(
          "kind", [](const GraspCandidate& c) { return planner::name_of(c.kind); },
          "\"ega5\" along the normal of a narrow face, \"edge\" over a rim, \"wrap\" around a cylinder.")
      .def_property(
          "position", [](const GraspCandidate& c) { return hal::Vec3(c.position); },
          [](GraspCandidate& c, const hal::Vec3& p) { c.position = p; }, "Grasp point (W, m).")
      .def_property(
          "approach", [](const GraspCandidate& c) { return hal::Vec3(c.approach); },
          [](GraspCandidate& c, const hal::Vec3& v) { c.approach = v; }, "Unit vector, W.")
      .def_property(
          "closing", [](const GraspCandidate& c) { return hal::Vec3(c.closing); },
          [](GraspCandidate& c, const hal::Vec3& v) { c.closing = v; }, "Unit vector, W.")
      .def_readwrite("width", &GraspCandidate::width, "Extent of the object between the fingers (m).")
      .def_readwrite("depth_m", &GraspCandidate::depth_m, "Where the pads press, behind the grasp point (m).")
      .def_readonly("surface", &GraspCandidate::surface, "Index of its surface in the document; -1: of none.")
      .def_readonly("stability", &GraspCandidate::stability,
                    "By which factor the load may grow before it slips; None where it is assumed.")
      .def_property_readonly(
          "verdict", [](const GraspCandidate& c) { return tools::word(c.verdict); },
          "\"ok\", \"chosen\", or why not: \"collision\", \"unreachable\", \"too-wide\", \"unstable\", "
          "\"over-limit\", \"near-partner\".")
      .def_readonly("reason", &GraspCandidate::reason, "The verdict in a sentence, with figures.")
      .def("__repr__", [](const GraspCandidate& c) {
        return fmt::format("<colift.Candidate {} at ({:.3f}, {:.3f}, {:.3f}) m: {}>", c.id, c.position.x(),
                           c.position.y(), c.position.z(), tools::word(c.verdict));
      });
  py::class_<PartnerGrasp>(m, "PartnerGrasp", R"(Where the partner holds the object.

position    W, m
covariance  3 x 3, m^2, symmetric; None: zero, the place is known exactly
points      changed points of the image that an estimate of CoLift's rests on; 0 for one of yours)")
      .def(py::init([](const hal::Vec3& position, const std::optional<Eigen::Matrix3d>& covariance) {
             PartnerGrasp g;
             g.position = position;
             if (covariance) g.covariance = *covariance;
             return g;
           }),
           py::arg("position"), py::arg("covariance") = py::none())
      .def_property_readonly(
          "position", [](const PartnerGrasp& g) { return hal::Vec3(g.position); }, "W, m.")
      .def_property_readonly(
          "covariance", [](const PartnerGrasp& g) { return Eigen::Matrix3d(g.covariance); }, "3 x 3, m^2.")
      .def_readonly("points", &PartnerGrasp::points, "Changed points that it rests on.")
      .def("__repr__", [](const PartnerGrasp& g) {
        return fmt::format("<colift.PartnerGrasp at ({:.3f}, {:.3f}, {:.3f}) m>", g.position.x(),
                           g.position.y(), g.position.z());
      });
}

}  // namespace colift::python
